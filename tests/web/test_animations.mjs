// SPDX-License-Identifier: MIT
//
// test_animations.mjs - tests in a headless Chromium that splats move with three's AnimationMixer: pixels against the C
// runtime's pose at the same time, with the sample that the generator calls clockwork. See test_web.mjs for what it needs.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { drawNative, here, launch, open, psnr, reduce, rgbOf, serve } from './browser.mjs';

const converted = process.env.PHONGSPLAT_CONVERTED, program = process.env.PHONGSPLAT_DRAW_NATIVE;
const scratch = mkdtempSync(join(tmpdir(), 'phongsplat-animations-')), state = {};

before(async () => {
    const root = join(here, '../..');
    state.server = await serve({ modules: join(here, 'node_modules'), package: join(root, 'runtime/web'), tests: here, files: converted });
    state.browser = await launch();
    state.page = await open(state.browser, `${state.server.address}/tests/page.html?three=three`);
    await state.page.waitForFunction('document.title === "ready"');
});

after(async () => {
    await state.browser?.close();
    state.server?.close();
    rmSync(scratch, { recursive: true });
});

/** Draws clockwork's normals at a time of an animation, with a camera that sees all of it. */
async function drawAt(animation, time) {
    const result = await state.page.evaluate(async ([index, seconds]) => {
        const { scene: root, animations } = await window.loader.loadAsync('/files/clockwork.glb');
        const scene = new window.THREE.Scene().add(root), renderer = window.rendererOf(), mixer = new window.THREE.AnimationMixer(root);
        const sphere = new window.THREE.Sphere(new window.THREE.Vector3(0, -0.2, 0), 2.4);
        const camera = window.cameraFor(new window.THREE.Box3().setFromCenterAndSize(sphere.center, new window.THREE.Vector3(3, 3, 2)), 20, 15);
        mixer.clipAction(animations[index]).play();
        mixer.setTime(seconds);
        const shown = [];
        window.eachSplats(root, (object) => {
            object.material = new window.SplatShadingMaterial('normal');
            shown.push(object);
        });
        renderer.render(scene, camera);
        const box = new window.THREE.Box3().setFromObject(root);
        const at = shown.map((object) => object.getWorldPosition(new window.THREE.Vector3()).toArray());
        return { ...window.pixels(renderer), names: animations.map(({ name }) => name), box: [box.min.toArray(), box.max.toArray()], at,
            view: camera.matrixWorldInverse.elements, projection: camera.projectionMatrix.elements };
    }, [animation, time]);
    assert.deepEqual(state.page.errors.splice(0), []);
    return result;
}

/** Returns the PSNR of a picture against the C runtime's in a pose, both averaged. */
function against(picture, pose) {
    const native = drawNative(program, join(converted, 'clockwork.glb'), join(scratch, 'native.ppm'), picture, 'normal', pose);
    return psnr(reduce(rgbOf(picture), picture.width, picture.height), reduce(native, picture.width, picture.height));
}

// As in test_web.mjs, outlines differ by rounding, and objects blend with each other in the C runtime alone.
test('splats move with the mixer as the C runtime poses them', async () => {
    for (const [index, times] of [[0, [0.3, 0.6, 1.9]], [1, [0.05, 0.25, 0.5]], [2, [0.5, 2.5, 3.5]]]) {
        for (const time of times) {
            const picture = await drawAt(index, time), decibels = against(picture, [index, time]), still = against(picture, []);
            console.log(`${picture.names[index]} at ${time} s: ${decibels.toFixed(1)} dB, and ${still.toFixed(1)} dB beside the asset at rest`);
            assert.ok(decibels >= 40, `${decibels} dB`);
            assert.ok(still < decibels - 10, `at rest it would be ${still} dB`);
        }
    }
});

test('names, boxes and objects follow', async () => {
    const low = await drawAt(1, 0.02), high = await drawAt(1, 0.5);
    assert.deepEqual(high.names, ['tick', 'bounce', 'turn']);
    const moved = high.at.map((p, i) => Math.hypot(...p.map((c, k) => c - low.at[i][k])));
    assert.equal(moved.filter((distance) => distance > 1).length, 1); // the ball alone, by 1.2 but for 0.02 s
    assert.ok(low.box[1][1] >= high.box[1][1] - 1e-6); // the hand is above the ball
});
