// SPDX-License-Identifier: MIT
//
// build.mjs - writes src/shaders.js, the shaders of the package, from the files in shaders/ that the
// C runtime embeds too, and copies the licence. Comments and indentation are left out, as every
// visitor of a page would pay for them; line breaks stay, so that compilers' messages name lines.
//
// usage: node build.mjs [OUT.js]
//        node build.mjs --strip SHADER OUT
import { copyFileSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const shaders = join(here, '../../shaders');

/** Files that three's own passes stand for, and those of the headless host. */
const UNUSED = new Set(['resolve.vert', 'resolve_inputs.glsl', 'screen.vert', 'depth.frag']);

/** Returns the names of the files that the package needs. */
export function shaderNames() {
    return readdirSync(shaders)
        .filter((name) => /\.(glsl|vert|frag)$/.test(name) || name === 'layout.h')
        .filter((name) => !UNUSED.has(name))
        .sort();
}

/** Returns GLSL without comments, indentation and empty lines. */
export function strip(source) {
    return source
        .replace(/\/\*[^]*?\*\/|\/\/.*/g, ' ')
        .split('\n')
        .map((line) => line.trim().replace(/\s+/g, ' '))
        .filter((line) => line)
        .join('\n');
}

/** Returns the text of src/shaders.js. */
export function shaderModule() {
    const entries = shaderNames().map((name) => {
        const text = strip(readFileSync(join(shaders, name), 'utf8'));
        if (/[`\\$]/.test(text)) throw new Error(`${name} has a character that a template literal takes`);
        return `'${name}': \`${text}\n\``;
    });
    return `// SPDX-License-Identifier: MIT\n// Made by build.mjs from shaders/.\nexport const shaders = {\n${entries.join(',\n')}\n};\n`;
}

if (process.argv[1] === fileURLToPath(import.meta.url) && process.argv[2] === '--strip') {
    writeFileSync(process.argv[4], `${strip(readFileSync(process.argv[3], 'utf8'))}\n`);
} else if (process.argv[1] === fileURLToPath(import.meta.url)) {
    writeFileSync(process.argv[2] ?? join(here, 'src/shaders.js'), shaderModule());
    copyFileSync(join(here, '../../LICENSE-MIT'), join(here, 'LICENSE'));
}
