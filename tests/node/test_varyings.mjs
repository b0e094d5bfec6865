// SPDX-License-Identifier: MIT
//
// test_varyings.mjs - counts the vectors that programs hand on from vertices to fragments. GLES 3.0 and WebGL 2 promise 15
// of them (GL_MAX_VARYING_VECTORS), of which gl_FragCoord takes one where it is used, and the drivers of this machine have
// more: a program that takes 16 would fail on other people's devices alone. Declarations count whether a compiler needs
// them or not, as section 11 of the GLSL ES 3.00 specification has it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';

const MOST_VECTORS = 15;
const read = (name) => readFileSync(new URL(`../../shaders/${name}`, import.meta.url), 'utf8').replace(/\/\*[^]*?\*\//g, ' ');

/** @returns the directives, the inputs and the built-in inputs of shaders, in their order: what counting needs. */
function linesOf(names) {
    const text = names.map(read).join('\n'), kept = /^\s*#|^\s*(flat )?in \w+ \w+|\bgl_(FragCoord|FrontFacing|PointCoord)\b/;
    return text.split('\n').filter((line) => kept.test(line)).map((line) => line.trim());
}

const compiled = new Map();

/** @returns the value of a preprocessor's expression; names that are not macros are errors. */
function evaluate(expression, macros) {
    const numbers = expression.replace(/defined\s*\(\s*(\w+)\s*\)/g, (_, name) => +macros.has(name)).replace(/[A-Za-z_]\w*/g, function expand(name) {
        assert.ok(macros.has(name), `${name} in "#if ${expression}" is not a macro that this test sets`);
        return `(${String(macros.get(name)).replace(/[A-Za-z_]\w*/g, expand)})`;
    });
    if (!compiled.has(numbers)) compiled.set(numbers, Number(new Function(`return ${numbers};`)()));
    return compiled.get(numbers);
}

/** @returns the inputs of a fragment shader with these macros, as [type, elements], and the built-in ones. */
function inputsOf(lines, given) {
    const macros = new Map(Object.entries(given)), open = [], inputs = [], builtIns = new Set();
    const isOn = () => open.every(({ on }) => on);
    for (const line of lines) {
        const [, directive, rest] = /^#\s*(\w+)\s*(.*)$/.exec(line) ?? [];
        const enter = (value) => { Object.assign(open.at(-1), { on: !open.at(-1).done && !!value, done: open.at(-1).done || !!value }); };
        if (directive === 'if' || directive === 'ifdef' || directive === 'ifndef') {
            const value = !isOn() ? 0 : directive === 'if' ? evaluate(rest, macros) : macros.has(rest) === (directive === 'ifdef');
            open.push({ on: false, done: false });
            enter(value);
        } else if (directive === 'elif') {
            const { done } = open.at(-1);
            open.at(-1).on = true; // what is around it decides whether the expression is read
            enter(!done && isOn() && evaluate(rest, macros));
        } else if (directive === 'else') enter(true);
        else if (directive === 'endif') open.pop();
        else if (directive === 'define' && isOn() && !/^\w+\(/.test(rest)) macros.set(...rest.split(/\s+(.*)/, 2));
        else if (!directive && isOn()) {
            const [, type, , count] = /^(?:flat )?in (\w+) (\w+)(?:\[(\w+)\])?;/.exec(line) ?? [];
            if (type) inputs.push([macros.get(type) ?? type, count ? evaluate(count, macros) : 1]);
            else for (const [name] of line.matchAll(/\bgl_(FragCoord|FrontFacing|PointCoord)\b/g)) builtIns.add(name);
        }
    }
    assert.equal(open.length, 0);
    return { inputs, builtIns };
}

/** @returns how many vectors inputs take: a vector of three leaves room for a number, two of two share a row. */
function vectorsOf({ inputs, builtIns }) {
    const shapes = { float: [1, 1], vec2: [2, 1], ivec2: [2, 1], vec3: [3, 1], vec4: [4, 1], mat3: [3, 3] }, counts = [0, 0, 0, 0, 0];
    for (const [type, elements] of inputs) {
        assert.ok(shapes[type], `${type} is not a type that this test knows`);
        counts[shapes[type][0]] += shapes[type][1] * elements;
    }
    const [, one, two, three, four] = counts, numbers = Math.max(one - three - 2 * (two % 2), 0);
    return builtIns.size + four + three + Math.ceil(two / 2) + Math.ceil(numbers / 4);
}

/** @returns all combinations of macros that inputs hang on, of gl_program.c and of programs.js: { macro: values }. */
function* combinations(axes, chosen = {}) {
    const [name] = Object.keys(axes);
    if (!name) return yield chosen;
    const { [name]: values, ...others } = axes;
    for (const value of typeof values === 'function' ? values(chosen) : values) yield* combinations(others, { ...chosen, [name]: value });
}

const either = [0, 1], no = [0], VISIBILITY = 0, NORMALS = 1, RADIANCE = 2, PARAMETERS = 3;
const isSum = ({ PASS }) => PASS === NORMALS || PASS === RADIANCE;

/** The macros of splat passes. Those that decide about no input have one value. */
const axesOf = (isCurved) => ({
    PASS: [VISIBILITY, NORMALS, RADIANCE, PARAMETERS],
    CLIP_COUNT: [0, 1, 2, 3, 4],
    BENDS: ({ CLIP_COUNT }) => (CLIP_COUNT ? either : no),
    SHAPE: isCurved ? either : no,
    TWO_SIDED: either,
    FINISH: (m) => (isSum(m) ? either : no),
    COLOR: (m) => (isSum(m) && !m.FINISH ? either : no),
    FIELD: ({ PASS }) => (PASS === NORMALS ? either : no),
    FADE: (m) => (isSum(m) ? either : no),
    FILTER: (m) => (isSum(m) && !isCurved ? either : no),
    NEAR: ({ PASS }) => (PASS === VISIBILITY && !isCurved ? either : no),
    TEXTURED: either,
    NORMAL_MAP: ({ PASS, TEXTURED, FIELD }) => (PASS === NORMALS && TEXTURED && FIELD ? either : no),
});

const NO_INPUTS = ['WIDE', 'GAMMA', 'MASK', 'COUNT', 'POWER', 'SEAM_COUNT', 'COLORS', 'MATERIALS', 'OCCLUSION', 'EMISSIVE', 'BASE_MAP', 'SURFACE_MAP', 'OCCLUSION_MAP', 'EMISSIVE_MAP', 'TEXCOORD_BEND', 'MAP_TRANSFORM'];

/** Calls f with the macros of each program of splats, and its inputs. */
function eachProgram(isCurved, f) {
    const layout = linesOf(['layout.h']), head = ['texels.glsl'], tail = ['sums.glsl', isCurved ? 'curved.frag' : 'splat.frag'];
    const lines = [[...head, ...tail], [...head, 'maps.glsl', ...tail]].map((names) => [...layout, ...linesOf(names)]);
    const constants = Object.fromEntries(NO_INPUTS.map((name) => [name, 0]));
    for (const macros of combinations(axesOf(isCurved))) {
        const types = { CLIP_TYPE: ['none', 'float', 'vec2', 'vec3', 'vec4'][macros.CLIP_COUNT], LINE_TYPE: macros.BENDS ? 'vec4' : 'vec3' };
        f(macros, inputsOf(lines[macros.TEXTURED], { ...constants, ...macros, ...types }));
    }
}

for (const isCurved of [false, true]) {
    test(`programs of ${isCurved ? 'curved' : 'flat'} splats take no more vectors than each device has`, () => {
        let programs = 0, most = 0;
        eachProgram(isCurved, (macros, found) => {
            const vectors = vectorsOf(found);
            assert.ok(vectors <= MOST_VECTORS, `${vectors} vectors: ${JSON.stringify(macros)}`);
            most = Math.max(most, vectors);
            ++programs;
        });
        console.log(`${isCurved ? 'curved' : 'flat'}: ${programs} programs, ${most} vectors at most`);
        // Fewer would mean that the test no longer finds the inputs.
        assert.ok(programs > 1000 && most >= 14, `${programs} programs, ${most} vectors`);
    });
}

test('resolve passes take no more vectors than each device has', () => {
    for (let lights = 0; lights <= 8; ++lights) {
        const lines = linesOf(['layout.h', 'resolve_inputs.glsl', 'resolve.frag']), zeros = Object.fromEntries(['AS_IS', 'COLORS', 'MATERIALS', 'EMISSIVE', 'OCCLUSION', 'HALF_TARGETS', 'ENCODE'].map((name) => [name, 0]));
        const vectors = vectorsOf(inputsOf(lines, { ...zeros, LIGHT_COUNT: lights }));
        assert.ok(vectors >= 10 && vectors <= MOST_VECTORS, `${vectors} vectors with ${lights} lights`);
    }
});

test('vectors are counted as GLSL ES packs them', () => {
    const count = (...types) => vectorsOf({ inputs: types.map((type) => [type, 1]), builtIns: new Set() });
    assert.equal(count('vec4', 'vec3', 'float'), 2); // the number lies beside the vector of three
    assert.equal(count('vec3', 'float', 'float'), 2);
    assert.equal(count('vec2', 'vec2', 'vec2', 'float', 'float'), 2);
    assert.equal(count('mat3', 'float', 'float', 'float', 'float'), 4);
    assert.equal(vectorsOf({ inputs: [['vec3', 4]], builtIns: new Set(['gl_FragCoord']) }), 5);
});
