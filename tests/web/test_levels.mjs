// SPDX-License-Identifier: MIT
//
// test_levels.mjs - tests levels of detail in a headless Chromium: PhongSplatsLOD chooses the level that the C runtime
// chooses, and shows it as that draws it. See test_web.mjs for what it needs; PHONGSPLAT is the program.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
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
        for (const [closeness, tau, isFlat] of [[1, 0.01, false], [1, 0.5, false], [2, 1, false], [4, 4, false], [16, 0.5, false], [2, 4, true], [1, 30, false], [4, 1000, true]]) {
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
