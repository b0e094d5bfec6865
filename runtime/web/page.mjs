#!/usr/bin/env node
// SPDX-License-Identifier: MIT
//
// page.mjs - writes one page with the viewer, three.js and a model in it, which opens from disk.
//
// usage: page.mjs MODEL.glb [SOURCE.obj|.glb|...] OUT.html
//        page.mjs --template OUT.html
//
// The modules go into the page as they are, compressed; there they become blobs, and an import map
// gives them their names. The template is the page without models, which `phongsplat convert --html`
// fills as fillTemplate() does (converter/export/html_page.c).
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { basename, dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { createRequire } from 'node:module';
import { gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url)), viewer = join(here, 'viewer');

/** Returns the directory of three: beside this package, or where the command runs. */
function findThree() {
    for (const from of [import.meta.url, join(process.cwd(), 'package.json')]) {
        try {
            return join(dirname(createRequire(from).resolve('three')), '..');
        } catch { /* the next one may have it */ }
    }
    throw new Error('three is not installed: npm install three');
}

/** Returns the file that an import names. */
function fileOf(specifier, from, three) {
    if (specifier === 'three') return join(three, 'build/three.module.js');
    if (specifier === 'three-phong-splats') return join(here, 'src/index.js');
    if (specifier.startsWith('three/addons/')) return join(three, 'examples/jsm', specifier.slice(13));
    return resolve(dirname(from), specifier);
}

/** The module of shaders, which the package has as a file and the repository makes. */
const shaders = join(here, 'src/shaders.js'), makeShaders = existsSync(join(here, 'build.mjs')) ? (await import('./build.mjs')).shaderModule : null;
const isThere = (file) => (file === shaders && !!makeShaders) || existsSync(file);
const read = (file) => (file === shaders && makeShaders ? makeShaders() : readFileSync(file, 'utf8'));

/** Leaves out comments that have lines of their own, and indentation, which is a third of three.js. */
function shorten(source) {
    return source.replace(/^[ \t]*\/\*\*[^]*?\*\/[ \t]*\n/gm, '').replace(/^[ \t]*\/\/.*\n/gm, '').replace(/^[ \t]+/gm, '').replace(/\n+/g, '\n');
}

/** Returns all modules that one imports, [name, source], dependencies by name. */
function collect(entry, three) {
    const names = new Map(), modules = [];
    const visit = (file) => {
        if (names.has(file)) return names.get(file);
        const name = `m${names.size}`;
        names.set(file, name);
        const source = read(file).replace(/\b(from|import)(\s*)(["'])([^"'\n]+)\3/g, (all, word, space, quote, specifier) => {
            const target = fileOf(specifier, file, three);
            return isThere(target) ? `${word}${space}${quote}${visit(target)}${quote}` : all;
        });
        modules.push([name, shorten(source)]);
        return name;
    };
    visit(entry);
    return modules;
}

const start = `
const unpack = async (script) => {
    const bytes = Uint8Array.from(atob(script.textContent.trim()), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).json();
};
unpack(document.getElementById('modules')).then((modules) => {
    const imports = {};
    for (const [name, source] of modules) imports[name] = URL.createObjectURL(new Blob([source], { type: 'text/javascript' }));
    document.head.append(Object.assign(document.createElement('script'), { type: 'importmap', textContent: JSON.stringify({ imports }) }));
    document.head.append(Object.assign(document.createElement('script'), { type: 'module', textContent: 'import "m0";' }));
});
`;

const TITLE = '<title>Phong splats</title>', MODELS = '<!-- models -->\n';

/** Licences ask to be where the software is. */
function licences(three) {
    const own = [join(here, 'LICENSE'), join(here, '../../LICENSE-MIT')].find(existsSync);
    const texts = [['three-phong-splats', own], ['three.js', join(three, 'LICENSE')]].map(([name, file]) => `${name}\n\n${readFileSync(file, 'utf8')}`);
    const [, decoder] = /^\/\/ (Copyright.*)$/m.exec(readFileSync(join(three, 'examples/jsm/libs/meshopt_decoder.module.js'), 'utf8'));
    return `<!--\nThis page holds:\n\n${texts.join('\n')}\nmeshoptimizer's decoder, under the same licence\n\n${decoder}\n-->\n`;
}

/** Returns the page without models, which shows what is dropped on it. */
export function makeTemplate() {
    const html = readFileSync(join(viewer, 'index.html'), 'utf8'), css = readFileSync(join(viewer, 'viewer.css'), 'utf8'), three = findThree();
    const modules = gzipSync(JSON.stringify(collect(join(viewer, 'viewer.js'), three)), { level: 9 }).toString('base64');
    const scripts = `${MODELS}<script type="modules" id="modules">${modules}</script>\n<script>${start}</script>\n`;
    return html
        .replace(/<!-- index[.]html [^]*?-->\n/, '')
        .replace(/<script>[^]*<\/script>\n/, () => scripts)
        .replace('<link rel="stylesheet" href="viewer.css">', () => `<style>\n${css}</style>`)
        .replace('<html', () => `${licences(three)}<html`);
}

const escape = (text) => text.replace(/[&<>"]/g, (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[c]);

/** Returns a template with models in it. models: [name, bytes]. */
export function fillTemplate(template, models) {
    const files = models.map(([name, bytes]) => `<script type="model" data-name="${escape(name)}">${bytes.toString('base64')}</script>\n`).join('');
    return template.replace(TITLE, () => `<title>${escape(models[0][0])}</title>`).replace(MODELS, () => files);
}

/** Returns the page. models: [name, bytes]. */
export function makePage(models) {
    return fillTemplate(makeTemplate(), models);
}

if (process.argv[1] && resolve(process.argv[1]) === fileURLToPath(import.meta.url)) {
    const paths = process.argv.slice(2), out = paths.pop(), isTemplate = paths[0] === '--template';
    if (paths.length < 1 || paths.length > (isTemplate ? 1 : 2) || !/\.html?$/.test(out)) {
        console.error('usage: page.mjs MODEL.glb [SOURCE] OUT.html\n       page.mjs --template OUT.html');
        process.exit(2);
    }
    writeFileSync(out, isTemplate ? makeTemplate() : makePage(paths.map((path) => [basename(path), readFileSync(path)])));
}
