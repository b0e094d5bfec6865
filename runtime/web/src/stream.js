// SPDX-License-Identifier: MIT
//
// stream.js - reads the coded stream of a primitive of splats (section 3.12 of the specification)
// into the attributes that it holds. Numbers are those of runtime/asset/stream.c.

const HEAD_BYTES = 60, SECTION_BYTES = 12, MOST_SECTIONS = 32, WINDOW = 32, LEAST_BYTES = 3;
const MOST_GRADE = 7, MOST_LENGTH = 17, MOST_RADIUS = 65535, ADAPTED = 40, LEAST_PART = 32;

/** The flags of a section. */
const CURVED = 1, OWN_FIELD = 2, BENDS = 4, TILTED = 8, GAMMA = 16, FLAGS = 31;

/** The kinds of numbers, each with probabilities of its own. */
const KINDS = { radius: 0, elongation: 1, normal: 2, tilt: 3, field: 4, fieldTwist: 5, shape: 6, shapeTwist: 7, lines: 8, lineTurn: 9, lineDistance: 10, lineBend: 11 };

/** Where the bits of a kind of number are: whether it is 0, its sign, its length, the bit below its highest. */
const ZERO = 0, SIGN = 1, LENGTH = 2, HIGHEST = LENGTH + MOST_LENGTH + 1, MODEL = HIGHEST + MOST_LENGTH + 1;

/** A binary arithmetic decoder with adaptive probabilities, parts of 65536. */
class Decoder {
    constructor(bytes, fail) {
        this.bytes = bytes;
        this.fail = fail;
        this.at = 0;
        this.range = 0xffffffff;
        this.value = 0;
        for (let i = 0; i < 4; ++i) this.value = this.value * 256 + this.byte();
        this.ones = new Uint16Array(MODEL * Object.keys(KINDS).length).fill(32768);
        this.seen = new Uint8Array(this.ones.length);
        this.rates = Array.from({ length: ADAPTED + 1 }, (_, n) => Math.floor(131072 / (2 * n + 3)));
    }

    byte() {
        if (this.at >= this.bytes.length + 4) this.fail('a stream is damaged');
        return this.bytes[this.at++] ?? 0;
    }

    split(bound) {
        const bit = this.value < bound;
        if (!bit) this.value -= bound;
        this.range = bit ? bound : this.range - bound;
        for (; this.range < 0x1000000; this.range *= 256) this.value = this.value * 256 + this.byte();
        return bit;
    }

    bit(m) {
        const one = this.ones[m], bit = this.split(Math.floor(this.range / 65536) * one), rate = this.rates[this.seen[m]];
        const next = bit ? one + Math.floor((65536 - one) * rate / 65536) : one - Math.floor(one * rate / 65536);
        this.ones[m] = Math.min(Math.max(next, LEAST_PART), 65536 - LEAST_PART);
        if (this.seen[m] < ADAPTED) ++this.seen[m];
        return bit;
    }

    raw(bits) {
        let value = 0;
        for (let i = 0; i < bits; ++i) value = value * 2 + this.split(Math.floor(this.range / 2));
        return value;
    }

    /** A number of at least 0: the length of the number plus 1 in unary, then its bits. */
    unsigned(kind) {
        const m = kind * MODEL;
        let length = 0, value = 1;
        while (length < MOST_LENGTH && this.bit(m + LENGTH + length)) ++length;
        if (length === MOST_LENGTH) this.fail('a stream is damaged');
        if (length) value = 2 + this.bit(m + HIGHEST + length);
        if (length > 1) value = value * 2 ** (length - 1) + this.raw(length - 1);
        return value - 1;
    }

    signed(kind) {
        if (!this.bit(kind * MODEL + ZERO)) return 0;
        const isNegative = this.bit(kind * MODEL + SIGN), magnitude = this.unsigned(kind) + 1;
        return isNegative ? -magnitude : magnitude;
    }
}

// ---- the head --------------------------------------------------------------------------------

function readHead(view, fail) {
    if (view.byteLength < HEAD_BYTES) fail('a stream is too short');
    const b = (i) => view.getUint8(i), f = Array.from({ length: 12 }, (_, i) => view.getFloat32(12 + 4 * i, true));
    if (b(0) !== 1) fail('a stream is of an unknown form');
    if (!f.every((x) => x >= 0 && x < Infinity)) fail('a stream has a number that is none or below 0');
    const isRight = b(1) <= 8 && b(2) >= 4 && b(2) <= 14 && b(3) >= 1 && b(3) <= 14 && b(4) >= 1 && b(4) <= 14 && b(8) >= 1 && b(8) <= MOST_SECTIONS;
    if (!isRight || b(9) > MOST_GRADE || b(10) > Math.min(MOST_GRADE, b(2) - 4) || b(11) || !(f[0] > 0) || !(f[1] > 0)) fail('a stream has a head out of range');
    return {
        lowBits: b(1), normalBits: b(2), turnBits: b(3), lineTurnBits: b(4), halving: b(5), reference: view.getUint16(6, true), sectionCount: b(8), shapeGrades: b(9), normalGrades: b(10),
        sharpness: f[0], exponent: f[1], positionExtent: f.slice(2, 5), firstRadius: f[5], radiusStep: f[6], tiltStep: f[7], fieldStep: f[8],
        shapeStep: f[9], lineStep: f[10], bendStep: f[11],
    };
}

function readSections(view, head, fail) {
    const sections = [];
    if (view.byteLength < HEAD_BYTES + SECTION_BYTES * head.sectionCount) fail('a stream is too short');
    for (let i = 0, first = 0; i < head.sectionCount; ++i) {
        const at = HEAD_BYTES + SECTION_BYTES * i, count = view.getUint32(at, true), depthTolerance = view.getFloat32(at + 4, true);
        const clipLines = view.getUint8(at + 8), flags = view.getUint8(at + 9);
        const isRight = count > 0 && clipLines <= 4 && flags <= FLAGS && !view.getUint16(at + 10, true) && depthTolerance >= 0 && depthTolerance < Infinity;
        if (!isRight || ((flags & CURVED) && !(flags & GAMMA))) fail('a stream has a section out of range');
        sections.push({ first, count, clipLines, flags, depthTolerance, curved: !!(flags & CURVED) });
        first += count;
    }
    return sections;
}

// ---- splats ----------------------------------------------------------------------------------

/** x / 2^shift, rounded to the nearest integer, halves up. */
const shifted = (x, shift) => Math.floor((x + Math.floor(2 ** shift / 2)) / 2 ** shift);

/** The last splat among those nearest to a place. */
function nearest(window, index, place) {
    let found = { normal: [0, 0], radius: [0, 0] }, least = Infinity;
    for (let i = 1; i <= WINDOW && i <= index; ++i) {
        const c = window[(index - i) % WINDOW], x = c.place[0] - place[0], y = c.place[1] - place[1], z = c.place[2] - place[2];
        const distance2 = x * x + y * y + z * z;
        if (!(distance2 < least)) continue;
        least = distance2;
        found = c;
    }
    return found;
}

/** How many bits of precision a splat has less than the largest. */
function gradeOf(head, radius) {
    if (!head.halving || radius >= head.reference) return 0;
    return Math.min(Math.floor((head.reference - radius) / head.halving), MOST_GRADE);
}

/** The bits of a turn: the rounder the ellipse, the fewer. */
function turnBits(head, elongation) {
    if (!head.halving) return head.turnBits;
    const parts = Math.floor(32 * elongation / head.halving), bits = parts ? 32 - Math.clz32(parts) : 0;
    return Math.min(bits + Math.floor(elongation / (3 * head.halving)), head.turnBits);
}

const times = (count, make) => Array.from({ length: count }, (_, k) => make(k));

function readSplat(d, head, section, near, place, fail) {
    const { flags, clipLines } = section, low = times(3, () => d.raw(head.lowBits) - Math.floor(2 ** head.lowBits / 2));
    const large = near.radius[0] + d.signed(KINDS.radius), elongation = d.unsigned(KINDS.elongation);
    if (elongation > large || large > MOST_RADIUS) fail('a stream is damaged');
    const grade = gradeOf(head, large), unit = 2 ** Math.min(grade, head.shapeGrades), coarse = Math.min(grade, head.normalGrades), most = 2 ** (head.normalBits - 1) - 1;
    const normal = times(2, (k) => (shifted(near.normal[k], coarse) + d.signed(KINDS.normal)) * 2 ** coarse);
    if (normal.some((x) => Math.abs(x) > most)) fail('a stream is damaged');
    const bits = turnBits(head, elongation), turn = d.raw(bits) * 2 ** (head.turnBits - bits);
    const tilt = times(2, () => (flags & TILTED ? d.signed(KINDS.tilt) : 0));
    const field = times(3, (k) => (flags & OWN_FIELD && (k < 2 || flags & GAMMA) ? d.signed(k < 2 ? KINDS.field : KINDS.fieldTwist) : 0));
    const shape = times(3, (k) => (flags & CURVED ? unit * d.signed(k < 2 ? KINDS.shape : KINDS.shapeTwist) : 0));
    const count = clipLines ? d.unsigned(KINDS.lines) : 0, lineUnit = 2 ** Math.min(grade, head.lineTurnBits - 1), lines = [];
    if (count > clipLines) fail('a stream is damaged');
    for (let i = 0, at = 0; i < count; ++i) {
        at += i ? d.unsigned(KINDS.lineTurn) : d.raw(head.lineTurnBits + 1 - Math.log2(lineUnit));
        lines.push([at * lineUnit, lineUnit * d.signed(KINDS.lineDistance), flags & BENDS ? lineUnit * d.signed(KINDS.lineBend) : 0]);
    }
    return { place, low, radius: [large, large - elongation], normal, turn, tilt, field, shape, lines };
}

// ---- attributes ------------------------------------------------------------------------------

/** Decodes an octahedral code as EXT_meshopt_compression's filter does, to bytes for up to 8 bits,
 *  else to shorts. */
function normalOf([codeX, codeY], bits) {
    const round = Math.fround, z = 2 ** (bits - 1) - 1 - Math.abs(codeX) - Math.abs(codeY), fold = Math.min(z, 0);
    const x = codeX + (codeX >= 0 ? fold : -fold), y = codeY + (codeY >= 0 ? fold : -fold);
    const scale = round((bits <= 8 ? 127 : 32767) / round(Math.sqrt(round(x * x + y * y + z * z))));
    return [x, y, z].map((v) => Math.trunc(round(round(v * scale) + (v >= 0 ? 0.5 : -0.5))));
}

/** Arrays of a section's attributes, by name: their numbers of components and their values. */
function makeArrays(section) {
    const { flags, count, clipLines } = section, sizes = { POSITION: 3, NORMAL: 3, TURN: 1, SCALE: 2 };
    if (flags & TILTED) sizes.TILT = 2;
    if (flags & (OWN_FIELD | CURVED)) sizes.NORMAL_FIELD = flags & GAMMA ? 3 : 2;
    if (flags & OWN_FIELD && flags & CURVED) sizes.SHAPE = 3;
    for (let k = 0; k < clipLines; ++k) sizes[`CLIP_${k}`] = flags & BENDS ? 4 : 3;
    return Object.fromEntries(Object.entries(sizes).map(([name, size]) => [name, { size, array: new Float32Array(size * count) }]));
}

function store(arrays, head, section, i, code) {
    const put = (name, values) => { if (arrays[name]) arrays[name].array.set(values.slice(0, arrays[name].size), arrays[name].size * i); };
    const isOwn = section.flags & OWN_FIELD || !section.curved, n = normalOf(code.normal, head.normalBits), length = Math.hypot(...n);
    put('POSITION', code.place.map((x, k) => x + code.low[k] / 2 ** head.lowBits));
    put('NORMAL', n.map((x) => x / length));
    put('TURN', [code.turn / 2 ** head.turnBits]);
    put('SCALE', code.radius.map((x) => head.firstRadius * Math.exp(x * head.radiusStep)));
    put('TILT', code.tilt.map((x) => x * (isOwn ? head.tiltStep : head.shapeStep)));
    put('NORMAL_FIELD', (isOwn ? code.field : code.shape).map((x) => x * (isOwn ? head.fieldStep : head.shapeStep)));
    put('SHAPE', code.shape.map((x) => x * head.shapeStep));
    for (let k = 0; k < section.clipLines; ++k) {
        const line = code.lines[k], angle = line ? Math.PI * line[0] / 2 ** head.lineTurnBits : 0;
        put(`CLIP_${k}`, line ? [Math.cos(angle), Math.sin(angle), line[1] * head.lineStep, line[2] * head.bendStep] : [1, 0, 1, 0]);
    }
}

/** Reads a stream. place(i) is POSITION of splat i of count. @returns what all splats have in common,
 *  and the sections with the arrays of their attributes. */
export function readStream(buffer, count, place, fail) {
    const view = new DataView(buffer), head = readHead(view, fail), sections = readSections(view, head, fail);
    const found = sections.reduce((sum, section) => sum + section.count, 0);
    if (found > buffer.byteLength / LEAST_BYTES) fail('a stream announces more splats than its bytes can hold');
    if (found !== count) fail(`POSITION has ${count} values for ${found} splats`);
    const d = new Decoder(new Uint8Array(buffer, HEAD_BYTES + SECTION_BYTES * sections.length), fail), window = [];
    for (const section of sections) {
        section.arrays = makeArrays(section);
        for (let i = section.first; i < section.first + section.count; ++i) {
            const at = place(i), code = readSplat(d, head, section, nearest(window, i, at), at, fail);
            store(section.arrays, head, section, i - section.first, code);
            window[i % WINDOW] = code;
        }
    }
    return { head, sections };
}

/** The attributes that a stream holds, so that accessors of them are not allowed. */
export const STREAMED = ['NORMAL', 'ROTATION', 'TURN', 'TILT', 'SCALE', 'NORMAL_FIELD', 'SHAPE', 'CLIP_0', 'CLIP_1', 'CLIP_2', 'CLIP_3'];
