// SPDX-License-Identifier: MIT
//
// bench_frames.mjs - what frames take in three.js in a headless Chromium, in software: objects of splats beside as many of the
// mesh that they come from, with three's own material and one light, 960 x 720. Of each kind frames are drawn in turn, and
// medians are printed: until all pixels are there, and of script, which is what a page's thread spends.
//
// usage: PHONGSPLAT_CONVERTED=DIRECTORY node bench_frames.mjs [NAME...]
import { join } from 'node:path';
import { here, launch, open, serve } from './browser.mjs';

const root = join(here, '../..'), sources = { part: 'part.obj', torus: 'torus.off', tiled: 'tiled.glb', 'still-life': 'still-life.glb', bracket: 'bracket.gltf' };
const names = process.argv.length > 2 ? process.argv.slice(2) : ['tiled', 'still-life', 'bracket'];
const server = await serve({ modules: join(here, 'node_modules'), package: join(root, 'runtime/web'), tests: here, files: process.env.PHONGSPLAT_CONVERTED, models: join(root, 'samples/models') });
const browser = await launch(), page = await open(browser, `${server.address}/tests/page.html?three=three`);
await page.waitForFunction('document.title === "ready"');

/** @returns for splats and mesh the medians of frames of so many objects in a grid, ms. */
function measure(name, count, frames) {
    return page.evaluate(async ([splats, mesh, objects, repeats]) => {
        const { THREE } = window, renderer = window.makeRenderer(), gl = renderer.getContext(), pixel = new Uint8Array(4);
        const stages = await Promise.all([splats, mesh].map(async (url) => {
            const { scene: one } = await window.loader.loadAsync(url), scene = new THREE.Scene(), side = Math.ceil(Math.sqrt(objects));
            window.removeLights(one);
            const sphere = new THREE.Box3().setFromObject(one).getBoundingSphere(new THREE.Sphere());
            for (let i = 0; i < objects; ++i) {
                const copy = one.clone();
                copy.position.add(new THREE.Vector3(i % side, Math.floor(i / side), 0).multiplyScalar(2 * sphere.radius));
                scene.add(copy);
            }
            const camera = window.cameraFor(new THREE.Box3().setFromObject(scene), 10, 10);
            window.addLight(scene, camera);
            const times = [];
            return { times, draw: () => {
                const start = performance.now();
                renderer.render(scene, camera);
                const script = performance.now() - start;
                gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
                times.push([performance.now() - start, script]);
            } };
        }));
        for (let i = 0; i < repeats + 2; ++i) for (const { draw } of stages) draw();
        renderer.dispose();
        const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
        return stages.map(({ times }) => [0, 1].map((k) => median(times.slice(2).map((time) => time[k]))));
    }, [`/files/${name}.glb`, `/models/${sources[name]}`, count, frames]);
}

console.log('| objects | splats, ms | script | mesh, ms | script |\n|---|--:|--:|--:|--:|');
for (const name of names) {
    for (const [count, frames] of [[1, 15], [64, 9], [1000, 3]]) {
        const found = await measure(name, count, frames);
        console.log(`| ${count} ${name} | ${found.flat().map((ms) => ms.toFixed(1)).join(' | ')} |`);
    }
}
await browser.close();
server.close();
