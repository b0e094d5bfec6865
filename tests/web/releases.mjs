// SPDX-License-Identifier: MIT
//
// releases.mjs - which releases of three.js the package works with: draws models against the C runtime, with three's own
// material, and with shadows, by each release that is named. Not a test of the suite, which knows the oldest release that is
// supported and the one of package.json: this takes the network, and half a minute a release.
//
// usage: PHONGSPLAT_CONVERTED=DIRECTORY PHONGSPLAT_DRAW_NATIVE=PROGRAM node releases.mjs 0.180.0 0.187.0 ...
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { drawNative, here, launch, open, psnr, reduce, rgbOf, serve } from './browser.mjs';

const converted = process.env.PHONGSPLAT_CONVERTED, program = process.env.PHONGSPLAT_DRAW_NATIVE, releases = process.argv.slice(2);
const scratch = mkdtempSync(join(tmpdir(), 'phongsplat-releases-'));

/** @returns PSNR of a shading against the C runtime, dB. */
async function compare(page, name, shading) {
    const picture = await page.evaluate((options) => window.page.draw(options), { url: `/files/${name}.glb`, shading });
    const native = drawNative(program, join(converted, `${name}.glb`), join(scratch, 'native.ppm'), picture, shading === 'three' ? 'lit' : shading);
    return psnr(reduce(rgbOf(picture), picture.width, picture.height), reduce(native, picture.width, picture.height));
}

/** @returns the mean of a picture of splats between three's meshes, with shadows on splats and without. */
function shadows(page) {
    return page.evaluate(async () => {
        const { renderer, scene, camera, root } = await window.makeStage({ url: '/files/torus.glb' }), means = [];
        for (const receives of [true, false]) {
            window.eachSplats(root, (o) => { o.receiveShadow = o.castShadow = receives; });
            renderer.render(scene, camera);
            const text = atob(window.pixels(renderer).rgb);
            let sum = 0;
            for (let i = 0; i < text.length; ++i) sum += text.charCodeAt(i);
            means.push(sum / text.length);
        }
        renderer.dispose();
        return means;
    });
}

/** Prints what a release does. @returns whether all is as with the others. */
async function check(browser, address, release) {
    const page = await open(browser, `${address}/tests/page.html?three=${release}`), found = [];
    try {
        await page.waitForFunction('document.title === "ready"', { timeout: 60000 });
        for (const [name, shading, least] of [['part', 'normal', 50], ['part', 'lit', 50], ['tiled', 'lit', 50], ['still-life', 'lit', 50], ['part', 'three', 30]]) {
            found.push([`${name} ${shading}`, await compare(page, name, shading), least]);
        }
        const [dark, bright] = await shadows(page);
        found.push(['shadows', bright - dark, 0.5]); // of 255, over the whole picture
    } catch (error) {
        page.errors.push(error.message);
    }
    const isGood = found.length === 6 && found.every(([, value, least]) => value >= least) && !page.errors.length;
    console.log(`three ${release}: ${isGood ? 'works' : 'FAILS'}: ${found.map(([what, value]) => `${what} ${value.toFixed(1)}`).join(', ')}`);
    for (const error of new Set(page.errors)) console.log(`    ${error.slice(0, 300).replaceAll('\n', ' ')}`);
    await page.close();
    return isGood;
}

execFileSync('npm', ['install', '--no-audit', '--no-fund', '--no-save', '--loglevel=error', '--prefix', scratch, ...releases.map((release) => `${release}@npm:three@${release}`)]);
execFileSync('node', [join(here, '../../runtime/web/build.mjs')]);
const server = await serve({ modules: join(scratch, 'node_modules'), package: join(here, '../../runtime/web'), tests: here, files: converted });
const browser = await launch();
let areGood = true;
for (const release of releases) areGood = (await check(browser, server.address, release)) && areGood;
await browser.close();
server.close();
rmSync(scratch, { recursive: true });
process.exit(areGood ? 0 : 1);
