// SPDX-License-Identifier: MIT
//
// test_page.mjs - tests the page that `phongsplat convert --html` writes, opened from disk in a
// headless Chromium: its pixels beside the C runtime's, the slider, names that HTML could mistake.
// Skipped where the build has no such page. PHONGSPLAT is the program.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import test, { after, before } from 'node:test';
import { pathToFileURL } from 'node:url';
import { fillTemplate } from '../../runtime/web/page.mjs';
import { drawNative, here, launch, open, psnr, reduce, rgbOf } from './browser.mjs';

const program = process.env.PHONGSPLAT, native = process.env.PHONGSPLAT_DRAW_NATIVE, models = join(here, '../../samples/models');
const scratch = mkdtempSync(join(tmpdir(), 'phongsplat-page-')), state = {};
const template = join(dirname(program), 'phongsplat-page.html');
if (!existsSync(template)) {
    console.log('skipped: this build has no page of the viewer (samples/install.sh brings three.js, then configure anew)');
    process.exit(77);
}

before(async () => { state.browser = await launch(); });

after(async () => {
    await state.browser?.close();
    rmSync(scratch, { recursive: true });
});

/** Converts a model. Returns the paths of the asset and of the page. */
function convert(model, name, ...options) {
    const [asset, html] = [join(scratch, `${name}.glb`), join(scratch, `${name}.html`)];
    execFileSync(program, ['convert', join(models, model), asset, '-t', '2', '--effort', '0', '-q', '--html', html, ...options]);
    return [asset, html];
}

async function openPage(path) {
    const page = await open(state.browser, pathToFileURL(path).href);
    await page.setViewport({ width: 960, height: 800 });
    await page.waitForFunction('document.documentElement.dataset.ready');
    return page;
}

/** Returns a picture of the canvas of a page of the viewer and its camera: 960 x 720, black where nothing is, in the mode that
 *  the page has. */
function drawViewer(page) {
    return page.evaluate(() => {
        const { renderer, scene, camera, sides } = window.viewer, width = 960, height = 720, gl = renderer.getContext();
        if (sides.source) sides.source.root.visible = false;
        sides.splats.root.visible = true;
        scene.background = null;
        renderer.setClearColor(0, 1);
        renderer.setScissorTest(false);
        renderer.setPixelRatio(1);
        renderer.setSize(width, height, false);
        camera.aspect = width / height;
        camera.updateProjectionMatrix();
        renderer.setViewport(0, 0, width, height);
        renderer.render(scene, camera);
        const rgba = new Uint8Array(4 * width * height), rows = [];
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
        for (let y = height - 1; y >= 0; --y) {
            const row = [];
            for (let x = 0; x < width; ++x) for (let k = 0; k < 3; ++k) row.push(rgba[4 * (y * width + x) + k]);
            rows.push(String.fromCharCode(...row));
        }
        return { width, height, rgb: btoa(rows.join('')), view: camera.matrixWorldInverse.elements, projection: camera.projectionMatrix.elements };
    });
}

const text = (page, id) => page.$eval(`#${id}`, (e) => (e.hidden ? '' : e.textContent));

test('the page of an animated model plays it', async () => {
    const [, html] = convert('clockwork.glb', 'clockwork'), page = await openPage(html);
    assert.equal(await text(page, 'play'), 'Pause');
    await page.waitForFunction('window.viewer.motion.seconds > 0');
    assert.equal(await page.evaluate(() => window.viewer.sides.splats.clip.name), 'tick');
    assert.deepEqual(page.errors, []);
    await page.close();
});

for (const model of ['part.obj', 'torus.off', 'tiled.glb']) {
    test(`the page of ${model} draws as the C runtime does`, async () => {
        const [asset, html] = convert(model, model.split('.')[0]), page = await openPage(html);
        assert.match(await text(page, 'splats'), /^\w+.glb\n[\d,]+ bytes\n\d+ splats$/);
        for (const shading of ['normal', 'unlit']) {
            await page.select('#mode', shading);
            const picture = await drawViewer(page), drawn = drawNative(native, asset, join(scratch, 'native.ppm'), picture, shading);
            const decibels = psnr(reduce(rgbOf(picture), 960, 720), reduce(drawn, 960, 720));
            console.log(`${model} ${shading}: ${decibels.toFixed(1)} dB`);
            assert.ok(decibels >= 50, `${decibels} dB`); // outlines differ, where two rasterisers round
        }
        assert.deepEqual(page.errors, []);
        await page.close();
    });
}

test('with its source the page has a slider, also where both have one name', async () => {
    for (const [model, name] of [['part.obj', 'beside'], ['tiled.glb', 'tiled']]) {
        const [, html] = convert(model, name, '--html-source', '-w'), page = await openPage(html);
        assert.match(await text(page, 'splats'), /[\d,]+ bytes\n\d+ splats/);
        assert.match(await text(page, 'source'), new RegExp(`^${model}\n[\\d,]+ bytes\n[\\d,]+ triangles`));
        assert.equal(await page.$eval('#slider', (e) => e.hidden), false);
        assert.deepEqual(page.errors, []);
        await page.close();
    }
});

/** Returns the pixels of one side of the page, drawn alone, that are not background. */
function coverOf(page, side) {
    return page.evaluate((which) => {
        const { renderer, scene, camera, sides } = window.viewer, gl = renderer.getContext(), [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight], rgba = new Uint8Array(4 * width * height);
        for (const [name, { root }] of Object.entries(sides)) root.visible = name === which;
        scene.background = null;
        renderer.setClearColor(0, 1);
        renderer.setScissorTest(false);
        renderer.setViewport(0, 0, renderer.domElement.clientWidth, renderer.domElement.clientHeight);
        renderer.render(scene, camera);
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
        return rgba.filter((value, i) => i % 4 === 1 && value > 8).length;
    }, side);
}

test('the source is shown whatever its format is, where its splats are', async () => {
    for (const [model, triangles] of [['cube.off', '12'], ['sphere.ply', '5,120'], ['cone.stl', '1,248'], ['bracket.gltf', '20'], ['scan.xyz', '[\\d,]+']]) {
        const [, html] = convert(model, 'any', '--html-source', '-w'), page = await openPage(html);
        assert.match(await text(page, 'source'), new RegExp(`^${model}.glb\n[\\d,]+ bytes\n${triangles} triangles`));
        const [source, splats] = [await coverOf(page, 'source'), await coverOf(page, 'splats')];
        // Splats of a tolerance of 2 % stand over outlines a little.
        assert.ok(source > 5000 && splats > 0.9 * source && splats < 1.15 * source, `${model}: ${source} and ${splats} pixels`);
        assert.deepEqual(page.errors, []);
        await page.close();
    }
});

test('names are text, whatever they hold', async () => {
    const name = `a<!--"><script>document.title='run'<\\script>&amp;'`;
    const [asset, html] = convert('cube.off', name), page = await openPage(html);
    assert.equal(await page.title(), `${name}.glb`);
    assert.ok((await text(page, 'splats')).startsWith(`${name}.glb\n`));
    assert.deepEqual(page.errors, []);
    await page.close();
    // The name of a file cannot hold a slash, but that of a model in a page can.
    const closing = 'x</title></script><script>document.title="run"</script>.glb', other = join(scratch, 'closing.html');
    writeFileSync(other, fillTemplate(readFileSync(template, 'utf8'), [[closing, readFileSync(asset)]]));
    const second = await openPage(other);
    assert.equal(await second.title(), closing);
    assert.deepEqual(second.errors, []);
    await second.close();
});

test('the program and the command of the package fill a template alike', () => {
    const [asset, html] = [join(scratch, 'beside.glb'), join(scratch, 'beside.html')]; // of the test before the last
    const page = fillTemplate(readFileSync(template, 'utf8'), [['beside.glb', readFileSync(asset)], ['part.obj', readFileSync(join(models, 'part.obj'))]]);
    assert.ok(page === readFileSync(html, 'utf8'));
});

test('without a model the page shows what is dropped on it', async () => {
    const page = await openPage(template);
    assert.match(await text(page, 'hint'), /Drop a file/);
    assert.deepEqual(page.errors, []);
    await page.close();
});
