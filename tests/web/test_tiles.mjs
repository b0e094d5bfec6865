// SPDX-License-Identifier: MIT
//
// test_tiles.mjs - tests the package three-phong-splats with TilesRenderer of 3d-tiles-renderer in a
// headless Chromium: pixels against the C runtime, a flight with a small cache that must free what
// leaves it, rays, and contents of triangles beside those of splats. The tilesets are made here, of
// the bundled models.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { drawNative, here, launch, open, psnr, reduce, rgbOf, serve } from './browser.mjs';

const converted = process.env.PHONGSPLAT_CONVERTED, program = process.env.PHONGSPLAT_DRAW_NATIVE;
const root = join(here, '../..'), scratch = mkdtempSync(join(tmpdir(), 'phongsplat-web-')), state = {};

const tileset = (name, tile) => writeFileSync(join(scratch, name), JSON.stringify({ asset: { version: '1.1' }, geometricError: 100, root: tile }));
const box = (x, y, half) => [x, y, 0, half, 0, 0, 0, half, 0, 0, 0, half];
const content = (name) => ({ uri: `../files/${name}.glb` });
const at = (x, y) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, 0, 1];

/** Writes the tilesets: models that lie where they are, and a field of 8 x 8 of them in two levels, 8 apart in 3D Tiles'
 *  axes, of which z points up. */
function writeTilesets() {
    const all = (name) => ({ boundingVolume: { box: box(0, 0, 4) }, geometricError: 0, content: content(name) });
    tileset('models.json', { boundingVolume: { box: box(0, 0, 4) }, geometricError: 1, refine: 'REPLACE', content: content('torus'), children: ['part', 'bracket', 'painted'].map(all) });
    const quarters = [0, 1, 2, 3].map((k) => {
        const [x, y] = [k % 2, Math.floor(k / 2)].map((i) => 32 * i - 16), children = [];
        for (let i = 0; i < 16; ++i) {
            const transform = at(8 * (i % 4) - 12, 8 * Math.floor(i / 4) - 12);
            children.push({ transform, boundingVolume: { box: box(0, 0, 4) }, geometricError: 0.001, content: content(i % 2 ? 'torus' : 'part') });
        }
        return { transform: at(x, y), boundingVolume: { box: box(0, 0, 16) }, geometricError: 0.2, content: content('part'), children };
    });
    tileset('field.json', { boundingVolume: { box: box(0, 0, 32) }, geometricError: 2, refine: 'REPLACE', content: content('torus'), children: quarters });
    const half = (uri, x) => ({ transform: at(x, 0), boundingVolume: { box: box(1.5, 0, 2) }, geometricError: 0, content: { uri } });
    tileset('mixed.json', {
        boundingVolume: { box: box(0, 0, 6) }, geometricError: 5, refine: 'REPLACE',
        children: [half('../files/bracket.glb', -3.5), half('../models/bracket.gltf', 0.5)],
    });
}

before(async () => {
    writeTilesets();
    state.server = await serve({
        modules: join(here, 'node_modules'), package: join(root, 'runtime/web'), tests: here, files: converted, models: join(root, 'samples/models'), scratch,
    });
    state.browser = await launch();
    state.page = await open(state.browser, `${state.server.address}/tests/page.html`);
    await state.page.waitForFunction('document.title === "ready"');
    await state.page.evaluate(prepare);
});

after(async () => {
    await state.browser?.close();
    state.server?.close();
    rmSync(scratch, { recursive: true });
});

/** In the page: what the tests share. */
async function prepare() {
    const { TilesRenderer } = await import('3d-tiles-renderer/three'), { PhongSplatsTiles } = await import('three-phong-splats'), { THREE } = window;
    window.openTiles = (url, { pixels = 1, width = 960, height = 720 } = {}) => {
        const tiles = new TilesRenderer(url), scene = new THREE.Scene().add(tiles.group), camera = new THREE.PerspectiveCamera(40, width / height, 0.1, 100);
        const plugin = new PhongSplatsTiles(window.loader, { pixels });
        tiles.registerPlugin(plugin);
        const { lruCache } = tiles; // which all share
        tiles.lruCache = Object.assign(new lruCache.constructor(), { unloadPriorityCallback: lruCache.unloadPriorityCallback });
        tiles.group.rotation.x = -Math.PI / 2;
        tiles.setCamera(camera);
        tiles.setResolution(camera, width, height);
        scene.add(new THREE.AmbientLight(0xffffff, 1), new THREE.DirectionalLight(0xffffff, 2));
        return { tiles, plugin, scene, camera };
    };
    window.look = ({ scene, camera }, from, to) => {
        camera.position.set(...from);
        camera.lookAt(...to);
        scene.updateMatrixWorld(true);
        camera.updateMatrixWorld(true);
    };
    window.settle = async ({ tiles, plugin }) => {
        for (let k = 0, calm = 0; k < 2000 && calm < 3; ++k) {
            tiles.update();
            calm = tiles.root && !plugin.describe().waiting ? calm + 1 : 0;
            await new Promise((resolve) => setTimeout(resolve, 5));
        }
    };
}

/** Runs a function in the page and fails on what the page reports. */
async function inPage(f, argument) {
    const result = await state.page.evaluate(f, argument);
    const errors = state.page.errors.splice(0).filter((text) => !text.includes('tiles versions at 1.1 or higher have limited support'));
    assert.deepEqual(errors, []);
    return result;
}

test('tiles are drawn as the C runtime draws their contents together', async () => {
    for (const [pixels, names] of [[1e6, ['torus']], [1, ['part', 'bracket', 'painted']]]) {
        const picture = await inPage(async (pixels) => {
            const view = window.openTiles('/scratch/models.json', { pixels }), { scene, camera, tiles } = view, renderer = window.rendererOf();
            window.look(view, [2, 2.5, 5], [0, 0, 0]);
            await window.settle(view);
            window.eachSplats(scene, (object) => { object.material = new window.SplatShadingMaterial('normal'); });
            renderer.render(scene, camera);
            const drawn = { ...window.pixels(renderer), ...view.plugin.describe(), view: camera.matrixWorldInverse.elements, projection: camera.projectionMatrix.elements };
            tiles.dispose();
            return drawn;
        }, pixels);
        assert.equal(picture.tiles, names.length);
        const native = drawNative(program, names.map((name) => join(converted, `${name}.glb`)).join(','), join(scratch, 'native.ppm'), picture, 'normal');
        const decibels = psnr(reduce(rgbOf(picture), picture.width, picture.height), reduce(native, picture.width, picture.height));
        console.log(`${names}: ${decibels.toFixed(1)} dB`);
        assert.ok(decibels >= 50, `${names}: ${decibels} dB`); // as single files: pixels on outlines differ
    }
});

test('a flight draws what its pixels need, and frees what leaves the cache', async () => {
    const found = await inPage(async () => {
        const renderer = window.makeRenderer({ width: 320, height: 240 }), view = window.openTiles('/scratch/field.json', { pixels: 4, width: 320, height: 240 });
        const { tiles, scene, camera, plugin } = view, steps = [], box = new window.THREE.Mesh(new window.THREE.BoxGeometry(), new window.THREE.MeshStandardMaterial());
        renderer.render(new window.THREE.Scene().add(box), camera);
        box.geometry.dispose();
        const before = { ...renderer.info.memory }; // what three keeps for its own materials
        Object.assign(tiles.lruCache, { minSize: 10, maxSize: 24, minBytesSize: 0, maxBytesSize: 2 ** 30, unloadPercent: 1 });
        for (let k = 0; k < 12; ++k) {
            window.look(view, [40 * Math.cos(k / 2), 3, 40 * Math.sin(k / 2)], [16 * Math.cos(k / 2), 0, 16 * Math.sin(k / 2)]);
            await window.settle(view);
            renderer.render(scene, camera);
            steps.push({ ...plugin.describe(), cached: tiles.lruCache.itemSet.size, textures: renderer.info.memory.textures, geometries: renderer.info.memory.geometries });
        }
        const counted = plugin.describe().bytes;
        tiles.dispose();
        window.PhongSplats.disposeTargets(renderer);
        const after = { ...renderer.info.memory };
        renderer.dispose();
        return { steps, before, after, counted };
    });
    const { steps, before, after } = found;
    assert.ok(steps.every((step) => step.tiles >= 2), JSON.stringify(steps));
    assert.ok(new Set(steps.map((step) => step.tiles)).size > 1, JSON.stringify(steps)); // near ones are tiles of their own
    // A content has at most 4 batches of at most 4 textures; the render targets are 9.
    assert.ok(steps.every((step) => step.textures <= 16 * step.cached + 9), JSON.stringify(steps));
    const [early, late] = [steps.slice(2, 6), steps.slice(-4)].map((some) => Math.max(...some.map((step) => step.textures)));
    assert.ok(late <= 1.5 * early, JSON.stringify(steps));
    assert.ok(found.counted > 10000);
    assert.deepEqual(after, before);
});

test('a cache without room keeps what is drawn before', async () => {
    const seen = await inPage(async () => {
        const view = window.openTiles('/scratch/field.json', { pixels: 0.01, width: 320, height: 240 }), renderer = window.rendererOf();
        Object.assign(view.tiles.lruCache, { minSize: 2, maxSize: 4 });
        window.look(view, [0, 8, 40], [0, 0, 0]);
        for (let k = 0; k < 60; ++k) {
            view.tiles.update();
            await new Promise((resolve) => setTimeout(resolve, 5));
        }
        renderer.render(view.scene, view.camera);
        const { tiles } = view.plugin.describe();
        view.tiles.dispose();
        return tiles;
    });
    assert.ok(seen >= 1 && seen <= 4, `${seen}`);
});

test('rays hit splats of tiles, and say which tile it is', async () => {
    const hits = await inPage(async () => {
        const view = window.openTiles('/scratch/field.json'), ray = new window.THREE.Raycaster(), found = [];
        window.look(view, [4, 5, 36], [4, 0, 28]);
        await window.settle(view);
        for (let k = 0; k < 400; ++k) {
            ray.setFromCamera(new window.THREE.Vector2((k % 20) / 10 - 0.95, Math.floor(k / 20) / 10 - 0.95), view.camera);
            const [hit] = ray.intersectObject(view.tiles.group, true);
            if (hit) found.push({ y: hit.point.y, splat: hit.splatIndex, depth: hit.object.userData.tile.internal.depth });
        }
        view.tiles.dispose();
        return found;
    });
    assert.ok(hits.length > 40, `${hits.length}`);
    assert.ok(hits.every((hit) => Math.abs(hit.y) < 3 && hit.splat >= 0 && hit.depth <= 2), JSON.stringify(hits.slice(0, 5)));
    assert.ok(hits.some((hit) => hit.depth === 2));
});

test('contents of triangles are shown beside those of splats', async () => {
    const sums = await inPage(async () => {
        const view = window.openTiles('/scratch/mixed.json'), renderer = window.rendererOf(), { scene, camera } = view;
        window.look(view, [0, 3, 8], [0, 0, 0]);
        await window.settle(view);
        renderer.render(scene, camera);
        const { width, height, rgb } = window.pixels(renderer), text = atob(rgb), halves = [0, 0];
        for (let i = 0; i < text.length; i += 3) if (text.charCodeAt(i)) halves[Math.floor(2 * ((i / 3) % width) / width)] += 1 / height;
        view.tiles.dispose();
        return halves;
    });
    // The two stand beside each other, and are seen from a little further left or right.
    assert.ok(sums[0] > 10 && Math.abs(sums[0] / sums[1] - 1) < 0.2, JSON.stringify(sums));
});
