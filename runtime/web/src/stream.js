// SPDX-License-Identifier: MIT
//
// stream.js - reads the coded stream of a primitive of splats (section 3.12 of the specification)
// into the attributes that it holds. Numbers are those of runtime/asset/stream.c.

import { axesOf, predictMove, predictSlopes, roundPrediction } from './stream_texcoord.js';

const HEAD_BYTES = 60, TEXCOORD_HEAD_BYTES = 12, SECTION_BYTES = 12, MOST_SECTIONS = 32, WINDOW = 32, LEAST_BYTES = 3, MOST_ALIGNING = 3;
const MOST_GRADE = 7, MOST_LENGTH = 17, MOST_RADIUS = 65535, ADAPTED = 40, LEAST_PART = 32;
const MOST_TEXCOORD_LOW_BITS = 15, MOST_TEXCOORD = 32767, MOST_TEXCOORD_AT = 2 ** 23 - 1;

/** The flags of a section. */
const CURVED = 1, OWN_FIELD = 2, BENDS = 4, TILTED = 8, GAMMA = 16, TEXCOORD_BENDS = 32, FLAGS = 63;

/** The kinds of numbers, each with probabilities of its own. */
const KINDS = { radius: 0, elongation: 1, normal: 2, tilt: 3, field: 4, fieldTwist: 5, shape: 6, shapeTwist: 7, lines: 8, lineTurn: 9, lineDistance: 10, lineBend: 11, texcoordBend: 12, texcoordTwist: 13, texcoordSlope: 14, texcoord: 15 };

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
        for (let i = 0; i < 4; ++i) this.value = (this.value << 8 | this.byte()) >>> 0;
        this.ones = new Uint16Array(MODEL * Object.keys(KINDS).length).fill(32768);
        this.seen = new Uint8Array(this.ones.length);
        this.rates = Array.from({ length: ADAPTED + 1 }, (_, n) => Math.floor(131072 / (2 * n + 3)));
    }

    byte() {
        if (this.at >= this.bytes.length + 4) this.fail('a stream is damaged');
        return this.at < this.bytes.length ? this.bytes[this.at++] : (++this.at, 0);
    }

    /** Reads a bit, 0 or 1. Numbers wrap in 32 bits, as in the C runtime. */
    split(bound) {
        const bit = this.value < bound ? 1 : 0;
        if (!bit) this.value -= bound;
        this.range = bit ? bound : this.range - bound;
        for (; this.range < 0x1000000; this.range *= 256) this.value = (this.value << 8 | this.byte()) >>> 0;
        return bit;
    }

    bit(m) {
        const one = this.ones[m], bit = this.split((this.range >>> 16) * one), rate = this.rates[this.seen[m]];
        const next = bit ? one + ((65536 - one) * rate >>> 16) : one - (one * rate >>> 16);
        this.ones[m] = Math.min(Math.max(next, LEAST_PART), 65536 - LEAST_PART);
        if (this.seen[m] < ADAPTED) ++this.seen[m];
        return bit;
    }

    raw(bits) {
        let value = 0;
        for (let i = 0; i < bits; ++i) value = value * 2 + this.split(this.range >>> 1);
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
    if (!isRight || b(9) > MOST_GRADE || b(10) > Math.min(MOST_GRADE, b(2) - 4) || !(f[0] > 0) || !(f[1] > 0)) fail('a stream has a head out of range');
    return {
        lowBits: b(1), normalBits: b(2), turnBits: b(3), lineTurnBits: b(4), halving: b(5), reference: view.getUint16(6, true), sectionCount: b(8), shapeGrades: b(9), normalGrades: b(10),
        sharpness: f[0], exponent: f[1], positionExtent: f.slice(2, 5), firstRadius: f[5], radiusStep: f[6], tiltStep: f[7], fieldStep: f[8],
        shapeStep: f[9], lineStep: f[10], bendStep: f[11], ...readTexcoordHead(view, b(11), fail),
    };
}

/** What is behind the rest of the head where there are texture coordinates. */
function readTexcoordHead(view, lowBits, fail) {
    if (!lowBits) return { size: HEAD_BYTES, hasTexcoord: false };
    if (view.byteLength < HEAD_BYTES + TEXCOORD_HEAD_BYTES) fail('a stream is too short');
    const [at, slope, bend] = [0, 4, 8].map((i) => view.getFloat32(HEAD_BYTES + i, true)), bits = view.getUint32(HEAD_BYTES, true);
    if (![at, slope, bend].every((x) => x >= 0 && x < Infinity)) fail('a stream has a number that is none or below 0');
    if (lowBits - 1 > MOST_TEXCOORD_LOW_BITS || bits < 0x800000 || bits & 0x7fffff || !(slope > 0)) fail('a stream has a head out of range');
    return { size: HEAD_BYTES + TEXCOORD_HEAD_BYTES, hasTexcoord: true, texcoordLowBits: lowBits - 1, texcoordStep: at, texcoordSlopeStep: slope, texcoordBendStep: bend };
}

function readSections(view, head, fail) {
    const sections = [];
    if (view.byteLength < head.size + SECTION_BYTES * head.sectionCount) fail('a stream is too short');
    for (let i = 0, first = 0; i < head.sectionCount; ++i) {
        const at = head.size + SECTION_BYTES * i, count = view.getUint32(at, true), depthTolerance = view.getFloat32(at + 4, true);
        const clipLines = view.getUint8(at + 8), flags = view.getUint8(at + 9);
        const isRight = count > 0 && clipLines <= 4 && flags <= FLAGS && !view.getUint16(at + 10, true) && depthTolerance >= 0 && depthTolerance < Infinity;
        if (!isRight || ((flags & CURVED) && !(flags & GAMMA)) || ((flags & TEXCOORD_BENDS) && !(head.texcoordBendStep > 0))) fail('a stream has a section out of range');
        sections.push({ first, count, clipLines, flags, depthTolerance, curved: !!(flags & CURVED) });
        first += count;
    }
    return sections;
}

// ---- splats ----------------------------------------------------------------------------------

/** x / 2^shift, rounded to the nearest integer, halves up. */
const shifted = (x, shift) => Math.floor((x + Math.floor(2 ** shift / 2)) / 2 ** shift);

/** The integers of the splat that is read, and what later ones need of the last 32. */
function makeCode() {
    return {
        place: new Float64Array(3), low: new Int32Array(3), radius: new Int32Array(2), normal: new Int32Array(2), turn: 0, tilt: new Int32Array(2), field: new Int32Array(3),
        shape: new Int32Array(3), lineCount: 0, lines: new Int32Array(12), direction: new Float64Array(3), images: [],
        window: { places: new Float64Array(3 * WINDOW), radii: new Int32Array(WINDOW + 1), normals: new Int32Array(2 * (WINDOW + 1)) },
    };
}

/** Where the last splat among those nearest to the place is in the window; WINDOW, where all is 0, for
 *  the first. */
function nearest({ places }, index, place) {
    let found = WINDOW, least = Infinity;
    for (let i = 1; i <= WINDOW && i <= index; ++i) {
        const at = (index - i) % WINDOW, x = places[3 * at] - place[0], y = places[3 * at + 1] - place[1], z = places[3 * at + 2] - place[2];
        const distance2 = x * x + y * y + z * z;
        if (!(distance2 < least)) continue;
        least = distance2;
        found = at;
    }
    return found;
}

function remember({ window: { places, radii, normals }, place, radius, normal }, index) {
    const at = index % WINDOW;
    for (let k = 0; k < 3; ++k) places[3 * at + k] = place[k];
    for (let k = 0; k < 2; ++k) normals[2 * at + k] = normal[k];
    radii[at] = radius[0];
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

function readFrame(d, head, code, near, fail) {
    const { window, normal } = code, most = 2 ** (head.normalBits - 1) - 1;
    for (let k = 0; k < 3; ++k) code.low[k] = d.raw(head.lowBits) - Math.floor(2 ** head.lowBits / 2);
    const large = window.radii[near] + d.signed(KINDS.radius), elongation = d.unsigned(KINDS.elongation);
    if (elongation > large || large > MOST_RADIUS) fail('a stream is damaged');
    code.radius[0] = large;
    code.radius[1] = large - elongation;
    const coarse = Math.min(gradeOf(head, large), head.normalGrades);
    for (let k = 0; k < 2; ++k) {
        normal[k] = (shifted(window.normals[2 * near + k], coarse) + d.signed(KINDS.normal)) * 2 ** coarse;
        if (Math.abs(normal[k]) > most) fail('a stream is damaged');
    }
    const bits = turnBits(head, elongation);
    code.turn = d.raw(bits) * 2 ** (head.turnBits - bits);
}

function readField(d, head, { flags }, { tilt, field, shape, radius }) {
    const unit = 2 ** Math.min(gradeOf(head, radius[0]), head.shapeGrades), fields = flags & OWN_FIELD ? (flags & GAMMA ? 3 : 2) : 0;
    for (let k = 0; k < 2; ++k) tilt[k] = flags & TILTED ? d.signed(KINDS.tilt) : 0;
    for (let k = 0; k < 3; ++k) field[k] = k < fields ? d.signed(k < 2 ? KINDS.field : KINDS.fieldTwist) : 0;
    for (let k = 0; k < 3; ++k) shape[k] = flags & CURVED ? unit * d.signed(k < 2 ? KINDS.shape : KINDS.shapeTwist) : 0;
}

function readLines(d, head, { flags, clipLines }, code, fail) {
    const { lines } = code, coarse = Math.min(gradeOf(head, code.radius[0]), head.lineTurnBits - 1), unit = 2 ** coarse;
    code.lineCount = clipLines ? d.unsigned(KINDS.lines) : 0;
    if (code.lineCount > clipLines) fail('a stream is damaged');
    for (let i = 0, at = 0; i < code.lineCount; ++i) {
        at += i ? d.unsigned(KINDS.lineTurn) : d.raw(head.lineTurnBits + 1 - coarse);
        lines[3 * i] = at * unit;
        lines[3 * i + 1] = unit * d.signed(KINDS.lineDistance);
        lines[3 * i + 2] = flags & BENDS ? unit * d.signed(KINDS.lineBend) : 0;
    }
}

// ---- texture coordinates ---------------------------------------------------------------------

/** The last of those of the last 32 splats that are nearest in space and in the image together. */
function nearestInChart(images, index, place, coarse) {
    let found, least = Infinity;
    for (let i = 1; i <= WINDOW && i <= index; ++i) {
        const other = images[(index - i) % WINDOW], x = other.place[0] - place[0], y = other.place[1] - place[1], z = other.place[2] - place[2];
        const s = other.coarse[0] - coarse[0], t = other.coarse[1] - coarse[1], distance = (x * x + y * y + z * z) * (1 + (s * s + t * t));
        if (!(distance < least)) continue;
        least = distance;
        found = other;
    }
    return found;
}

/** Reads the texture coordinates of a splat, of which all else is known. image(i) is its TEXCOORD_0. */
function readTexcoord(d, head, { flags }, code, index, image, fail) {
    const coarse = image.map((x) => Math.round(x / head.texcoordStep / 2 ** head.texcoordLowBits)), half = Math.floor(2 ** head.texcoordLowBits / 2);
    if (!image.every((x) => Math.abs(x / head.texcoordStep) <= MOST_TEXCOORD_AT + 1)) fail('a stream is beside a TEXCOORD_0 out of range');
    const near = (kind, predicted, most) => {
        const number = predicted + d.signed(kind);
        if (Math.abs(number) > most) fail('a stream is damaged');
        return number;
    };
    const from = nearestInChart(code.images, index, code.place, coarse), field = {
        coarse, place: [...code.place], center: [0, 1, 2].map((k) => code.place[k] + code.low[k] / 2 ** head.lowBits),
        axes: axesOf(code.normal, head.normalBits, code.turn / 2 ** head.turnBits), radius: [0, 1].map((k) => head.firstRadius * Math.exp(code.radius[k] * head.radiusStep)),
    };
    field.bends = [KINDS.texcoordBend, KINDS.texcoordTwist, KINDS.texcoordBend].map((kind) => [0, 1].map(() => (flags & TEXCOORD_BENDS ? near(kind, 0, MOST_TEXCOORD) * head.texcoordBendStep : 0)));
    const along = from ? predictSlopes(from, field) : [[0, 0], [0, 0]];
    field.along = along.map((pair) => pair.map((x) => near(KINDS.texcoordSlope, roundPrediction(x / head.texcoordSlopeStep, MOST_TEXCOORD), MOST_TEXCOORD) * head.texcoordSlopeStep));
    const move = from ? predictMove(from, field) : [0, 0];
    field.at = move.map((x, k) => {
        const predicted = (from ? from.at[k] : 0) + roundPrediction(x / head.texcoordStep, 2 ** 24), low = coarse[k] * 2 ** head.texcoordLowBits - half;
        return near(KINDS.texcoord, Math.min(Math.max(predicted, low), half ? low + 2 * half - 1 : low), MOST_TEXCOORD_AT);
    });
    code.images[index % WINDOW] = field;
}

// ---- attributes ------------------------------------------------------------------------------

/** Decodes an octahedral code as EXT_meshopt_compression's filter does, to bytes for up to 8 bits,
 *  else to shorts, and normalises that. */
function readDirection([codeX, codeY], bits, direction) {
    const round = Math.fround, z = 2 ** (bits - 1) - 1 - Math.abs(codeX) - Math.abs(codeY), fold = Math.min(z, 0);
    direction[0] = codeX + (codeX >= 0 ? fold : -fold);
    direction[1] = codeY + (codeY >= 0 ? fold : -fold);
    direction[2] = z;
    const scale = round((bits <= 8 ? 127 : 32767) / round(Math.sqrt(round(direction[0] ** 2 + direction[1] ** 2 + z * z))));
    let square = 0;
    for (let k = 0; k < 3; ++k) {
        const v = direction[k];
        direction[k] = Math.trunc(round(round(v * scale) + (v >= 0 ? 0.5 : -0.5)));
        square += direction[k] ** 2;
    }
    for (let k = 0; k < 3; ++k) direction[k] /= Math.sqrt(square);
}

const TEXCOORD_BEND_NAMES = ['TEXCOORD_UU', 'TEXCOORD_UV', 'TEXCOORD_VV'];

/** Arrays of a section's attributes, by name: their numbers of components and their values. */
function makeArrays(section, hasTexcoord) {
    const { flags, count, clipLines } = section, sizes = { POSITION: 3, NORMAL: 3, TURN: 1, SCALE: 2 };
    if (flags & TILTED) sizes.TILT = 2;
    if (flags & (OWN_FIELD | CURVED)) sizes.NORMAL_FIELD = flags & GAMMA ? 3 : 2;
    if (flags & OWN_FIELD && flags & CURVED) sizes.SHAPE = 3;
    for (let k = 0; k < clipLines; ++k) sizes[`CLIP_${k}`] = flags & BENDS ? 4 : 3;
    if (hasTexcoord) for (const name of ['TEXCOORD_0', 'TEXCOORD_U', 'TEXCOORD_V']) sizes[name] = 2;
    if (flags & TEXCOORD_BENDS) for (const name of TEXCOORD_BEND_NAMES) sizes[name] = 2;
    return Object.fromEntries(Object.entries(sizes).map(([name, size]) => [name, { size, array: new Float32Array(size * count) }]));
}

/** Writes the first numbers of values, times a step, where an attribute is there. */
function put(attribute, i, values, step) {
    if (!attribute) return;
    const { array, size } = attribute;
    for (let k = 0; k < size; ++k) array[size * i + k] = values[k] * step;
}

/** Writes line k of a splat's lines, or a line that cuts nothing where there is no such line. */
function putLine({ array, size }, i, head, code, k) {
    const has = k >= 0, at = size * i, angle = has ? Math.PI * code.lines[3 * k] / 2 ** head.lineTurnBits : 0;
    array[at] = Math.cos(angle);
    array[at + 1] = Math.sin(angle);
    array[at + 2] = has ? code.lines[3 * k + 1] * head.lineStep : 1;
    if (size === 4) array[at + 3] = has ? code.lines[3 * k + 2] * head.bendStep : 0;
}

/** Returns which line of a splat with so many has a place among those of its section; -1: none. Seams
 *  are the last, and what is missing lies before them. */
function lineAt(place, count, { clipLines, seamLines }) {
    if (place < count - seamLines) return place;
    const fromLast = clipLines - place;
    return fromLast <= Math.min(count, seamLines) ? count - fromLast : -1;
}

function store(arrays, lines, head, section, i, code) {
    const isOwn = section.flags & OWN_FIELD || !section.curved, { POSITION, SCALE } = arrays;
    for (let k = 0; k < 3; ++k) POSITION.array[3 * i + k] = code.place[k] + code.low[k] / 2 ** head.lowBits;
    for (let k = 0; k < 2; ++k) SCALE.array[2 * i + k] = head.firstRadius * Math.exp(code.radius[k] * head.radiusStep);
    readDirection(code.normal, head.normalBits, code.direction);
    put(arrays.NORMAL, i, code.direction, 1);
    arrays.TURN.array[i] = code.turn / 2 ** head.turnBits;
    put(arrays.TILT, i, code.tilt, isOwn ? head.tiltStep : head.shapeStep);
    put(arrays.NORMAL_FIELD, i, isOwn ? code.field : code.shape, isOwn ? head.fieldStep : head.shapeStep);
    put(arrays.SHAPE, i, code.shape, head.shapeStep);
    for (let k = 0; k < lines.length; ++k) putLine(lines[k], i, head, code, lineAt(k, code.lineCount, section));
    if (!head.hasTexcoord) return;
    const { at, along, bends } = code.images[(section.first + i) % WINDOW];
    put(arrays.TEXCOORD_0, i, at, head.texcoordStep);
    put(arrays.TEXCOORD_U, i, along[0], 1);
    put(arrays.TEXCOORD_V, i, along[1], 1);
    for (let k = 0; k < 3; ++k) put(arrays[TEXCOORD_BEND_NAMES[k]], i, bends[k], 1);
}

/** Reads the splats of a section. */
function readSection(d, head, section, code, { place, image }, fail) {
    const arrays = section.arrays = makeArrays(section, head.hasTexcoord), lines = [0, 1, 2, 3].slice(0, section.clipLines).map((k) => arrays[`CLIP_${k}`]);
    for (let i = section.first; i < section.first + section.count; ++i) {
        place(i, code.place);
        readFrame(d, head, code, nearest(code.window, i, code.place), fail);
        readField(d, head, section, code);
        readLines(d, head, section, code, fail);
        if (head.hasTexcoord) readTexcoord(d, head, section, code, i, image(i), fail);
        store(arrays, lines, head, section, i - section.first, code);
        remember(code, i);
    }
}

/** Whether nothing is behind the last splat but zeros that make up LEAST_BYTES a splat, or align what
 *  follows. */
function ends({ at, bytes }, size, count) {
    if (bytes.length - at > MOST_ALIGNING && Math.floor(size / LEAST_BYTES) > count + 1) return false;
    return bytes.subarray(at).every((x) => x === 0);
}

/** Reads a stream. beside.place(i, out) stores POSITION of splat i of count in out, beside.image(i) returns its TEXCOORD_0, beside.seams(sections) the number of seams
 *  among the lines of each section. @returns what all splats have in common,
 *  and the sections with the arrays of their attributes. */
export function readStream(buffer, count, beside, fail) {
    const view = new DataView(buffer), head = readHead(view, fail), sections = readSections(view, head, fail);
    for (const [k, seams] of beside.seams(sections).entries()) sections[k].seamLines = seams;
    const found = sections.reduce((sum, section) => sum + section.count, 0);
    if (found > buffer.byteLength / LEAST_BYTES) fail('a stream announces more splats than its bytes can hold');
    if (found !== count) fail(`POSITION has ${count} values for ${found} splats`);
    const d = new Decoder(new Uint8Array(buffer, head.size + SECTION_BYTES * sections.length), fail), code = makeCode();
    for (const section of sections) readSection(d, head, section, code, beside, fail);
    if (!ends(d, buffer.byteLength, count)) fail('a stream has bytes behind its splats');
    return { head, sections };
}

/** The attributes that a stream holds, so that accessors of them are not allowed. */
export const STREAMED = ['NORMAL', 'ROTATION', 'TURN', 'TILT', 'SCALE', 'NORMAL_FIELD', 'SHAPE', 'CLIP_0', 'CLIP_1', 'CLIP_2', 'CLIP_3'];

/** The attributes that a stream with texture coordinates holds besides. */
export const STREAMED_TEXCOORDS = ['TEXCOORD_U', 'TEXCOORD_V', ...TEXCOORD_BEND_NAMES];
