// SPDX-License-Identifier: MIT
//
// test_viewer.mjs - tests the page runtime/web/viewer in a headless Chromium: files from addresses
// and files that are dropped, the slider, modes, what is said of a broken file.
import assert from 'node:assert/strict';
import { copyFileSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { here, launch, open, serve } from './browser.mjs';

const converted = process.env.PHONGSPLAT_CONVERTED, root = join(here, '../..'), state = {}, scratch = mkdtempSync(join(tmpdir(), 'phongsplat-web-'));

before(async () => {
    state.server = await serve({ modules: join(here, 'node_modules'), package: join(root, 'runtime/web'), files: converted, models: join(root, 'samples/models'), scratch });
    state.browser = await launch();
});

after(async () => {
    await state.browser?.close();
    state.server?.close();
    rmSync(scratch, { recursive: true });
});

async function openViewer(query) {
    const page = await open(state.browser, `${state.server.address}/package/viewer/index.html?three=/modules/three&tiles=/modules/3d-tiles-renderer${query}`);
    await page.setViewport({ width: 900, height: 600 });
    await page.waitForFunction('document.documentElement.dataset.ready');
    return page;
}

const text = (page, id) => page.$eval(`#${id}`, (e) => (e.hidden ? '' : e.textContent));

/** Returns how many pixels of the left and the right half differ from the background, from a picture
 *  of the canvas. */
async function covered(page) {
    await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
    const png = await page.screenshot({ encoding: 'base64', clip: { x: 0, y: 150, width: 900, height: 360 } });
    return page.evaluate(async (data) => {
        const image = new Image();
        image.src = `data:image/png;base64,${data}`;
        await image.decode();
        const context = Object.assign(document.createElement('canvas'), { width: 900, height: 360 }).getContext('2d');
        context.drawImage(image, 0, 0);
        const { data: rgba } = context.getImageData(0, 0, 900, 360), counts = [0, 0], sums = [0, 0];
        for (let i = 0; i < 900 * 360; ++i) {
            const [r, g, b] = rgba.subarray(4 * i, 4 * i + 3), half = i % 900 < 450 ? 0 : 1;
            if (Math.abs(r - rgba[0]) + Math.abs(g - rgba[1]) + Math.abs(b - rgba[2]) > 24) ++counts[half];
            sums[half] += r;
        }
        return { counts, sums };
    }, png);
}

/** Drops files on the page as a browser does. files: [name, base64]. */
function drop(page, files) {
    return page.evaluate((list) => {
        const transfer = new DataTransfer();
        for (const [name, data] of list) transfer.items.add(new File([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], name));
        document.getElementById('view').dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true }));
    }, files);
}

const base64 = (path) => readFileSync(path).toString('base64');

test('a source and its splats from addresses: bytes, counts, and a slider between them', async () => {
    const page = await openViewer('&load=/files/part.glb&source=/models/part.obj'), bytes = statSync(join(converted, 'part.glb')).size;
    assert.match(await text(page, 'splats'), new RegExp(`part.glb\\n${bytes.toLocaleString('en')} bytes\\n\\d+ splats`));
    assert.match(await text(page, 'source'), /part.obj\n[\d,]+ bytes\n[\d,]+ triangles/);
    const middle = await covered(page);
    assert.ok(middle.counts[0] > 3000 && middle.counts[1] > 3000, JSON.stringify(middle));
    // Modes differ on the side of the splats alone while the source has no such mode.
    await page.select('#mode', 'splats');
    const colored = await covered(page);
    assert.ok(Math.abs(colored.sums[0] - middle.sums[0]) < 0.002 * middle.sums[0], JSON.stringify([middle, colored]));
    assert.ok(Math.abs(colored.sums[1] - middle.sums[1]) > 0.005 * middle.sums[1], JSON.stringify([middle, colored]));
    // With the slider at the right end all is source.
    await page.$eval('#slider', (e) => { e.value = 1; e.dispatchEvent(new Event('input')); });
    const source = await covered(page);
    assert.ok(Math.abs(source.sums[1] - colored.sums[1]) > 0.005 * colored.sums[1]);
    await page.mouse.move(430, 330);
    assert.match(await text(page, 'hover'), /% of the diagonal/);
    await page.mouse.move(30, 330);
    assert.equal(await text(page, 'hover'), '');
    await page.touchscreen.tap(430, 330); // fingers do not hover
    await page.waitForFunction('document.getElementById("hover").textContent.includes("% of the diagonal")');
    assert.deepEqual(page.errors, []);
    await page.close();
});

test('files are dropped, and dragging turns the model', async () => {
    const page = await openViewer('');
    assert.match(await text(page, 'hint'), /Drop a file/);
    await drop(page, [['bracket.gltf', base64(join(root, 'samples/models/bracket.gltf'))], ['bracket.glb', base64(join(converted, 'bracket.glb'))]]);
    await page.waitForFunction('document.getElementById("splats").textContent && document.getElementById("source").textContent');
    assert.match(await text(page, 'splats'), /splats/);
    assert.match(await text(page, 'source'), /triangles/);
    const before = await covered(page);
    await page.mouse.move(450, 330);
    await page.mouse.down();
    await page.mouse.move(560, 360, { steps: 4 });
    await page.mouse.up();
    const turned = await covered(page);
    assert.notDeepEqual(before.sums, turned.sums);
    const touch = await page.createCDPSession();
    await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: [{ x: 450, y: 330 }] });
    await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: [{ x: 350, y: 300 }] });
    await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
    assert.notDeepEqual((await covered(page)).sums, turned.sums);
    assert.deepEqual(page.errors, []);
    await page.close();
});

test('sources of other programs are shown', async () => {
    const page = await openViewer('');
    for (const [name, triangles] of [['sphere.ply', '5,120'], ['cone.stl', '1,248']]) {
        await drop(page, [[name, base64(join(root, 'samples/models', name))]]);
        await page.waitForFunction((start) => document.getElementById('source').textContent.startsWith(start), {}, name);
        assert.match(await text(page, 'source'), new RegExp(`\n[\\d,]+ bytes\n${triangles} triangles$`));
        const seen = await covered(page);
        assert.ok(seen.counts[0] > 3000 && seen.counts[1] > 3000, JSON.stringify(seen));
    }
    assert.deepEqual(page.errors, []);
    await page.close();
});

test('what is wrong with a file is said, and the page goes on', async () => {
    const page = await openViewer('');
    const glb = readFileSync(join(converted, 'bracket.glb')), changed = Buffer.from(glb.toString('latin1').replace(/"version":\d/, '"version":7'), 'latin1');
    for (const [name, data, message] of [
        ['future.glb', changed.toString('base64'), /future.glb: mesh 0, primitive 0: PSPLAT_surface_splats: version 7 is not one of 1 to 4/],
        ['cut.glb', glb.subarray(0, 200).toString('base64'), /cut.glb: ./],
        ['empty.obj', Buffer.from('v 0 0 0\n').toString('base64'), /empty.obj: it holds neither splats nor triangles/],
        ['points.ply', Buffer.from('ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n').toString('base64'), /points.ply: it holds points and no triangles/],
        ['notes.txt', 'aGVsbG8=', /notes.txt: not one of .glb, .gltf, .obj, .ply, .stl and tileset.json/],
    ]) {
        await drop(page, [[name, data]]);
        await page.waitForFunction((start) => !document.getElementById('error').hidden && document.getElementById('error').textContent.startsWith(start), {}, name);
        assert.match(await text(page, 'error'), message);
    }
    await drop(page, [['bracket.glb', glb.toString('base64')]]);
    await page.waitForFunction('document.getElementById("splats").textContent');
    assert.equal(await text(page, 'error'), '');
    await page.close();
    const missing = await openViewer('&load=/files/none.glb');
    assert.match(await text(missing, 'error'), /none.glb: the server answers 404/);
    await missing.close();
    const alone = await open(state.browser, `${state.server.address}/package/viewer/index.html?three=/nowhere`);
    await alone.waitForFunction('!document.getElementById("error").hidden');
    assert.match(await text(alone, 'error'), /three.js could not be loaded from .*nowhere/);
    await alone.close();
});

/** Returns a tileset of two models beside each other under a coarse one. */
function makeTileset(contents) {
    const tile = (name, x, half, error) => ({
        transform: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, 0, 1], boundingVolume: { box: [0, 0, 0, half, 0, 0, 0, half, 0, 0, 0, half] }, geometricError: error,
        content: { uri: `${contents}${name}.glb` },
    });
    const root = { ...tile('bracket', 0, 8, 0.5), refine: 'REPLACE', children: [tile('part', -4, 4, 0.01), tile('torus', 4, 4, 0.01)] };
    return JSON.stringify({ asset: { version: '1.1' }, geometricError: 10, root });
}

const limited = /tiles versions at 1.1 or higher have limited support/;

test('a tileset from an address, or dropped: tiles come as the camera and the error want them', async () => {
    writeFileSync(join(scratch, 'tileset.json'), makeTileset('../files/'));
    const page = await openViewer('&tileset=/scratch/tileset.json'), has = (tiles) => page.waitForFunction((n) => document.getElementById('splats').textContent.includes(` in ${n} tiles\n`), {}, tiles);
    await has(2);
    assert.match(await text(page, 'splats'), /tileset.json\n[\d,]+ splats in 2 tiles\n[\d,]+ bytes of tiles/);
    const near = await covered(page);
    assert.ok(near.counts[0] > 1500 && near.counts[1] > 1500, JSON.stringify(near));
    await page.select('#mode', 'normal');
    assert.notDeepEqual((await covered(page)).sums, near.sums);
    // An error of 64 pixels is met by the coarse tile from afar.
    await page.evaluate(() => {
        document.getElementById('pixels').value = 64;
        window.viewer.camera.position.multiplyScalar(3);
        window.viewer.controls.update();
        window.viewer.requestFrame();
    });
    await has(1);
    // Dropped, with its contents; it takes the place of the first one.
    const names = ['bracket', 'part', 'torus'].map((name) => [`${name}.glb`, base64(join(converted, `${name}.glb`))]);
    await page.$eval('#pixels', (e) => { e.value = 1; });
    await drop(page, [['tileset.json', Buffer.from(makeTileset('tiles/')).toString('base64')], ...names]);
    await has(2);
    assert.deepEqual(await covered(page).then(({ counts }) => counts.map((n) => n > 1500)), [true, true]);
    assert.deepEqual(page.errors.filter((error) => !limited.test(error)), []);
    // A file of splats takes the place of a tileset.
    await drop(page, [['bracket.glb', base64(join(converted, 'bracket.glb'))]]);
    await page.waitForFunction('document.getElementById("splats").textContent.startsWith("bracket.glb")');
    assert.equal(await page.$eval('#tau', (e) => e.hidden), true);
    await page.close();
});

test('a tileset that is not there, or lacks a tile, is told', async () => {
    writeFileSync(join(scratch, 'lacking.json'), makeTileset('../files/no-').replace('no-bracket', 'bracket'));
    const page = await openViewer('&tileset=/scratch/none.json');
    assert.match(await text(page, 'error'), /none.json: .*404/);
    await page.close();
    const lacking = await openViewer('&load=/scratch/lacking.json');
    await lacking.waitForFunction('document.getElementById("error").textContent.includes("no-")');
    assert.match(await text(lacking, 'error'), /no-(part|torus).glb: .*404/);
    await lacking.close();
});

/** Waits until so many frames were drawn, or some seconds have gone by: software needs seconds for its first ones. Returns
 *  the frames and the seconds of the animation. */
function watch(page, frames, limit) {
    return page.evaluate(([wanted, most]) => new Promise((resolve) => {
        const { renderer, motion } = window.viewer, first = renderer.info.render.frame, start = motion.seconds, end = performance.now() + 1000 * most;
        const look = () => {
            const drawn = renderer.info.render.frame - first;
            if (drawn >= wanted || performance.now() > end) resolve({ drawn, seconds: motion.seconds - start });
            else setTimeout(look, 20);
        };
        look();
    }), [frames, limit]);
}

/** Sets the seconds of a page whose animation is paused, and returns its picture. */
async function shownAt(page, seconds) {
    await page.evaluate((time) => {
        window.viewer.motion.seconds = time;
        window.viewer.requestFrame();
    }, seconds);
    return covered(page);
}

test('animations play in a loop, on both sides alike, and a button stops them', async () => {
    const page = await openViewer('&load=/files/clockwork.glb&source=/models/clockwork.glb'), options = await page.$$eval('#clip option', (list) => list.map((option) => option.text));
    assert.deepEqual(options, ['tick', 'bounce', 'turn']);
    assert.equal(await text(page, 'play'), 'Pause');
    const playing = await watch(page, 12, 60); // some for each side and pass
    assert.ok(playing.drawn >= 12 && playing.seconds > 0, JSON.stringify(playing));
    await page.click('#play');
    assert.equal(await text(page, 'play'), 'Play');
    await covered(page);
    assert.deepEqual(await watch(page, 1, 1), { drawn: 0, seconds: 0 });
    // Another animation, in which all turns, begins again after its end.
    await page.select('#clip', '2');
    const { duration, name } = await page.evaluate(() => {
        const { clip } = window.viewer.sides.splats;
        return { duration: clip.duration, name: clip.name };
    });
    assert.equal(name, 'turn');
    const first = await shownAt(page, 0.3 * duration), second = await shownAt(page, 0.8 * duration), again = await shownAt(page, 7.3 * duration);
    for (const side of [0, 1]) {
        assert.ok(Math.abs(first.sums[side] - second.sums[side]) > 0.002 * first.sums[side], JSON.stringify([first, second]));
        assert.ok(Math.abs(first.sums[side] - again.sums[side]) < 0.0002 * first.sums[side], JSON.stringify([first, again]));
    }
    // What does not move has no button.
    await drop(page, [['bracket.glb', base64(join(converted, 'bracket.glb'))], ['part.obj', base64(join(root, 'samples/models/part.obj'))]]);
    await page.waitForFunction('document.getElementById("source").textContent.startsWith("part.obj") && document.getElementById("splats").textContent.startsWith("bracket")');
    assert.equal(await page.$eval('#motion', (e) => e.hidden), true);
    assert.deepEqual(page.errors, []);
    await page.close();
});

/** Returns a .glb whose JSON was changed. */
function changedGlb(path, change) {
    const glb = readFileSync(path), end = 20 + glb.readUInt32LE(12), json = JSON.parse(glb.toString('utf8', 20, end));
    change(json);
    const plain = Buffer.from(JSON.stringify(json)), padded = Buffer.concat([plain, Buffer.alloc(-plain.length & 3, ' ')]), head = Buffer.from(glb.subarray(0, 20));
    head.writeUInt32LE(20 + padded.length + glb.length - end, 8);
    head.writeUInt32LE(padded.length, 12);
    return Buffer.concat([head, padded, glb.subarray(end)]);
}

/** Makes an animation one of a single moment. */
function stop(json, { samplers }) {
    for (const sampler of samplers) {
        for (const key of ['input', 'output']) {
            const accessor = { ...json.accessors[sampler[key]], count: sampler.interpolation === 'CUBICSPLINE' && key === 'output' ? 3 : 1 };
            if (key === 'input') accessor.max = accessor.min;
            sampler[key] = json.accessors.push(accessor) - 1;
        }
    }
}

/** Makes an animation one of a node that shows nothing, as a camera's path is. */
function lead(json, { channels }) {
    const eye = json.nodes.push({ name: 'eye' }) - 1;
    json.scenes[0].nodes.push(eye);
    for (const { target } of channels) target.node = eye;
}

test('animations in which nothing moves are not played', async () => {
    const still = changedGlb(join(converted, 'clockwork.glb'), (json) => {
        json.animations.splice(2);
        stop(json, json.animations[0]);
        lead(json, json.animations[1]);
    });
    const page = await openViewer('');
    await drop(page, [['still.glb', still.toString('base64')]]);
    await page.waitForFunction('document.getElementById("splats").textContent');
    assert.equal(await page.$eval('#motion', (e) => e.hidden), true);
    await covered(page);
    assert.deepEqual(await watch(page, 1, 1), { drawn: 0, seconds: 0 });
    // Beside such animations, those that move something are played as ever.
    const mixed = changedGlb(join(converted, 'clockwork.glb'), (json) => {
        stop(json, json.animations[0]);
        lead(json, json.animations[2]);
    });
    await drop(page, [['mixed.glb', mixed.toString('base64')]]);
    await page.waitForFunction('document.getElementById("splats").textContent.startsWith("mixed.glb")');
    assert.deepEqual(await page.$$eval('#clip option', (list) => list.map((option) => option.text)), ['bounce']);
    assert.ok((await watch(page, 3, 60)).drawn >= 3);
    assert.deepEqual(page.errors, []);
    await page.close();
});

test('animations wait for the button where the reader wants little motion', async () => {
    const page = await openViewer('');
    await page.emulateMediaFeatures([{ name: 'prefers-reduced-motion', value: 'reduce' }]);
    await page.goto(`${page.url()}&load=/files/clockwork.glb`);
    await page.waitForFunction('document.documentElement.dataset.ready');
    assert.equal(await text(page, 'play'), 'Play');
    await covered(page);
    assert.deepEqual(await watch(page, 1, 1), { drawn: 0, seconds: 0 });
    await page.click('#play');
    const playing = await watch(page, 12, 60); // some for each side and pass
    assert.ok(playing.drawn >= 12 && playing.seconds > 0, JSON.stringify(playing));
    assert.deepEqual(page.errors, []);
    await page.close();
});

test('the page in the README works as it stands', async () => {
    const example = /```html\n([^]*?)```/.exec(readFileSync(join(root, 'runtime/web/README.md'), 'utf8'))[1];
    const local = example.replaceAll(/https:\/\/cdn[^"]*three@[\d.]+\//g, '/modules/three/').replace('./node_modules/three-phong-splats/', '/package/');
    assert.notEqual(local, example);
    writeFileSync(join(scratch, 'index.html'), local.replace('<meta', '<link rel="icon" href="data:,"><meta'));
    copyFileSync(join(converted, 'part.glb'), join(scratch, 'model.glb'));
    const page = await open(state.browser, `${state.server.address}/scratch/index.html`);
    await page.setViewport({ width: 900, height: 600 });
    await page.waitForSelector('canvas');
    await page.reload();
    await page.waitForSelector('canvas');
    await new Promise((resolve) => setTimeout(resolve, 2000));
    const seen = await covered(page);
    assert.ok(seen.counts[0] > 10000 && seen.counts[1] > 10000, JSON.stringify(seen));
    assert.deepEqual(page.errors, []);
    await page.close();
});
