// SPDX-License-Identifier: MIT
//
// test_wasm.mjs - tests the runtime as WebAssembly (runtime/web/wasm) in a headless Chromium: pixels
// against the C runtime with the same camera and light, errors, several canvases, lost contexts,
// and what a page has to fetch. Skipped where emscripten is not installed. PHONGSPLAT_CONVERTED is
// the directory of the bundled models, converted; PHONGSPLAT_DRAW_NATIVE the program of draw_native.c.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { gzipSync } from 'node:zlib';
import { drawNative, here, launch, open, psnr, questionsOf, reduce, rgbOf, serve } from './browser.mjs';

const converted = process.env.PHONGSPLAT_CONVERTED ?? '', program = process.env.PHONGSPLAT_DRAW_NATIVE, root = join(here, '../..');
const wasm = join(root, 'runtime/web/wasm'), dist = join(root, 'build/wasm/dist'), state = {};

// What the runtime calls, gl.js has: no browser and no compiler are needed to see that.
const header = readFileSync(join(root, 'runtime/gl/gl_api.h'), 'utf8'), glue = readFileSync(join(wasm, 'gl.js'), 'utf8');
const missing = [...header.matchAll(/^ {4}X\([^,]+, (\w+),/gm)].map(([, name]) => name).filter((name) => !new RegExp(`^ {8}${name}[:(]`, 'm').test(glue));
assert.deepEqual(missing, [], 'GL functions that gl.js lacks');

const NOT_POSSIBLE = 3; // of build.sh: emscripten or the sources that it takes are missing
const built = spawnSync(join(wasm, 'build.sh'), { encoding: 'utf8' });
if (built.status === NOT_POSSIBLE) {
    console.log(`skipped: ${built.stderr.trim().split('\n').at(-1)}`);
    process.exit(77);
}
assert.equal(built.status, 0, built.stdout + built.stderr);

const scratch = mkdtempSync(join(tmpdir(), 'phongsplat-wasm-'));

before(async () => {
    writeFileSync(join(scratch, 'page.html'), `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><script type="module">
        import * as splats from '/dist/phong-splats.js';
        const fetchBytes = async (url) => (await fetch(url)).arrayBuffer();
        const makeCanvas = (width, height) => {
            const canvas = Object.assign(document.createElement('canvas'), { width, height });
            document.body.append(canvas);
            return canvas;
        };
        const create = (width = 960, height = 720) => splats.PhongSplatsRenderer.create(makeCanvas(width, height), { attributes: { preserveDrawingBuffer: true } });
        const pixels = ({ gl }) => {
            const { drawingBufferWidth: width, drawingBufferHeight: height } = gl, rgba = new Uint8Array(4 * width * height), rows = [];
            gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
            for (let y = height - 1; y >= 0; --y) {
                const row = [];
                for (let x = 0; x < width; ++x) for (let k = 0; k < 3; ++k) row.push(rgba[4 * (y * width + x) + k]);
                rows.push(String.fromCharCode(...row));
            }
            return { width, height, rgb: btoa(rows.join('')), error: gl.getError() };
        };
        const around = (model, aspect = 4 / 3, azimuth = 0.52, elevation = 0.35) => {
            const distance = model.radius / Math.sin(0.2356), { sin, cos } = Math;
            const eye = [sin(azimuth) * cos(elevation), sin(elevation), cos(azimuth) * cos(elevation)].map((x, k) => model.center[k] + distance * x);
            return { view: splats.lookAt(eye, model.center), projection: splats.perspective(27, aspect, distance - 1.01 * model.radius, distance + 1.01 * model.radius) };
        };
        // Mesa's software rasteriser filters without anisotropy, and so does what is compared with it.
        const { getExtension } = WebGL2RenderingContext.prototype;
        WebGL2RenderingContext.prototype.getExtension = function (name) { return name.includes('anisotropic') ? null : getExtension.call(this, name); };
        const shared = await create();
        const refused = async (f) => f().then(() => 'accepted', ({ name, message, code }) => ({ name, message, code }));
        Object.assign(window, { splats, fetchBytes, create, pixels, around, shared, refused });
        document.title = 'ready';
    </script>`);
    state.server = await serve({ dist, scratch, files: converted, schema: join(root, 'schema'), corpus: join(root, 'tests/corpus') });
    state.browser = await launch();
    state.page = await open(state.browser, `${state.server.address}/scratch/page.html`);
    await state.page.waitForFunction('document.title === "ready"');
});

after(async () => {
    await state.browser?.close();
    state.server?.close();
    rmSync(scratch, { recursive: true });
});

async function inPage(f, argument) {
    const result = await state.page.evaluate(f, argument);
    assert.deepEqual(state.page.errors.splice(0), []);
    return result;
}

const files = ['part', 'torus', 'tiled', 'still-life', 'painted', 'bracket'].map((name) => [`files/${name}.glb`, join(converted, `${name}.glb`)]);
files.push(...['minimal', 'integers', 'curved', 'textured'].map((name) => [`schema/${name}.gltf`, join(root, `schema/${name}.gltf`)]));

for (const [url, path] of files) {
    test(`${url} as the C runtime draws it`, async () => {
        for (const shading of ['normal', 'lit', 'unlit']) {
            const picture = await inPage(async ([at, name]) => {
                const model = await window.shared.open(await window.fetchBytes(at)), camera = window.around(model);
                window.shared.draw(model, { ...camera, shading: name });
                model.dispose();
                return { ...window.pixels(window.shared), ...camera };
            }, [`/${url}`, shading]);
            assert.equal(picture.error, 0);
            const native = drawNative(program, path, join(scratch, 'native.ppm'), picture, shading);
            const decibels = psnr(reduce(rgbOf(picture), 960, 720), reduce(native, 960, 720));
            console.log(`${url} ${shading}: ${decibels.toFixed(1)} dB`);
            assert.ok(decibels >= 50, `${shading}: ${decibels} dB`); // outlines differ, where two rasterisers round
        }
    });
}

test('items are drawn in poses of their own, as the C runtime draws them', async () => {
    const path = join(converted, 'clockwork.glb');
    const found = await inPage(async () => {
        const model = await window.shared.open(await window.fetchBytes('/files/clockwork.glb'));
        Object.assign(window, { clockwork: model, pose: model.createPose() });
        return { animations: model.animations, second: model.createPose() !== window.pose };
    });
    assert.deepEqual(found.animations.map(({ name }) => name), ['tick', 'bounce', 'turn']);
    assert.ok(found.second && found.animations.every(({ duration }) => duration > 0), JSON.stringify(found));
    // Drawn at a time of each, and at rest again.
    for (const [index, time] of [[0, 0.6], [1, 0.25], [2, 2.5], [0, -1]]) {
        const picture = await inPage(async ([animation, seconds]) => {
            const { clockwork: model, pose } = window, camera = window.around(model);
            if (seconds < 0) pose.rest();
            else pose.set(animation, seconds);
            window.shared.draw({ model, pose }, { ...camera, shading: 'normal' });
            return { ...window.pixels(window.shared), ...camera };
        }, [index, time]);
        const against = (pose) => psnr(reduce(rgbOf(picture), 960, 720), reduce(drawNative(program, path, join(scratch, 'native.ppm'), picture, 'normal', pose), 960, 720));
        const posed = against(time < 0 ? [] : [index, time]), other = against(time < 0 ? [0, 0.6] : []);
        console.log(`clockwork, ${time < 0 ? 'at rest' : `animation ${index} at ${time} s`}: ${posed.toFixed(1)} dB`);
        assert.ok(posed >= 50, `${posed} dB`); // outlines differ, where two rasterisers round
        assert.ok(other < posed - 10, `in another pose it would be ${other} dB`);
    }
});

test('poses that cannot be are refused', async () => {
    const found = await inPage(async () => {
        const { shared, clockwork: model, pose, refused } = window, still = await shared.open(await window.fetchBytes('/files/part.glb')), camera = window.around(model), list = [
            await refused(async () => pose.set(3, 0)),
            await refused(async () => pose.set(0, NaN)),
            await refused(async () => still.createPose()),
            await refused(async () => shared.draw({ model: still, pose }, camera)),
        ];
        still.dispose();
        model.dispose();
        model.dispose();
        list.push(await refused(async () => pose.set(0, 0)), await refused(async () => shared.draw({ model: await shared.open(await window.fetchBytes('/files/clockwork.glb')), pose }, camera)));
        return list.map(({ name, message }) => `${name}: ${message}`);
    });
    const disposed = /PhongSplatsError: a model, a pose or the renderer was disposed/;
    for (const [k, message] of [/animation/, /finite/, /no animations/, /of another model/, disposed, disposed].entries()) assert.match(found[k], message);
});

test('for 100 kB, compressed, a page has all', () => {
    const sizes = ['phong-splats.wasm', 'phong-splats.js', 'gl.js'].map((name) => gzipSync(readFileSync(join(dist, name)), { level: 9 }).length);
    console.log(`gzipped: ${sizes.join(' + ')} bytes`);
    assert.ok(sizes.reduce((a, b) => a + b) <= 100000, String(sizes));
});

test('errors are exceptions with the text of the runtime', async () => {
    const found = await inPage(async () => {
        const bytes = new Uint8Array(await window.fetchBytes('/files/part.glb')), text = new TextEncoder().encode('{"asset":{"version":"2.0"}}');
        const model = await window.shared.open(bytes), { shared, refused } = window, camera = window.around(model), list = [
            await refused(() => shared.open(bytes.slice(0, 200))),
            await refused(() => shared.open(text)),
            await refused(() => shared.open(new ArrayBuffer(0))),
            await refused(async () => shared.draw(model, { ...camera, shading: 'pretty' })),
            await refused(async () => shared.draw(model, { ...camera, view: [1, 2] })),
            await refused(async () => shared.draw(model, { ...camera, lights: [{ color: [-1, 0, 0] }] })),
        ];
        model.dispose();
        model.dispose();
        list.push(await refused(async () => shared.draw(model, camera)));
        return list;
    });
    for (const [k, message] of [/GLB/, /no primitive of the file has the extension/, /./, /unknown shading pretty/, /16 numbers/, /light/, /was disposed/].entries()) {
        assert.equal(found[k].name, 'PhongSplatsError', JSON.stringify(found[k]));
        assert.match(found[k].message, message);
    }
});

test('lights, shadows, transforms and several models', async () => {
    const found = await inPage(async () => {
        const { shared } = window, model = await shared.open(await window.fetchBytes('/files/torus.glb')), camera = window.around(model), r = 0.5 * model.radius;
        const sum = () => [...atob(window.pixels(shared).rgb)].reduce((total, c) => total + c.charCodeAt(0), 0);
        const move = (x, y) => ({ model, transform: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, x, y, 0, 1] }), sums = [];
        const light = { direction: [0.2, -1, -0.3], color: [3, 3, 3], castsShadow: true };
        for (const items of [[], move(-r, 0), [move(-r, 0), move(r, 0)]]) {
            shared.draw(items, camera);
            sums.push(sum());
        }
        for (const castsShadow of [false, true]) {
            shared.draw([move(0, -r), move(0.1 * r, r)], { ...camera, lights: [{ ...light, castsShadow }] });
            sums.push(sum());
        }
        model.dispose();
        return sums;
    });
    const [none, one, two, bright, dark] = found;
    assert.equal(none, 0);
    assert.ok(one > 1e6 && two > 1.5 * one && two < 3 * one, JSON.stringify(found));
    assert.ok(dark < 0.99 * bright && dark > 0.2 * bright, JSON.stringify(found));
});

test('frames ask WebGL for nothing, so that pages do not wait', async () => {
    const made = await questionsOf(state.page, '() => window.create(64, 64)');
    assert.ok(made.asked.includes('getParameter'), String(made.asked)); // so that questions are heard
    await inPage(async () => {
        window.torus = await window.shared.open(await window.fetchBytes('/files/torus.glb'));
        window.drawTorus = () => {
            const light = { direction: [0.2, -1, -0.3], castsShadow: true };
            window.shared.draw(window.torus, { ...window.around(window.torus), lights: [light] });
        };
        window.drawTorus(); // makes programs and targets, and asks whether GL takes them
    });
    const { asked, waited } = await questionsOf(state.page, '() => { for (let i = 0; i < 5; ++i) window.drawTorus(); }');
    await inPage(() => window.torus.dispose());
    assert.deepEqual([asked, waited], [[], 0]);
});

test('canvases are independent, and a renderer frees what it has', async () => {
    const found = await inPage(async () => {
        const [a, b] = [await window.create(200, 150), await window.create(200, 150)], bytes = await window.fetchBytes('/files/tiled.glb');
        const models = [await a.open(bytes), await b.open(bytes)], camera = window.around(models[0]), made = new Map();
        a.draw(models[0], camera);
        const first = window.pixels(a).rgb;
        b.draw(models[1], { ...camera, shading: 'normal' });
        const other = window.pixels(b).rgb, foreign = await window.refused(async () => a.draw(models[1], camera));
        a.draw(models[0], camera);
        const same = first === window.pixels(a).rgb;
        for (const [name, by] of [['Texture', 1], ['Program', 1], ['Framebuffer', 1], ['Sampler', 1], ['VertexArray', 1]]) {
            const remove = b.gl[`delete${name}`];
            b.gl[`delete${name}`] = (object) => {
                made.set(name, (made.get(name) ?? 0) + by);
                remove.call(b.gl, object);
            };
        }
        b.dispose();
        b.dispose();
        return { same, differ: first !== other, foreign: foreign.message, freed: [...made.keys()].sort(), gone: (await window.refused(async () => b.draw([], camera))).message };
    });
    assert.deepEqual(found, { same: true, differ: true, foreign: 'a model, a pose or the renderer was disposed', freed: ['Framebuffer', 'Program', 'Sampler', 'Texture', 'VertexArray'], gone: 'a model, a pose or the renderer was disposed' });
});

test('a lost context is an error, and a new renderer on the canvas draws again', async () => {
    const found = await inPage(async () => {
        const renderer = await window.create(200, 150), bytes = await window.fetchBytes('/files/part.glb'), model = await renderer.open(bytes), camera = window.around(model);
        renderer.draw(model, camera);
        const first = window.pixels(renderer).rgb, { gl } = renderer, lose = gl.getExtension('WEBGL_lose_context');
        const wait = (name) => new Promise((resolve) => gl.canvas.addEventListener(name, (event) => { event.preventDefault(); setTimeout(resolve, 50); }, { once: true }));
        const lost = wait('webglcontextlost');
        lose.loseContext();
        await lost;
        const message = (await window.refused(async () => renderer.draw(model, camera))).message;
        renderer.dispose();
        const restored = wait('webglcontextrestored');
        lose.restoreContext();
        await restored;
        const again = await window.splats.PhongSplatsRenderer.create(gl.canvas), second = await again.open(bytes);
        again.draw(second, camera);
        return { message, same: first === window.pixels(again).rgb };
    });
    assert.deepEqual(found, { message: 'the GL context is lost', same: true });
});

test('the page in the README works as it stands', async () => {
    const [, example] = [...readFileSync(join(root, 'runtime/web/README.md'), 'utf8').matchAll(/```html\n([^]*?)```/g)].map(([, text]) => text);
    const local = example.replace('./phong-splats.js', '/dist/phong-splats.js').replace('model.glb', '/files/part.glb')
        .replace('create(canvas)', 'create(canvas, { attributes: { preserveDrawingBuffer: true } })').replace('</script>', "document.title = 'drawn';</script>");
    writeFileSync(join(scratch, 'index.html'), `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">${local}`);
    const page = await open(state.browser, `${state.server.address}/scratch/index.html`);
    await page.waitForFunction('document.title === "drawn"');
    const covered = await page.evaluate(() => {
        const gl = document.getElementById('canvas').getContext('webgl2'), rgba = new Uint8Array(4 * 960 * 720);
        gl.readPixels(0, 0, 960, 720, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
        return rgba.filter((value, k) => k % 4 === 0 && value > 20).length;
    });
    assert.ok(covered > 15000 && covered < 300000, String(covered));
    assert.deepEqual(page.errors, []);
    await page.close();
});
