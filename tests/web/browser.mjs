// SPDX-License-Identifier: MIT
//
// browser.mjs - a headless Chromium and a file server for the tests, and comparison of pictures.
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import puppeteer from 'puppeteer-core';

export const here = dirname(fileURLToPath(import.meta.url));
const types = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json', '.css': 'text/css', '.wasm': 'application/wasm' };

/** Returns the path of a Chromium, or undefined. */
export function findChromium() {
    const given = process.env.CHROMIUM, places = (process.env.PATH ?? '').split(':');
    if (given) return given;
    for (const name of ['chromium', 'chromium-browser', 'google-chrome']) {
        const found = places.map((place) => join(place, name)).find(existsSync);
        if (found) return found;
    }
}

/** Serves directories under names: { name: directory }. Returns the address and close(). */
export async function serve(directories) {
    const server = createServer((request, response) => {
        const [, name, ...rest] = decodeURIComponent(new URL(request.url, 'http://localhost').pathname).split('/');
        const root = directories[name], path = root && join(root, normalize(`/${rest.join('/')}`));
        if (!path || !existsSync(path) || !statSync(path).isFile()) return response.writeHead(404).end();
        const bytes = readFileSync(path); // whole, as tests write files anew while the connection is open
        response.writeHead(200, { 'Content-Type': types[extname(path)] ?? 'application/octet-stream', 'Content-Length': bytes.length });
        response.end(bytes);
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
    return { address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

export async function launch() {
    return puppeteer.launch({
        executablePath: findChromium(),
        timeout: 120000, // ms: beside other tests a browser has taken more than the default of 30 s to start
        args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--hide-scrollbars'],
    });
}

/** Runs f in the page and returns what it asked of WebGL, as a list of names, and how long f waited for the answers,
 *  milliseconds. To ask is to wait for all that was drawn before, since the GL is another process; what a browser knows itself
 *  (isContextLost, getExtension of one that is there) does not count. */
export function questionsOf(page, f) {
    return page.evaluate(`(async () => {
        const prototype = WebGL2RenderingContext.prototype, kept = {}, asked = [];
        let waited = 0;
        for (const name of Object.getOwnPropertyNames(prototype)) {
            if (!/^(get|is|check|read|finish|clientWaitSync)/.test(name) || /^(isContextLost|getExtension|getContextAttributes)$/.test(name)) continue;
            if (typeof Object.getOwnPropertyDescriptor(prototype, name).value !== 'function') continue;
            kept[name] = prototype[name];
            prototype[name] = function (...values) {
                const start = performance.now();
                asked.push(name);
                try {
                    return kept[name].apply(this, values);
                } finally {
                    waited += performance.now() - start;
                }
            };
        }
        try {
            await (${f})();
        } finally {
            Object.assign(prototype, kept);
        }
        return { asked, waited };
    })()`);
}

/** Opens a page and fails on what it reports as an error. Returns the page, with `errors`. */
export async function open(browser, url) {
    const page = await browser.newPage();
    page.errors = [];
    page.on('pageerror', (error) => page.errors.push(String(error.stack ?? error)));
    page.on('console', (message) => {
        const isReport = ['error', 'warn'].includes(message.type()) && !message.text().includes('GPU stall due to ReadPixels');
        if (isReport) page.errors.push(message.text());
    });
    await page.goto(url);
    return page;
}

/** Draws a file by the C runtime with the camera of a picture, at rest or at a time of an animation. Returns RGB, row 0
 *  on top. */
export function drawNative(program, path, out, picture, shading, pose = []) {
    const numbers = [...picture.view, ...picture.projection, ...pose].map(String);
    // With sanitizers, leaks are the business of the runtime's own tests: beside a graphics driver their search may fail.
    const env = { ...process.env, ASAN_OPTIONS: 'detect_leaks=0:intercept_tls_get_addr=0' };
    execFileSync(program, [path, out, String(picture.width), String(picture.height), shading, ...numbers], { env });
    const bytes = readFileSync(out), header = /^P6 \d+ \d+ 255\n/.exec(bytes.toString('latin1', 0, 40))[0];
    return bytes.subarray(header.length);
}

/** Returns a picture of RGB that is a third as wide and high, as `phongsplat render` averages. */
export function reduce(rgb, width, height, by = 3) {
    const out = Buffer.alloc(rgb.length / by / by), columns = width / by;
    for (let y = 0; y < height / by; ++y) {
        for (let x = 0; x < 3 * columns; ++x) {
            let sum = 0;
            for (let j = 0; j < by * by; ++j) sum += rgb[3 * ((by * y + Math.floor(j / by)) * width + by * Math.floor(x / 3) + j % by) + x % 3];
            out[3 * y * columns + x] = Math.round(sum / by / by);
        }
    }
    return out;
}

/** Returns the peak signal-to-noise ratio of two pictures, dB. */
export function psnr(a, b) {
    let sum = 0;
    for (let i = 0; i < a.length; ++i) sum += (a[i] - b[i]) ** 2;
    return 10 * Math.log10(255 ** 2 * a.length / Math.max(sum, 1e-9));
}

export const rgbOf = (picture) => Buffer.from(picture.rgb, 'base64');
