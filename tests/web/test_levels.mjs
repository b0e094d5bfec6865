// SPDX-License-Identifier: MIT
//
// test_levels.mjs - tests levels of detail in a headless Chromium: PhongSplatsLOD chooses the level that the C runtime
// chooses, and shows it as that draws it. See test_web.mjs for what it needs; PHONGSPLAT is the program.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { here, launch, open, psnr, reduce, rgbOf, serve } from './browser.mjs';

const native = process.env.PHONGSPLAT_DRAW_NATIVE, root = join(here, '../..');
const scratch = mkdtempSync(join(tmpdir(), 'phongsplat-levels-')), state = {};
const files = { cone: join(scratch, 'cone.glb'), levels: join(root, 'schema/levels.gltf') };

before(async () => {
    execFileSync(process.env.PHONGSPLAT, ['convert', join(root, 'samples/models/cone.stl'), files.cone, '-t', '0.5', '--levels', '2%,5%', '--effort', '0', '-q']);
    state.server = await serve({ modules: join(here, 'node_modules'), package: join(root, 'runtime/web'), tests: here, scratch, schema: join(root, 'schema') });
    state.browser = await launch();
    state.page = await open(state.browser, `${state.server.address}/tests/page.html?three=three`);
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

/** Draws a file from so many times the distance at which it fills the picture. */
const drawAt = (options) => inPage(async ({ url, closeness, tau, isFlat }) => {
    const { THREE } = window, { scene: model } = await window.levelsLoader.loadAsync(url), scene = new THREE.Scene().add(model), renderer = window.rendererOf();
    let camera = window.cameraFor(new THREE.Box3().setFromObject(model), 25, 35, closeness), lod = null;
    if (isFlat) {
        const r = closeness * new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere()).radius, flat = new THREE.OrthographicCamera(-r * 4 / 3, r * 4 / 3, r, -r, camera.near, camera.far);
        flat.position.copy(camera.position);
        flat.quaternion.copy(camera.quaternion);
        flat.updateMatrixWorld();
        camera = flat;
    }
    window.eachSplats(model, (object) => { object.material = new window.SplatShadingMaterial('normal'); });
    model.traverse((object) => { if (object.isPhongSplatsLOD) lod = object; });
    lod.tau = tau;
    lod.hysteresis = 0;
    renderer.render(scene, camera);
    renderer.render(scene, camera); // the first one told the size of the picture
    const shown = lod.levels.map(({ object }) => object.visible);
    return { ...window.pixels(renderer), shown, level: lod.currentLevel, view: camera.matrixWorldInverse.elements, projection: camera.projectionMatrix.elements };
}, options);

for (const [name, url] of [['cone', '/scratch/cone.glb'], ['levels', '/schema/levels.gltf']]) {
    test(`${name}: the level of the C runtime, and its pixels`, async () => {
        const seen = new Set(), path = files[name];
        for (const [closeness, tau, isFlat] of [[1, 0.01, false], [1, 0.5, false], [2, 1, false], [2, 2, false], [1, 5, false], [4, 4, false], [16, 0.5, false], [2, 4, true], [1, 30, false], [4, 1000, true]]) {
            const picture = await drawAt({ url, closeness, tau, isFlat }), out = join(scratch, 'native.ppm');
            const args = [path, out, picture.width, picture.height, 'normal', ...picture.view, ...picture.projection, tau].map(String);
            const env = { ...process.env, ASAN_OPTIONS: 'detect_leaks=0:intercept_tls_get_addr=0' };
            const level = Number(execFileSync(native, args, { env, encoding: 'utf8' })), bytes = readFileSync(out);
            assert.equal(picture.level, level, `closeness ${closeness}, tau ${tau}`);
            assert.deepEqual(picture.shown, picture.shown.map((_, k) => k === level));
            const drawn = bytes.subarray(/^P6 \d+ \d+ 255\n/.exec(bytes.toString('latin1', 0, 40))[0].length);
            const decibels = psnr(reduce(rgbOf(picture), picture.width, picture.height), reduce(drawn, picture.width, picture.height));
            assert.ok(decibels >= 40, `level ${level}: ${decibels} dB`);
            seen.add(level);
        }
        assert.deepEqual([...seen].sort(), [0, 1, 2]);
    });
}

test('without being asked for, levels do not show', async () => {
    const types = await inPage(async () => {
        const { scene } = await window.loader.loadAsync('/schema/levels.gltf'), found = [];
        scene.traverse((object) => found.push([object.type, object.splatCount ?? 0]));
        return found;
    });
    assert.deepEqual(types, [['Group', 0], ['PhongSplats', 4]]);
});

/** Changes of schema/levels.gltf that break a rule of section 3.13, and what is said of them. */
const broken = {
    'scale must be a number': [(l) => { l[1].scale = '2'; }, (l) => { l[1].scale = null; }],
    'level 1 of mesh 0 has a scale that is not above 0': [(l) => { l[1].scale = 0; }, (l) => { l[1].scale = -1; }],
    'translation must have 3 numbers': [(l) => { l[1].translation = [1]; }, (l) => { l[2].translation = [1, 2, 3, 4]; }],
    'translation must be an array': [(l) => { l[1].translation = 'abc'; }],
    'translation must be a number': [(l) => { l[1].translation = [0, '1', 0]; }],
    'level 1 of mesh 0 is a mesh with levels of its own': [(l) => { l[1].mesh = 0; }, (l, json) => { json.meshes[1].primitives[0].extensions.PSPLAT_surface_splats.levels = []; }],
    'level 2 of mesh 0 is a mesh without splats of its own': [(l, json) => { json.meshes.push({ primitives: [{ attributes: { POSITION: 8 } }] }); l[2].mesh = 3; }],
    'level 2 of mesh 0 has no fewer splats than the level before': [(l) => { l[2].mesh = 1; }],
    'mesh is missing': [(l) => { delete l[1].mesh; }],
    'mesh must be a number': [(l) => { l[1].mesh = '1'; }],
    'mesh must be an integer from 0 to 2': [(l) => { l[1].mesh = 3; }, (l) => { l[1].mesh = -1; }, (l) => { l[1].mesh = 0.5; }],
    'level 0 of mesh 0 is the mesh itself and names none': [(l) => { l[0].mesh = 0; }],
    'level 0 of mesh 0 is the mesh itself and has no place of its own': [(l) => { l[0].scale = 5; }, (l) => { l[0].translation = [0, 0, 0]; }],
    'level 1 of mesh 0: outline is missing': [(l) => { delete l[1].outline; }],
    'distance must be a number': [(l) => { l[1].distance = '1'; }],
    'level 2 of mesh 0: outline must be 9 to inf': [(l) => { l[1].outline = 9; l[2].outline = 1; }],
    'level 1 of mesh 0: normal must be 1.5 to 180': [(l) => { l[1].normal = 1; }, (l) => { l[1].normal = 181; }],
    'level 0 of mesh 0: distance must be 0 to inf': [(l) => { l[0].distance = -1; }],
    'an object is expected': [(l) => { l[1] = 7; }],
    'levels must be an array': [(l, json) => { json.meshes[0].primitives[0].extensions.PSPLAT_surface_splats.levels = 'abc'; }],
    'the levels of mesh 0 are an empty list': [(l) => { l.splice(0); }],
    'levels belong to the first primitive of splats of a mesh': [(l, json) => { json.meshes[0].primitives.push(structuredClone(json.meshes[0].primitives[0])); }],
};

test('levels that break a rule are refused, with the words of the C runtime', async () => {
    const cases = Object.entries(broken).flatMap(([message, changes]) => changes.map((change) => {
        const json = JSON.parse(readFileSync(files.levels, 'utf8'));
        change(json.meshes[0].primitives[0].extensions.PSPLAT_surface_splats.levels, json);
        return { message, text: JSON.stringify(json) };
    }));
    const told = await inPage((texts) => Promise.all(texts.flatMap((text) => [window.levelsLoader, window.loader].map((loader) => loader.parseAsync(text, '').then(() => 'it opens', ({ message }) => message)))), cases.map(({ text }) => text));
    const path = join(scratch, 'broken.gltf');
    for (const [k, { message, text }] of cases.entries()) {
        for (const web of told.slice(2 * k, 2 * k + 2)) assert.ok(web.startsWith('PSPLAT_surface_splats: ') && web.endsWith(message), `${message}: ${web}`);
        writeFileSync(path, text);
        const { status, stderr } = spawnSync(process.env.PHONGSPLAT, ['inspect', path], { encoding: 'utf8' });
        assert.ok(status !== 0 && stderr.includes(message), `${message}: ${stderr}`);
    }
});

test('each picture has its level: of two sizes with one camera or two, and with no size known', async () => {
    const found = await inPage(async () => {
        const { THREE } = window, { scene: model } = await window.levelsLoader.loadAsync('/schema/levels.gltf'), scene = new THREE.Scene().add(model), renderer = window.rendererOf();
        const large = new THREE.PerspectiveCamera(40, 4 / 3, 0.1, 1000), small = large.clone(), target = new THREE.WebGLRenderTarget(32, 24), seen = [];
        let lod = null;
        model.traverse((object) => { if (object.isPhongSplatsLOD) lod = object; });
        large.position.z = small.position.z = 30;
        lod.tau = 2;
        const draw = (camera, into) => {
            renderer.setRenderTarget(into);
            renderer.render(scene, camera);
            renderer.setRenderTarget(null);
            return lod.currentLevel;
        };
        for (const inset of [small, large]) {
            draw(large, null);
            for (let k = 0; k < 3; ++k) seen.push([draw(large, null), draw(inset, target)]);
        }
        const expected = [lod.chooseLevel(large, 960, 720, { current: 0 }), lod.chooseLevel(large, 32, 24, { current: 0 })];
        // As in a worker: no window, and nothing has drawn the object.
        const fresh = lod.clone(), { innerWidth } = window;
        large.position.z = 900;
        large.updateMatrixWorld();
        fresh.showLevel(2);
        Object.defineProperty(window, 'innerWidth', { value: undefined, configurable: true, writable: true });
        fresh.update(large);
        const unknown = fresh.currentLevel;
        window.innerWidth = innerWidth;
        fresh.update(large);
        const asWindow = fresh.currentLevel, eye = new THREE.PerspectiveCamera(40, 4 / 3, 0.1, 1000);
        // Of a headset each eye has its part of the picture.
        eye.viewport = new THREE.Vector4(0, 0, 32, 24);
        const eyes = new THREE.ArrayCamera([eye, eye.clone()]);
        eyes.projectionMatrix.copy(large.projectionMatrix);
        eyes.matrixWorldInverse.copy(small.matrixWorldInverse);
        lod.update(eyes);
        const inHeadset = lod.currentLevel;
        lod.dispose();
        target.dispose();
        return { seen, expected, unknown, asWindow, inHeadset };
    });
    assert.ok(found.expected[0] < found.expected[1], JSON.stringify(found));
    assert.deepEqual(found.seen, Array(6).fill(found.expected));
    assert.equal(found.unknown, 0);
    assert.equal(found.asWindow, 2);
    assert.equal(found.inHeadset, found.expected[1]);
});

test('a tau that is not above 0 is the default, and levels are not added by distance', async () => {
    const { chosen, thrown, isDrawn } = await inPage(async () => {
        const { THREE } = window, { scene: model } = await window.levelsLoader.loadAsync('/schema/levels.gltf'), scene = new THREE.Scene().add(model), camera = new THREE.PerspectiveCamera(40, 4 / 3, 0.1, 10000);
        let lod = null;
        model.traverse((object) => { if (object.isPhongSplatsLOD) lod = object; });
        const lists = [0.5, 0, -1, NaN, undefined].map((tau) => [30, 200, 1000, 9000].map((z) => {
            camera.position.z = z;
            camera.updateMatrixWorld();
            return lod.chooseLevel(camera, 960, 720, { tau, hysteresis: 0 });
        }));
        const messages = [() => lod.addLevel(new THREE.Object3D(), 5), () => lod.removeLevel(0)].map((change) => {
            try {
                change();
                return '';
            } catch (error) {
                return error.message;
            }
        });
        window.rendererOf().render(scene, camera);
        return { chosen: lists, thrown: messages, isDrawn: lod.levels.length === 3 && lod.children.length === 3 };
    });
    assert.ok(new Set(chosen[0]).size > 1, JSON.stringify(chosen));
    for (const list of chosen) assert.deepEqual(list, chosen[0]);
    assert.match(thrown[0], /^PhongSplatsLOD: levels and their errors are given to the constructor/);
    assert.match(thrown[1], /^PhongSplatsLOD: levels stay/);
    assert.ok(isDrawn);
});

test('hysteresis, transforms, rays, clones and what is freed', async () => {
    const found = await inPage(async () => {
        const { THREE } = window, renderer = window.rendererOf(), memory = { ...renderer.info.memory };
        const { scene: model } = await window.levelsLoader.loadAsync('/schema/levels.gltf'), scene = new THREE.Scene().add(model), camera = new THREE.PerspectiveCamera(40, 4 / 3, 0.1, 1000);
        let lod = null;
        model.traverse((object) => { if (object.isPhongSplatsLOD) lod = object; });
        const choose = (z, options) => {
            camera.position.z = z;
            camera.updateMatrixWorld();
            scene.updateMatrixWorld();
            return lod.chooseLevel(camera, 960, 720, options);
        };
        // The last distance at which a level is shown, by bisection.
        const limit = (level, options) => {
            let [low, high] = [1, 1000];
            for (let i = 0; i < 60; ++i) {
                const middle = (low + high) / 2;
                if (choose(middle, options) <= level) low = middle;
                else high = middle;
            }
            return low;
        };
        const limits = { calm: limit(0, { tau: 30, hysteresis: 0 }), slow: limit(0, { tau: 30, hysteresis: 0.5, current: 0 }), back: limit(0, { tau: 30, hysteresis: 0.5, current: 1 }) };
        lod.scale.set(1, 3, 1);
        limits.stretched = limit(0, { tau: 30, hysteresis: 0 });
        lod.scale.set(1, 1, 1);
        lod.rotation.y = Math.PI / 2; // the box is flat: its corners are before the eye and behind it
        const inside = [choose(0, { tau: 1e9 }), choose(-50, { tau: 1e-9 })];
        lod.rotation.y = 0;
        lod.tau = 1e9;
        camera.position.z = 9;
        camera.updateMatrixWorld();
        renderer.render(scene, camera);
        const ray = new THREE.Raycaster(camera.position.clone(), new THREE.Vector3(0, 0, -1)), hits = ray.intersectObject(model, true).map(({ object }) => lod.levels.findIndex((level) => level.object === object));
        const clone = lod.clone();
        clone.tau = 1e-9;
        clone.position.x = 2;
        scene.add(clone);
        renderer.render(scene, camera);
        const levels = [lod.currentLevel, clone.currentLevel], shares = clone.levels.every(({ object }, k) => object.batches === lod.levels[k].object.batches);
        lod.dispose();
        scene.clear();
        for (const { object } of [...lod.levels, ...clone.levels]) object.geometry.dispose();
        return { limits, inside, hits, levels, shares, sizes: lod.levels[2].object.pictureSize.toArray(), freed: renderer.info.memory.geometries - memory.geometries };
    });
    const { limits } = found;
    assert.ok(Math.abs(limits.slow / limits.calm - 2) < 1e-6, JSON.stringify(limits)); // half the error, twice as far
    assert.ok(Math.abs(limits.back / limits.calm - 1) < 1e-6, JSON.stringify(limits));
    assert.ok(Math.abs(limits.stretched / limits.calm - 3) < 1e-6, JSON.stringify(limits));
    assert.deepEqual(found.inside, [0, 2]);
    assert.deepEqual(found.hits, [2]);
    assert.deepEqual(found.levels, [2, 0]);
    assert.ok(found.shares);
    assert.deepEqual(found.sizes, [960, 720]);
    assert.equal(found.freed, 0);
});
