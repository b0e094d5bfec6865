// SPDX-License-Identifier: MIT
//
// test_web.mjs - tests the package three-phong-splats in a headless Chromium: pixels against the C
// runtime with the same camera and light, and beside three's own meshes; shadows, raycasting, lost
// contexts, render targets, missing extensions, broken files. PHONGSPLAT_CONVERTED is the directory
// of the bundled models, converted; PHONGSPLAT_DRAW_NATIVE the program of draw_native.c.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { shaderNames } from '../../runtime/web/build.mjs';
import { drawNative, here, launch, open, psnr, questionsOf, reduce, rgbOf, serve } from './browser.mjs';

const converted = process.env.PHONGSPLAT_CONVERTED, program = process.env.PHONGSPLAT_DRAW_NATIVE;
const root = join(here, '../..'), scratch = mkdtempSync(join(tmpdir(), 'phongsplat-web-'));
const state = {};

before(async () => {
    state.server = await serve({
        modules: join(here, 'node_modules'), package: join(root, 'runtime/web'), tests: here, files: converted, schema: join(root, 'schema'),
        models: join(root, 'samples/models'), scratch, corpus: join(root, 'tests/corpus'),
    });
    state.browser = await launch();
    state.page = await openPage('three');
});

after(async () => {
    await state.browser?.close();
    state.server?.close();
    rmSync(scratch, { recursive: true });
});

async function openPage(three) {
    const page = await open(state.browser, `${state.server.address}/tests/page.html?three=${three}`);
    await page.waitForFunction('document.title === "ready"');
    return page;
}

/** Runs a function in the page and fails on what the page reports. */
async function inPage(f, argument, page = state.page) {
    const result = await page.evaluate(f, argument);
    assert.deepEqual(page.errors.splice(0), []);
    return result;
}

const draw = (options, page) => inPage((o) => window.page.draw(o), options, page);

/** Returns the PSNR of a picture of the page against the C runtime's, both averaged as `phongsplat
 *  render` does. */
function compare(picture, path, shading) {
    const native = drawNative(program, path, join(scratch, 'native.ppm'), picture, shading);
    return psnr(reduce(rgbOf(picture), picture.width, picture.height), reduce(native, picture.width, picture.height));
}

// ---- pixels ----------------------------------------------------------------------------------

const files = ['part', 'torus', 'tiled', 'still-life', 'painted', 'bracket'].map((name) => [`files/${name}.glb`, join(converted ?? '', `${name}.glb`)]);
files.push(...['minimal', 'integers', 'curved', 'textured', 'streamed'].map((name) => [`schema/${name}.gltf`, join(root, `schema/${name}.gltf`)]));
files.push(['corpus/12-seams.glb', join(root, 'tests/corpus/12-seams.glb')]);

// Two rasterisers round vertices differently, so that pixels on outlines differ; nothing else may.
const LEAST = 50;
for (const [url, path] of files) {
    for (const shading of ['normal', 'lit', 'unlit']) {
        test(`${url}, ${shading}, as the C runtime draws it`, async () => {
            const decibels = compare(await draw({ url: `/${url}`, shading }), path, shading);
            console.log(`${url} ${shading}: ${decibels.toFixed(1)} dB`);
            assert.ok(decibels >= LEAST, `${decibels} dB`);
        });
    }
}

test('files of every earlier state of the format are drawn as the C runtime draws them', async () => {
    const corpus = join(root, 'tests/corpus'), names = ['', 'compressed/'].flatMap((folder) => readdirSync(join(corpus, folder)).filter((name) => /\.gl(b|tf)$/.test(name)).map((name) => folder + name));
    assert.ok(names.length >= 20, String(names));
    for (const name of names) {
        const decibels = compare(await draw({ url: `/corpus/${name}`, shading: 'normal' }), join(corpus, name), 'normal');
        console.log(`${name}: ${decibels.toFixed(1)} dB`);
        assert.ok(decibels >= LEAST, `${name}: ${decibels} dB`);
    }
});

for (const shading of ['toon', 'depth', 'overdraw', 'splats']) {
    test(`the shading ${shading} is the C runtime's`, async () => {
        const decibels = compare(await draw({ url: '/files/torus.glb', shading }), join(converted, 'torus.glb'), shading);
        assert.ok(decibels >= 40, `${decibels} dB`);
    });
}

test('orthographic views, and views from so near that the near plane cuts', async () => {
    for (const options of [{ ortho: true }, { closeness: 0.35, elevation: 5 }, { closeness: 0.1, azimuth: 80 }]) {
        for (const name of ['part', 'torus']) {
            const decibels = compare(await draw({ url: `/files/${name}.glb`, shading: 'normal', ...options }), join(converted, `${name}.glb`), 'normal');
            assert.ok(decibels >= 45, `${name} ${JSON.stringify(options)}: ${decibels} dB`);
        }
    }
});

test('the oldest release of three.js that is supported draws the same', async () => {
    const page = await openPage('three-oldest');
    for (const [url, path] of files) {
        const decibels = compare(await draw({ url: `/${url}`, shading: 'lit' }, page), path, 'lit');
        assert.ok(decibels >= LEAST, `${url}: ${decibels} dB`);
    }
    await page.close();
});

// Under one light three's material differs from the specification's by what it adds for light that
// is reflected several times, and by no specular part of ambient light.
test("three's material lights splats as the C runtime does, but for details of the material", async () => {
    const picture = await draw({ url: '/files/part.glb', shading: 'three', material: { metalness: 0, roughness: 1 } });
    const decibels = compare(picture, join(converted, 'part.glb'), 'lit');
    assert.ok(decibels >= 38, `${decibels} dB`);
});

/** Draws a source of triangles as the page draws splats. */
function drawMesh({ url, azimuth, elevation }) {
    return (async () => {
        const root = (await window.loader.loadAsync(url)).scene, scene = new window.THREE.Scene().add(root), renderer = window.rendererOf();
        const camera = new window.THREE.PerspectiveCamera();
        camera.projectionMatrix.fromArray(window.lastCamera.projection);
        camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
        camera.matrixWorldInverse.fromArray(window.lastCamera.view);
        camera.matrixWorld.copy(camera.matrixWorldInverse).invert();
        camera.matrixWorldAutoUpdate = false;
        window.removeLights(root);
        window.addLight(scene, camera);
        renderer.render(scene, camera);
        return window.pixels(renderer);
    })();
}

for (const [name, source, least] of [['tiled', 'tiled.glb', 20], ['still-life', 'still-life.glb', 22], ['bracket', 'bracket.gltf', 40]]) {
    test(`${name} beside three's own mesh of the source`, async () => {
        const picture = await draw({ url: `/files/${name}.glb`, shading: 'three' });
        await inPage((camera) => { window.lastCamera = camera; }, { view: picture.view, projection: picture.projection });
        const mesh = await inPage(drawMesh, { url: `/models/${source}` }), by = [picture.width, picture.height];
        const decibels = psnr(reduce(rgbOf(picture), ...by), reduce(rgbOf(mesh), ...by));
        console.log(`${name} beside the mesh: ${decibels.toFixed(1)} dB`);
        assert.ok(decibels >= least, `${decibels} dB`);
    });
}

// ---- what three.js does with objects ---------------------------------------------------------

test('shadows are cast and received, and splats cast none on themselves', async () => {
    const found = await inPage(async () => {
        const stage = await window.makeStage({ url: '/files/torus.glb', environment: false }), { renderer, scene, camera, root, meshes, bottom } = stage;
        const sample = (point) => {
            const gl = renderer.getContext(), at = point.clone().project(camera), out = new Uint8Array(4);
            renderer.render(scene, camera);
            gl.readPixels(Math.round((at.x * 0.5 + 0.5) * 960), Math.round((at.y * 0.5 + 0.5) * 720), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, out);
            return out[0];
        };
        // Along the light from points of the torus to the floor, and from the knot to the torus.
        const ray = new window.THREE.Raycaster(), toLight = stage.lamp.position.clone().normalize();
        root.updateMatrixWorld(true);
        meshes[1].updateMatrixWorld(true);
        const floor = [], on = [];
        for (let k = 0; k < 1600; ++k) {
            const p = new window.THREE.Vector3(((k % 40) - 19.5) / 12, bottom + 1e-3, (Math.floor(k / 40) - 19.5) / 12);
            ray.set(p, toLight);
            if (ray.intersectObject(root, true).length && !ray.intersectObjects([meshes[1], meshes[2]]).length) {
                ray.set(camera.position, p.clone().sub(camera.position).normalize());
                if (!ray.intersectObjects([root, meshes[1], meshes[2]], true).length) floor.push(p);
            }
            ray.setFromCamera(new window.THREE.Vector2((k % 40) / 20 - 0.97, Math.floor(k / 40) / 20 - 0.97), camera);
            const hit = ray.intersectObject(root, true)[0];
            // Where the light does not fall, or at a flat angle, there is no shadow to see.
            if (!hit || hit.normal.dot(toLight) < 0.3 || ray.intersectObjects([meshes[1], meshes[2]]).length) continue;
            ray.set(hit.point.clone().addScaledVector(hit.normal, 1e-3), toLight);
            if (ray.intersectObject(meshes[1]).length) on.push(hit.point);
        }
        floor.length = Math.min(floor.length, 12);
        on.length = Math.min(on.length, 12);
        const cast = floor.map(sample), received = on.map(sample);
        window.eachSplats(root, (o) => { o.castShadow = false; });
        const castOff = floor.map(sample);
        window.eachSplats(root, (o) => { o.castShadow = true; });
        meshes[1].castShadow = false;
        const receivedOff = on.map(sample);
        renderer.dispose();
        return { cast, castOff, received, receivedOff };
    });
    const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;
    assert.ok(found.cast.length >= 10 && found.received.length >= 2, JSON.stringify([found.cast.length, found.received.length]));
    assert.ok(mean(found.cast) < 0.6 * mean(found.castOff), `cast: ${mean(found.cast)} of ${mean(found.castOff)}`);
    assert.ok(mean(found.received) < 0.8 * mean(found.receivedOff), `received: ${mean(found.received)} of ${mean(found.receivedOff)}`);
});

test('frames ask WebGL for nothing, so that pages do not wait', async () => {
    const made = await questionsOf(state.page, `async () => {
        window.stage = await window.makeStage({ url: '/files/still-life.glb' });
        for (let i = 0; i < 2; ++i) window.stage.renderer.render(window.stage.scene, window.stage.camera); // makes programs and targets
    }`);
    assert.ok(made.asked.includes('getParameter'), String(made.asked)); // so that questions are heard
    const { asked, waited } = await questionsOf(state.page, '() => { for (let i = 0; i < 5; ++i) window.stage.renderer.render(window.stage.scene, window.stage.camera); }');
    await inPage(() => window.stage.renderer.dispose());
    assert.deepEqual([asked, waited], [[], 0]);
});

test('a surface that faces the light has no specks of shadow', async () => {
    // Fine splats leave the crease alone, where coarse ones round it.
    execFileSync(process.env.PHONGSPLAT, ['convert', join(root, 'samples/models/part.obj'), join(scratch, 'fine.glb'), '-t', '0.2', '--effort', '0', '-q']);
    for (const light of ['directional', 'spot', 'point']) {
        const differing = await inPage(async (kind) => {
            const { renderer, scene, camera, root, meshes } = await window.makeStage({ url: '/scratch/fine.glb', environment: false, light: kind });
            scene.remove(meshes[1], meshes[2]);
            const p = [];
            for (const receives of [true, false]) {
                window.eachSplats(root, (o) => { o.receiveShadow = receives; });
                renderer.render(scene, camera);
                p.push(window.pixels(renderer).rgb);
            }
            renderer.dispose();
            return p;
        }, light);
        const [a, b] = differing.map((text) => Buffer.from(text, 'base64')), dark = [];
        for (let i = 0; i < a.length; i += 3) if (b[i] - a[i] > 20) dark.push(i / 3);
        // Specks are dark pixels without dark neighbours; shadows are areas. Where a wall that faces away from the light meets
        // the floor, a shadow of less than a pixel begins.
        const set = new Set(dark), alone = dark.filter((i) => ![i - 1, i + 1, i - 960, i + 960].some((k) => set.has(k)));
        assert.ok(dark.length > 500 && alone.length <= 5, `${light}: ${alone.length} specks among ${dark.length} pixels in shadow`);
    }
});

test('rays hit splats where they hit the mesh', async () => {
    const found = await inPage(async () => {
        const splats = (await window.loader.loadAsync('/files/bracket.glb')).scene, mesh = (await window.loader.loadAsync('/models/bracket.gltf')).scene;
        const [inside, around] = [mesh, splats].map((root) => new window.THREE.Box3().setFromObject(root, true));
        const offset = Math.max(inside.min.distanceTo(around.min), inside.max.distanceTo(around.max)) / inside.getSize(new window.THREE.Vector3()).length();
        for (const root of [splats, mesh]) {
            root.rotation.set(0.3, 0.4, 0.5);
            root.scale.set(2, 3, 1.5);
            root.updateMatrixWorld(true);
        }
        const box = new window.THREE.Box3().setFromObject(mesh, true);
        const camera = window.cameraFor(box, 30, 20), ray = new window.THREE.Raycaster();
        let both = 0, one = 0, worst = 0, normals = 0;
        for (let k = 0; k < 900; ++k) {
            ray.setFromCamera(new window.THREE.Vector2((k % 30) / 15 - 0.97, Math.floor(k / 30) / 15 - 0.97), camera);
            const [a] = ray.intersectObject(mesh, true), [b] = ray.intersectObject(splats, true);
            if (!!a !== !!b) ++one;
            if (!a || !b) continue;
            ++both;
            worst = Math.max(worst, a.point.distanceTo(b.point));
            normals = Math.max(normals, a.face.normal.clone().transformDirection(a.object.matrixWorld).distanceTo(b.face.normal.clone().transformDirection(a.object.matrixWorld)));
        }
        const size = box.getSize(new window.THREE.Vector3()).length();
        return { both, one, worst: worst / size, offset };
    });
    assert.ok(found.both > 40, JSON.stringify(found));
    assert.ok(found.one <= 3, JSON.stringify(found)); // rays at an edge
    assert.ok(found.worst < 0.03, JSON.stringify(found)); // the models are converted at a tolerance of 2 %
    assert.ok(found.offset < 0.1, JSON.stringify(found)); // boxes of clipped ellipses are no smaller, and little larger
});

test('boxes hold all that rays hit, and little more', async () => {
    for (const [url, most] of [['/files/part.glb', 1.25], ['/files/torus.glb', 1.06], ['/schema/curved.gltf', 1.15]]) {
        const found = await inPage(async (at) => {
            const { scene: root } = await window.loader.loadAsync(at), { Box3, Raycaster, Vector3 } = window.THREE, seen = new Box3(), ray = new Raycaster();
            root.updateMatrixWorld(true);
            const box = new Box3().setFromObject(root), center = box.getCenter(new Vector3()), size = box.getSize(new Vector3()).length();
            let state = 1;
            const random = () => {
                state = (state * 48271) % 2147483647;
                return state / 2147483647 - 0.5;
            };
            let outside = 0, count = 0;
            for (let k = 0; k < 4000; ++k) {
                const from = new Vector3(random(), random(), random()).setLength(2 * size).add(center), to = new Vector3(random(), random(), random()).multiplyScalar(size).add(center);
                ray.set(from, to.sub(from).normalize());
                for (const { point } of ray.intersectObject(root, true)) {
                    outside = Math.max(outside, box.distanceToPoint(point) / size);
                    seen.expandByPoint(point);
                    ++count;
                }
            }
            return { count, outside, ratio: size / seen.getSize(new Vector3()).length() };
        }, url);
        assert.ok(found.count > 100 && found.outside < 1e-6 && found.ratio < most, `${url}: ${JSON.stringify(found)}`);
    }
});

test('clones share what they draw, and dispose() frees it', async () => {
    const found = await inPage(async () => {
        const renderer = window.makeRenderer({ width: 200, height: 150 }), scene = new window.THREE.Scene(), before = renderer.info.memory.textures;
        const { scene: root } = await window.loader.loadAsync('/files/tiled.glb'), clone = root.clone();
        scene.add(root, clone);
        clone.position.x = 1.5;
        const camera = window.cameraFor(new window.THREE.Box3().setFromObject(scene), 0, 0);
        window.addLight(scene, camera);
        renderer.render(scene, camera);
        const two = renderer.info.memory.textures, splats = [];
        window.eachSplats(scene, (o) => splats.push(o));
        const shared = splats[0].batches === splats[1].batches && splats[0] !== splats[1];
        renderer.render(scene, camera);
        const steady = renderer.info.memory.textures, geometries = renderer.info.memory.geometries;
        for (const o of splats) {
            o.dispose();
            for (const key of ['map', 'normalMap', 'roughnessMap', 'metalnessMap', 'aoMap', 'emissiveMap']) o.material[key]?.dispose();
        }
        window.PhongSplats.disposeTargets(renderer);
        return { before, two, steady, shared, after: renderer.info.memory.textures, geometries, left: renderer.info.memory.geometries };
    });
    assert.ok(found.shared);
    assert.equal(found.two, found.steady);
    assert.equal(found.left, 0, JSON.stringify(found));
    assert.ok(found.after <= found.before + 1, JSON.stringify(found)); // three's own table of its BRDF stays
});

test('a canvas that grows looks as one that had its size from the start', async () => {
    const found = await inPage(async () => {
        const { scene: root } = await window.loader.loadAsync('/files/torus.glb'), camera = window.cameraFor(new window.THREE.Box3().setFromObject(root), 30, 20), pictures = [];
        window.removeLights(root);
        for (const sizes of [[[200, 150], [260, 150], [320, 240]], [[320, 240]]]) {
            const renderer = window.makeRenderer({ width: 200, height: 150 }), scene = new window.THREE.Scene().add(root);
            window.addLight(scene, camera);
            for (const [width, height] of sizes) {
                renderer.setSize(width, height, false);
                camera.aspect = width / height;
                camera.updateProjectionMatrix();
                renderer.render(scene, camera);
            }
            pictures.push(window.pixels(renderer).rgb);
            renderer.dispose();
            renderer.forceContextLoss(); // a page has sixteen
        }
        return pictures;
    });
    assert.ok(Buffer.from(found[0], 'base64').some((value) => value > 40));
    assert.equal(found[0], found[1]);
});

test('objects that lie apart look as each does alone, clones too', async () => {
    const found = await inPage(async () => {
        const renderer = window.makeRenderer({ width: 300, height: 200 }), scene = new window.THREE.Scene(), roots = [];
        for (const name of ['torus', 'tiled', 'part', 'bracket']) {
            const { scene: root } = await window.loader.loadAsync(`/files/${name}.glb`), sphere = new window.THREE.Box3().setFromObject(root).getBoundingSphere(new window.THREE.Sphere());
            window.removeLights(root);
            root.scale.setScalar(1 / sphere.radius);
            root.position.copy(sphere.center).divideScalar(-sphere.radius);
            roots.push(root, root.clone());
        }
        roots.forEach((root, k) => { root.position.x += 3 * (k % 4); root.position.y += 3 * (k >> 2); });
        window.eachSplats(roots[2], (o) => { o.material.color.set(0xff0000); });
        scene.add(...roots);
        const camera = window.cameraFor(new window.THREE.Box3().setFromObject(scene), 20, 20, 1, 1.5), pictures = [];
        window.addLight(scene, camera);
        for (const shown of [roots, ...roots.map((root) => [root])]) {
            for (const root of roots) root.visible = shown.includes(root);
            renderer.render(scene, camera);
            pictures.push(window.pixels(renderer).rgb);
        }
        renderer.dispose();
        renderer.forceContextLoss(); // a page has sixteen
        return pictures;
    });
    const [all, ...single] = found.map((text) => Buffer.from(text, 'base64')), sum = Buffer.alloc(all.length);
    for (const one of single) {
        assert.ok(one.some((value) => value > 40));
        one.forEach((value, i) => { sum[i] = Math.max(sum[i], value); });
    }
    assert.ok(psnr(all, sum) >= 50, `${psnr(all, sum)} dB`); // depths are rounded within one range, and within ranges of each
});

test('with alphaToCoverage multisampling smooths outlines', async () => {
    const found = await inPage(async () => {
        const { scene: root } = await window.loader.loadAsync('/files/bracket.glb'), camera = window.cameraFor(new window.THREE.Box3().setFromObject(root), 30, 20), pictures = [];
        window.removeLights(root);
        // Eight times as many pixels are what is right; then one sample, four, and four without alphaToCoverage.
        for (const [scale, antialias, smooth] of [[8, false, false], [1, false, true], [1, true, true], [1, true, false]]) {
            const renderer = window.makeRenderer({ width: 240 * scale, height: 180 * scale, antialias }), scene = new window.THREE.Scene().add(root);
            window.addLight(scene, camera);
            scene.background = new window.THREE.Color(0.2, 0.5, 0.3);
            window.eachSplats(root, (o) => { Object.assign(o.material, { alphaToCoverage: smooth, needsUpdate: true }); });
            renderer.render(scene, camera);
            const gl = renderer.getContext(), rgba = new Uint8Array(4 * 240 * 180);
            gl.readPixels(0, 0, 240, 180, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
            pictures.push({ ...window.pixels(renderer), isOpaque: rgba.every((value, k) => k % 4 !== 3 || value === 255) });
            renderer.dispose();
            renderer.forceContextLoss(); // a page has sixteen
        }
        return pictures;
    });
    const right = reduce(rgbOf(found[0]), 1920, 1440, 8), [plain, smooth, rough] = found.slice(1).map((one) => psnr(rgbOf(one), right));
    console.log(`outlines: one sample ${plain.toFixed(1)} dB, four ${rough.toFixed(1)} dB, with alphaToCoverage ${smooth.toFixed(1)} dB`);
    assert.ok(found.every((one) => one.isOpaque));
    assert.ok(Math.abs(plain - rough) < 0.5, `${plain} ${rough}`);
    assert.ok(smooth > rough + 2, `${smooth} ${rough}`);
});

test('a lost context comes back', async () => {
    const same = await inPage(async () => {
        const renderer = window.makeRenderer({ width: 300, height: 200 }), scene = new window.THREE.Scene(), { scene: root } = await window.loader.loadAsync('/files/tiled.glb');
        scene.add(root);
        const camera = window.cameraFor(new window.THREE.Box3().setFromObject(root), 30, 20);
        window.addLight(scene, camera);
        renderer.render(scene, camera);
        const first = window.pixels(renderer).rgb, lose = renderer.getContext().getExtension('WEBGL_lose_context');
        const wait = (name) => new Promise((resolve) => renderer.domElement.addEventListener(name, () => setTimeout(resolve, 50), { once: true }));
        const lost = wait('webglcontextlost');
        lose.loseContext();
        await lost;
        renderer.render(scene, camera);
        const restored = wait('webglcontextrestored');
        lose.restoreContext();
        await restored;
        renderer.render(scene, camera);
        return first === window.pixels(renderer).rgb && new Set(atob(first)).size > 20;
    }).catch((error) => { throw error; });
    assert.ok(same);
});

test('two canvases, two cameras in one canvas, and a render target', async () => {
    const found = await inPage(async () => {
        const size = { width: 240, height: 160 }, a = window.makeRenderer(size), b = window.makeRenderer(size), scene = new window.THREE.Scene();
        const { scene: root } = await window.loader.loadAsync('/files/part.glb');
        scene.add(root);
        const camera = window.cameraFor(new window.THREE.Box3().setFromObject(root), 30, 20);
        window.addLight(scene, camera);
        const both = [a, b, a].map((renderer) => {
            renderer.render(scene, camera);
            return window.pixels(renderer).rgb;
        });
        // The same view in the right half of a canvas twice as wide.
        const wide = window.makeRenderer({ width: 480, height: 160 });
        wide.setScissorTest(true);
        for (const x of [0, 240]) {
            wide.setViewport(x, 0, 240, 160);
            wide.setScissor(x, 0, 240, 160);
            wide.render(scene, camera);
        }
        const pixels = atob(window.pixels(wide).rgb);
        let halves = 0;
        for (let y = 0; y < 160; ++y) for (let x = 0; x < 720; ++x) if (pixels[1440 * y + x] !== pixels[1440 * y + 720 + x]) ++halves;
        const target = new window.THREE.WebGLRenderTarget(240, 160, { samples: 4 });
        a.setRenderTarget(target);
        a.render(scene, camera);
        const out = new Uint8Array(240 * 160 * 4);
        await a.readRenderTargetPixelsAsync(target, 0, 0, 240, 160, out);
        a.setRenderTarget(null);
        let lit = 0, expected = 0;
        const text = atob(both[0]);
        for (let i = 0; i < 240 * 160; ++i) {
            if (out[4 * i] > 5) ++lit;
            if (text.charCodeAt(3 * i) > 5) ++expected;
        }
        return { canvases: both[0] === both[1] && both[0] === both[2], halves, lit, expected };
    });
    assert.ok(found.canvases);
    assert.equal(found.halves, 0);
    assert.ok(Math.abs(found.lit - found.expected) < 0.03 * found.expected && found.expected > 1000, JSON.stringify(found));
});

test('logarithmic and reversed depth buffers hide the same pixels', async () => {
    const found = await inPage(async () => {
        const pictures = [];
        for (const options of [{}, { logarithmicDepthBuffer: true }, { reversedDepthBuffer: true }]) {
            const renderer = window.makeRenderer({ width: 240, height: 160, ...options }), scene = new window.THREE.Scene(), { scene: root } = await window.loader.loadAsync('/files/torus.glb');
            scene.add(root);
            const box = new window.THREE.Box3().setFromObject(root), camera = window.cameraFor(box, 30, 20, 1, 1.5), size = box.getSize(new window.THREE.Vector3()).length();
            const bar = new window.THREE.Mesh(new window.THREE.BoxGeometry(2 * size, 0.1 * size, 0.1 * size), new window.THREE.MeshStandardMaterial({ color: 0xff0000 }));
            bar.position.copy(box.getCenter(new window.THREE.Vector3()));
            bar.rotation.y = 0.8;
            scene.add(bar);
            renderer.shadowMap.enabled = true;
            const sun = window.addLight(scene, camera);
            sun.castShadow = bar.castShadow = true;
            sun.position.multiplyScalar(size).add(bar.position);
            sun.target = bar;
            Object.assign(sun.shadow.camera, { left: -size, right: size, top: size, bottom: -size, far: 4 * size });
            window.eachSplats(root, (o) => { o.castShadow = o.receiveShadow = true; });
            renderer.render(scene, camera);
            pictures.push(window.pixels(renderer).rgb);
            renderer.dispose();
        }
        return pictures;
    });
    const [plain, ...others] = found.map((text) => Buffer.from(text, 'base64'));
    others.forEach((other, k) => assert.ok(psnr(plain, other) >= 30, `${['logarithmic', 'reversed'][k]}: ${psnr(plain, other)} dB`));
});

test('where WebGL blends no floats, half floats take their place', async () => {
    const page = await openPage('three');
    await page.evaluate(() => {
        const { getExtension, getSupportedExtensions } = WebGL2RenderingContext.prototype, hidden = 'EXT_float_blend';
        WebGL2RenderingContext.prototype.getExtension = function (name) { return name === hidden ? null : getExtension.call(this, name); };
        WebGL2RenderingContext.prototype.getSupportedExtensions = function () { return getSupportedExtensions.call(this).filter((name) => name !== hidden); };
    });
    for (const [name, least] of [['part', 40], ['tiled', 40]]) {
        const decibels = compare(await draw({ url: `/files/${name}.glb`, shading: 'lit' }, page), join(converted, `${name}.glb`), 'lit');
        assert.ok(decibels >= least, `${name}: ${decibels} dB`);
    }
    await page.close();
});

test('fog and clipping planes work on splats as on meshes', async () => {
    const found = await inPage(async () => {
        const renderer = window.makeRenderer({ width: 240, height: 160 }), scene = new window.THREE.Scene(), { scene: root } = await window.loader.loadAsync('/files/torus.glb');
        scene.add(root);
        const box = new window.THREE.Box3().setFromObject(root), camera = window.cameraFor(box, 30, 20, 1, 1.5), center = box.getCenter(new window.THREE.Vector3());
        window.addLight(scene, camera);
        const covered = () => {
            renderer.render(scene, camera);
            const text = atob(window.pixels(renderer).rgb), sums = [0, 0, 0];
            let count = 0;
            for (let i = 0; i < text.length; i += 3) {
                const rgb = [0, 1, 2].map((k) => text.charCodeAt(i + k));
                if (rgb[0] + rgb[1] + rgb[2] > 6) ++count;
                rgb.forEach((x, k) => { sums[k] += x; });
            }
            return { count, green: sums[1] / (sums[0] + 1) };
        };
        const plain = covered();
        scene.fog = new window.THREE.Fog(0x00ff00, camera.near, camera.far);
        const fog = covered();
        scene.fog = null;
        renderer.clippingPlanes = [new window.THREE.Plane(new window.THREE.Vector3(0, 1, 0), -center.y)];
        return { plain, fog, cut: covered() };
    });
    assert.ok(found.fog.green > 1.5 * found.plain.green, JSON.stringify(found));
    assert.ok(found.cut.count < 0.8 * found.plain.count && found.cut.count > 0.2 * found.plain.count, JSON.stringify(found));
});

test('instances of splats, and a scene whose materials are overridden', async () => {
    const json = JSON.parse(readFileSync(join(root, 'schema/minimal.gltf'), 'utf8')), bytes = new Float32Array([0, 0, 0, 0, 3, 0]);
    json.buffers.push({ byteLength: bytes.byteLength, uri: `data:application/octet-stream;base64,${Buffer.from(bytes.buffer).toString('base64')}` });
    json.bufferViews.push({ buffer: json.buffers.length - 1, byteLength: bytes.byteLength });
    json.accessors.push({ bufferView: json.bufferViews.length - 1, componentType: 5126, count: 2, type: 'VEC3' });
    const node = json.nodes.find((one) => one.mesh !== undefined);
    node.extensions = { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION: json.accessors.length - 1 } } };
    json.extensionsUsed.push('EXT_mesh_gpu_instancing');
    writeFileSync(join(scratch, 'instances.gltf'), JSON.stringify(json));
    const found = await inPage(async () => {
        const load = async (url) => new window.THREE.Box3().setFromObject((await window.loader.loadAsync(url)).scene), one = await load('/schema/minimal.gltf'), both = await load('/scratch/instances.gltf');
        const { scene: root } = await window.loader.loadAsync('/scratch/instances.gltf'), objects = [];
        window.eachSplats(root, (o) => objects.push(o));
        const renderer = window.makeRenderer({ width: 120, height: 80 }), scene = new window.THREE.Scene().add(root), camera = window.cameraFor(both, 10, 10);
        window.addLight(scene, camera);
        const picture = () => {
            renderer.render(scene, camera);
            return window.pixels(renderer).rgb;
        };
        const first = picture();
        scene.overrideMaterial = new window.THREE.MeshNormalMaterial();
        const overridden = picture();
        scene.overrideMaterial = null;
        return { objects: objects.length, shared: objects[0].batches === objects[1]?.batches, higher: both.max.y - one.max.y, same: first === picture(), black: !/[^\0]/.test(atob(overridden)) };
    });
    assert.deepEqual({ ...found, higher: Math.round(found.higher * 1000) / 1000 }, { objects: 2, shared: true, higher: 3, same: true, black: true });
});

// ---- files -----------------------------------------------------------------------------------

const broken = [
    ['a version of the future', (g) => { g.extension.version = 5; }, /version 5 is not one of 1 to 4/],
    ['no tolerance', (g) => { delete g.extension.depthTolerance; }, /depthTolerance is missing/],
    ['rescaled positions', (g) => { g.extension.positionExtent = [1, 1, 1]; }, /another tool rescaled it/],
    ['a missing clip line', (g) => { g.extension.clipLines = 4; }, /CLIP_2 is missing, clipLines is 4/],
    ['more seams than clip lines', (g) => { g.extension.seamLines = 3; }, /seamLines must be integers from 0 to the number of clip lines, which is 2/],
    ['half a seam', (g) => { g.extension.seamLines = 0.5; }, /seamLines must be integers/],
    ['seams of sections without a stream', (g) => { g.extension.seamLines = [1]; }, /seamLines must be integers/],
    ['an attribute of two forms', (g) => { g.attributes['PSPLAT_surface_splats:SCALE'] = 0; }, /with and without an underscore/],
    ['radii in the wrong order', (g) => g.set('SCALE', [0.5, 1]), /splat 0: SCALE is not two radii, the larger first/],
    ['a quaternion that is none', (g) => g.set('ROTATION', [0, 0, 0, 2]), /splat 0: ROTATION is not a unit quaternion/],
    ['a number that is none', (g) => g.set('POSITION', [NaN, 0, 0]), /splat 0: POSITION is not finite/],
    ['a line that is none', (g) => g.set('CLIP_0', [0, 0, 1]), /splat 0: CLIP_0 is no line/],
    ['the extension not listed', (g) => { g.json.extensionsUsed = []; }, /extensionsUsed does not list it/],
];

/** Writes the last primitive of minimal.gltf with a fault into the served directory. */
function writeBroken(change) {
    const json = JSON.parse(readFileSync(join(root, 'schema/minimal.gltf'), 'utf8')), [buffer] = json.buffers;
    const bytes = Buffer.from(buffer.uri.split(',')[1], 'base64'), primitive = json.meshes[0].primitives.at(-1);
    json.meshes[0].primitives = [primitive];
    const set = (name, values) => {
        const own = primitive.attributes[name] ?? primitive.attributes[`_PSPLAT_surface_splats:${name}`], accessor = json.accessors[own];
        const at = (json.bufferViews[accessor.bufferView].byteOffset ?? 0) + (accessor.byteOffset ?? 0);
        values.forEach((value, k) => bytes.writeFloatLE(value, at + 4 * k));
    };
    change({ json, attributes: primitive.attributes, extension: primitive.extensions.PSPLAT_surface_splats, set });
    buffer.uri = `data:application/octet-stream;base64,${bytes.toString('base64')}`;
    writeFileSync(join(scratch, 'broken.gltf'), JSON.stringify(json));
}

for (const [what, change, message] of broken) {
    test(`a file with ${what} says so`, async () => {
        writeBroken(change);
        const text = await inPage(() => window.loader.loadAsync(`/scratch/broken.gltf?${Math.random()}`).then(() => 'opened', (error) => error.message));
        assert.match(text, message);
    });
}

const brokenStreams = [
    ['normalized positions beside a stream', (g) => { g.accessors[0].normalized = true; }, /POSITION: beside a stream, components must be integers/],
    ['a stream in a view with a stride', (g) => { g.bufferViews[0].byteStride = 4; }, /a stream is in a bufferView with a byteStride/],
    ['a compressed stream', (g) => { g.bufferViews[0].extensions = { EXT_meshopt_compression: {} }; }, /a stream is in a bufferView with a byteStride or a compression/],
    ['bytes behind the last splat of a stream', (g) => { g.bufferViews[0].byteLength += 5; }, /a stream has bytes behind its splats/],
    ['a stream that ends early', (g) => { g.bufferViews[0].byteLength -= 30; }, /a stream is damaged/],
];

for (const [what, change, message] of brokenStreams) {
    test(`a file with ${what} says so`, async () => {
        const json = JSON.parse(readFileSync(join(root, 'schema/streamed.gltf'), 'utf8'));
        change(json);
        writeFileSync(join(scratch, 'broken.gltf'), JSON.stringify(json));
        const text = await inPage(() => window.loader.loadAsync(`/scratch/broken.gltf?${Math.random()}`).then(() => 'opened', (error) => error.message));
        assert.match(text, message);
    });
}

const streamSeams = [
    [1, /seamLines is not an array for the stream's 2 sections/],
    [[1], /seamLines is not an array for the stream's 2 sections/],
    [[4, 1], /seamLines must be integers from 0 to the number of clip lines, which is 3/],
    [[1, 4], /opened 1 4/],
];

for (const [seams, message] of streamSeams) {
    test(`seams ${JSON.stringify(seams)} of the sections of a stream`, async () => {
        const json = JSON.parse(readFileSync(join(root, 'schema/streamed.gltf'), 'utf8'));
        json.meshes[0].primitives[0].extensions.PSPLAT_surface_splats.seamLines = seams;
        writeFileSync(join(scratch, 'broken.gltf'), JSON.stringify(json));
        const text = await inPage(() => window.loader.loadAsync(`/scratch/broken.gltf?${Math.random()}`).then(({ scene }) => {
            let found = 'opened';
            scene.traverse((o) => { for (const batch of o.batches ?? []) found += ` ${batch.seamLines}`; });
            return found;
        }, (error) => error.message));
        assert.match(text, message);
    });
}

test('rays and boxes go on beyond seams, and not beyond lines that cut', async () => {
    for (const [seams, hits, low] of [[0, [1, 0, 0], 0.125], [1, [1, 1, 0], -0.4841], [2, [1, 1, 1], -0.5]]) {
        writeBroken((g) => { g.extension.seamLines = seams; });
        const found = await inPage(async () => {
            const { scene } = await window.loader.loadAsync(`/scratch/broken.gltf?${Math.random()}`), ray = new window.THREE.Raycaster();
            scene.updateMatrixWorld(true);
            const box = new window.THREE.Box3().setFromObject(scene);
            const shots = [[4.4, 0.2], [4.4, 0], [3.6, 0]].map(([x, y]) => {
                ray.set(new window.THREE.Vector3(x, y, 5), new window.THREE.Vector3(0, 0, -1));
                return ray.intersectObject(scene, true).length;
            });
            return { shots, low: box.min.y };
        });
        assert.deepEqual(found.shots, hits);
        // Boxes are around polygons of 16 corners, up to 2 % outside the ellipse.
        assert.ok(found.low <= low + 1e-6 && found.low > low - 0.02, `${found.low}`);
    }
});

/** Returns GLSL without comments, one space for all white space. */
function words(source) {
    let text = '', rest = source;
    for (let at = rest.search(/\/[*/]/); at >= 0; at = rest.search(/\/[*/]/)) {
        const end = rest[at + 1] === '*' ? rest.indexOf('*/', at) + 2 : rest.indexOf('\n', at);
        text += `${rest.slice(0, at)} `;
        rest = rest.slice(end);
    }
    return (text + rest).trim().split(/\s+/).join(' ');
}

test('the shaders of the package are those of shaders/', async () => {
    const { shaders } = await import('../../runtime/web/src/shaders.js');
    assert.deepEqual(Object.keys(shaders), shaderNames());
    for (const name of shaderNames()) assert.equal(words(shaders[name]), words(readFileSync(join(root, 'shaders', name), 'utf8')), name);
});
