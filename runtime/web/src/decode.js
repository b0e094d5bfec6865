// SPDX-License-Identifier: MIT
//
// decode.js - turns the attributes of a primitive of splats (sections 3.2 to 3.12 of the
// specification) into the float textures of shaders/layout.h, and checks them. Numbers are those of
// runtime/asset/values.c, unpack.c and pack.c.
import { Box3, BufferAttribute, DataTexture, FloatType, RGBAFormat, Sphere, Vector3 } from 'three';
import { readStream, STREAMED, STREAMED_TEXCOORDS } from './stream.js';

export const EXTENSION = 'PSPLAT_surface_splats';

/** Splats in a chunk, which has a sphere around it. */
export const CHUNK = 256;

/** The bits of u_finish (layout.h). */
const FINISH = { surface: 1, emissive: 2, gradient: 4, color: 8 };

const SIGNED = ['Int8Array', 'Int16Array'], UNSIGNED = ['Uint8Array', 'Uint16Array'], FLOATS = ['Float32Array'];

/** Of each attribute: numbers of components as floats, of which arrays its integers are, their
 *  numbers of components, and the version that brought the attribute. */
const TYPES = {
    POSITION: { sizes: [3], integers: [...SIGNED, ...UNSIGNED], since: 1, raw: true },
    NORMAL: { sizes: [3], integers: SIGNED, since: 1 },
    COLOR_0: { sizes: [3, 4], integers: UNSIGNED, since: 1 },
    ROTATION: { sizes: [4], integers: SIGNED, since: 1 },
    TURN: { sizes: [1], integers: UNSIGNED, since: 2 },
    TILT: { sizes: [2], integers: SIGNED, since: 2, range: 'tiltRange' },
    SCALE: { sizes: [2], integers: UNSIGNED, since: 1, range: 'scaleRange' },
    NORMAL_FIELD: { sizes: [2, 3], integers: SIGNED, since: 1, range: 'fieldRange' },
    SHAPE: { sizes: [3], integers: SIGNED, since: 3, range: 'shapeRange' },
    CLIP_0: { sizes: [3, 4], integers: SIGNED, packed: [2, 3], since: 1 },
    CLIP_1: { sizes: [3, 4], integers: SIGNED, packed: [2, 3], since: 1 },
    CLIP_2: { sizes: [3, 4], integers: SIGNED, packed: [2, 3], since: 1 },
    CLIP_3: { sizes: [3, 4], integers: SIGNED, packed: [2, 3], since: 1 },
    COLOR_U: { sizes: [3], integers: SIGNED, since: 2, range: 'colorRange' },
    COLOR_V: { sizes: [3], integers: SIGNED, since: 2, range: 'colorRange' },
    OCCLUSION_ROUGHNESS_METALLIC: { sizes: [3], integers: UNSIGNED, since: 2 },
    EMISSIVE: { sizes: [3], integers: UNSIGNED, since: 2 },
    TEXCOORD_0: { sizes: [2], integers: [...SIGNED, ...UNSIGNED], since: 3, raw: true },
    TEXCOORD_U: { sizes: [2], integers: SIGNED, since: 3, range: 'texcoordRange' },
    TEXCOORD_V: { sizes: [2], integers: SIGNED, since: 3, range: 'texcoordRange' },
    TEXCOORD_UU: { sizes: [2], integers: SIGNED, since: 3, range: 'texcoordBendRange' },
    TEXCOORD_UV: { sizes: [2], integers: SIGNED, since: 3, range: 'texcoordBendRange' },
    TEXCOORD_VV: { sizes: [2], integers: SIGNED, since: 3, range: 'texcoordBendRange' },
};
const OF_GLTF = new Set(['POSITION', 'NORMAL', 'COLOR_0', 'TEXCOORD_0']);

function fail(text) {
    throw new Error(`${EXTENSION}: ${text}`);
}

// ---- the extension object --------------------------------------------------------------------

function positive(object, key, fallback, least = Number.MIN_VALUE) {
    const value = object[key] ?? fallback;
    if (value !== undefined && !(Number.isFinite(value) && value >= least)) {
        fail(`${key} must be a number ${least > 0 ? 'greater than' : 'of at least'} 0`);
    }
    return value;
}

function numbers(object, key, count, check) {
    const value = object[key];
    if (value === undefined) return value;
    const isRight = Array.isArray(value) && value.length === count && value.every(Number.isFinite);
    if (!isRight || !check(value)) fail(`${key} is not ${count} numbers in their range`);
    return value;
}

/** Returns the version that a primitive states. */
function readVersion({ version }) {
    if (!Number.isInteger(version)) fail('version is missing');
    if (version < 1 || version > 4) fail(`version ${version} is not one of 1 to 4`);
    return version;
}

/** What a primitive with a stream (section 3.12) says about itself, and what it does not. */
const BESIDE_STREAM = ['colorRange', 'texcoordRange', 'texcoordBendRange'];
const IN_STREAM = ['clipLines', 'depthTolerance', 'positionExtent', 'kernel', 'scaleRange', 'tiltRange', 'fieldRange', 'turnRange', 'clipRange', 'curved',
    'shapeRange', 'bendRange'];

/** Returns a number of seams among so many clip lines. */
function readSeams(value, clipLines) {
    if (!Number.isInteger(value) || value < 0 || value > clipLines) fail(`seamLines must be integers from 0 to the number of clip lines, which is ${clipLines}`);
    return value;
}

/** Returns the numbers of seams of a stream's sections (section 3.12). */
function readSectionSeams(value, sections) {
    if (value === undefined) return sections.map(() => 0);
    if (!Array.isArray(value) || value.length !== sections.length) fail(`seamLines is not an array for the stream's ${sections.length} sections`);
    return sections.map(({ clipLines }, k) => readSeams(value[k], clipLines));
}

/** Returns what a primitive says about itself (section 3.1), with defaults. */
function readObject(object) {
    const { version, clipLines } = object;
    if (!Number.isInteger(clipLines) || clipLines < 0 || clipLines > 4) fail('clipLines must be an integer from 0 to 4');
    if (object.depthTolerance === undefined) fail('depthTolerance is missing');
    if (object.positionExtent === undefined) fail('positionExtent is missing');
    if (object.curved && version < 3) fail(`curved is of version 3, the primitive states ${version}`);
    const kernel = object.kernel ?? {};
    return {
        version,
        clipLines,
        seamLines: readSeams(object.seamLines ?? 0, clipLines),
        curved: !!object.curved,
        depthTolerance: positive(object, 'depthTolerance', undefined, 0),
        positionExtent: numbers(object, 'positionExtent', 3, (v) => v.every((x) => x >= 0)),
        sharpness: positive(kernel, 'sharpness', 2),
        exponent: positive(kernel, 'exponent', 2),
        scaleRange: numbers(object, 'scaleRange', 2, ([a, b]) => a > 0 && b >= a),
        clipRange: numbers(object, 'clipRange', 2, (v) => v.every((x) => x > 0 && x <= 65536)) ?? [1, 1],
        turnRange: positive(object, 'turnRange', 1),
        tiltRange: positive(object, 'tiltRange'),
        fieldRange: positive(object, 'fieldRange'),
        shapeRange: positive(object, 'shapeRange'),
        bendRange: positive(object, 'bendRange'),
        colorRange: positive(object, 'colorRange'),
        texcoordRange: positive(object, 'texcoordRange'),
        texcoordBendRange: positive(object, 'texcoordBendRange'),
    };
}

// ---- attributes ------------------------------------------------------------------------------

/** Returns the index of each attribute's accessor by the attribute's name without its prefix. */
function findAttributes(attributes) {
    const found = {};
    for (const name of Object.keys(TYPES)) {
        if (OF_GLTF.has(name)) {
            if (attributes[name] !== undefined) found[name] = attributes[name];
            continue;
        }
        const one = attributes[`_${EXTENSION}:${name}`], other = attributes[`${EXTENSION}:${name}`];
        if (one !== undefined && other !== undefined) fail(`${name} occurs with and without an underscore`);
        if (one !== undefined || other !== undefined) found[name] = one ?? other;
    }
    return found;
}

function requireAll(found, names, because) {
    for (const name of names) if (found[name] === undefined) fail(`${name} is missing${because}`);
}

/** Checks that attributes that come together are complete. */
function checkPairs(found) {
    if (found.COLOR_U !== undefined || found.COLOR_V !== undefined) requireAll(found, ['COLOR_U', 'COLOR_V'], ' beside the other');
    const first = ['TEXCOORD_U', 'TEXCOORD_V'], second = ['TEXCOORD_UU', 'TEXCOORD_UV', 'TEXCOORD_VV'];
    if (second.some((name) => found[name] !== undefined)) requireAll(found, [...second, ...first], ' beside the second order');
    if (first.some((name) => found[name] !== undefined)) requireAll(found, [...first, 'TEXCOORD_0'], ' beside the first order');
}

/** Checks which attributes are required, allowed and forbidden (rule 8 of section 9). */
function checkPresence(found, set) {
    requireAll(found, ['POSITION', 'NORMAL', 'SCALE'], '');
    if (found.ROTATION !== undefined && found.TURN !== undefined) fail('a primitive has either ROTATION or TURN');
    if (found.TURN === undefined) requireAll(found, ['ROTATION'], '');
    if (found.TILT !== undefined) requireAll(found, ['TURN'], ' beside TILT');
    checkPairs(found);
    for (let k = 0; k < 4; ++k) {
        const name = `CLIP_${k}`;
        if (k < set.clipLines) requireAll(found, [name], `, clipLines is ${set.clipLines}`);
        else if (found[name] !== undefined) fail(`${name} is present although clipLines is ${set.clipLines}`);
    }
    if (found.SHAPE !== undefined && !set.curved) fail('SHAPE is present although the primitive is not curved');
}

/** An attribute: get(i, k) is component k of splat i, normalised integers as glTF says. */
function open(name, attribute, set, count) {
    const type = TYPES[name], array = (attribute.isInterleavedBufferAttribute ? attribute.data : attribute).array;
    const isFloat = FLOATS.includes(array.constructor.name);
    const sizes = isFloat ? type.sizes : type.packed ?? type.sizes;
    if (type.since > set.version) fail(`${name} is of version ${type.since}, the primitive states ${set.version}`);
    if (!isFloat && !type.integers.includes(array.constructor.name)) fail(`${name} has a component type that it does not have`);
    if (!isFloat && !type.raw && !attribute.normalized) fail(`${name} has integers that are not normalized`);
    if (!sizes.includes(attribute.itemSize)) fail(`${name} has ${attribute.itemSize} components instead of ${sizes.join(' or ')}`);
    if (attribute.count !== count) fail(`${name} has ${attribute.count} values for ${count} splats`);
    if (!isFloat && type.range && set[type.range] === undefined) fail(`${type.range}, which the integers of ${name} need, is missing`);
    const isBent = attribute.itemSize === (isFloat ? 4 : 3);
    if (name.startsWith('CLIP_') && isBent && set.version < 3) fail(`bent clip lines are of version 3, the primitive states ${set.version}`);
    if (name.startsWith('CLIP_') && isBent && !isFloat && set.bendRange === undefined) fail('bendRange, which the integers of bends need, is missing');
    return { name, size: attribute.itemSize, isFloat, steps: array.BYTES_PER_ELEMENT === 1 ? 255 : 65535,
        get: (i, k) => attribute.getComponent(i, k) };
}

/** Reads a splat's numbers times what integers are multiplied by, and refuses those that are not
 *  finite. */
function read(a, i, factor, out) {
    const by = a.isFloat ? 1 : factor ?? 1;
    for (let k = 0; k < a.size; ++k) {
        out[k] = by * a.get(i, k);
        if (!Number.isFinite(out[k])) fail(`splat ${i}: ${a.name} is not finite`);
    }
    return out;
}

function normalise(a, i, out, what) {
    let square = 0;
    for (let k = 0; k < a.size; ++k) square += out[k] * out[k];
    const length = Math.sqrt(square);
    if (!(length >= 0.99 && length <= 1.01)) fail(`splat ${i}: ${a.name} ${what}`);
    for (let k = 0; k < a.size; ++k) out[k] /= length;
}

function checkParts(a, i, values) {
    for (let k = 0; k < a.size; ++k) if (!(values[k] >= 0 && values[k] <= 1)) fail(`splat ${i}: ${a.name} is not from 0 to 1`);
}

// ---- frames ----------------------------------------------------------------------------------

/** Eq. (0) of section 3.3 as a quaternion: B1, B2, N are x, y, z turned the short way from z to N,
 *  near -z from -z after half a turn about x; U is B1 turned about N. */
function turnedQuaternion([x, y, z], turn, q) {
    const c = Math.cos(0.5 * Math.PI * turn), s = Math.sin(0.5 * Math.PI * turn), below = z < 0;
    const w = 1 + Math.abs(z), scale = 1 / Math.sqrt(x * x + y * y + w * w);
    const p = [below ? w : -y, below ? 0 : x, below ? x : 0, below ? -y : w];
    q[0] = (p[0] * c + p[1] * s) * scale;
    q[1] = (p[1] * c - p[0] * s) * scale;
    q[2] = (p[2] * c + p[3] * s) * scale;
    q[3] = (p[3] * c - p[2] * s) * scale;
}

/** Writes U, V, N of a unit quaternion, three numbers each. */
export function axesOf(x, y, z, w, out) {
    out[0] = 1 - 2 * (y * y + z * z);
    out[1] = 2 * (x * y + w * z);
    out[2] = 2 * (x * z - w * y);
    out[3] = 2 * (x * y - w * z);
    out[4] = 1 - 2 * (x * x + z * z);
    out[5] = 2 * (y * z + w * x);
    out[6] = 2 * (x * z + w * y);
    out[7] = 2 * (y * z - w * x);
    out[8] = 1 - 2 * (x * x + y * y);
    return out;
}

/** Reads radii; of integers x each is r0 (r1 / r0)^x (section 3.9). */
function readRadii(a, i, set, out) {
    read(a, i, 1, out);
    if (!a.isFloat) {
        const [r0, r1] = set.scaleRange, rate = Math.log(r1 / r0);
        if (out[1] > out[0] && out[1] - out[0] < 1.5 / a.steps) out[0] = out[1];
        for (let k = 0; k < 2; ++k) out[k] = r0 * Math.exp(rate * out[k]);
    }
    if (!(out[0] >= out[1] && out[1] > 0)) fail(`splat ${i}: SCALE is not two radii, the larger first, above 0`);
}

/** Checks (3a) of section 3.5; fields of two numbers are scaled down to it. */
function checkField(a, i, splat) {
    const f = splat.field, tilt = Math.hypot(splat.tilt[0], splat.tilt[1]);
    const change = Math.sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2] * (1 + splat.ratio * splat.ratio));
    if (tilt + change <= 20) return;
    if (a.size === 3) fail(`splat ${i}: NORMAL_FIELD bends the normal by more than section 3.5 allows`);
    for (let k = 0; k < 2; ++k) f[k] *= (20 - tilt) / change;
}

/** Reads centre, radii, axes, tilt, field and shape of a splat. */
function readSurface(of, set, i, s) {
    read(of.POSITION, i, 1, s.center);
    readRadii(of.SCALE, i, set, s.radii);
    s.ratio = s.radii[1] / s.radii[0];
    normalise(of.NORMAL, i, read(of.NORMAL, i, 1, s.normal), 'is not unit');
    if (of.TURN) {
        read(of.TURN, i, set.turnRange, s.turn);
        if (!(Math.abs(s.turn[0]) <= 1)) fail(`splat ${i}: TURN is not from -1 to 1`);
        turnedQuaternion(s.normal, s.turn[0], s.q);
    } else normalise(of.ROTATION, i, read(of.ROTATION, i, 1, s.q), 'is not a unit quaternion');
    axesOf(s.q[0], s.q[1], s.q[2], s.q[3], s.axes);
    if (of.TURN) {
        s.tilt.fill(0);
        if (of.TILT) read(of.TILT, i, set.tiltRange, s.tilt);
    } else {
        const n = s.normal, a = s.axes, up = n[0] * a[6] + n[1] * a[7] + n[2] * a[8];
        if (!(up >= 0.05)) fail(`splat ${i}: NORMAL leaves the plane's normal N by more than acos 0.05`);
        for (let k = 0; k < 2; ++k) s.tilt[k] = (n[0] * a[3 * k] + n[1] * a[3 * k + 1] + n[2] * a[3 * k + 2]) / up;
    }
    if (Math.hypot(s.tilt[0], s.tilt[1]) > 19.98) fail(`splat ${i}: NORMAL leaves the plane's normal N by more than acos 0.05`);
    s.field.fill(0);
    if (of.NORMAL_FIELD) {
        read(of.NORMAL_FIELD, i, set.fieldRange, s.field);
        checkField(of.NORMAL_FIELD, i, s);
    }
    s.slope = of.SHAPE ? 0 : Math.hypot(s.tilt[0], s.tilt[1]);
    s.second = s.field;
    if (of.SHAPE) s.second = read(of.SHAPE, i, set.shapeRange, s.shape);
    const [a, b, c] = s.second;
    if (set.curved && !(s.slope + Math.sqrt(a * a + b * b + c * c * (1 + s.ratio * s.ratio)) <= 4)) {
        fail(`splat ${i}: ${of.SHAPE ? 'SHAPE' : 'NORMAL_FIELD'} makes the surface steeper than section 3.4 allows`);
    }
}

/** Reads clip line k of a splat as a, b, c and kappa. */
function readLine(a, i, set, out) {
    read(a, i, 1, out);
    if (!a.isFloat) {
        const turn = Math.PI * out[0] * set.clipRange[0], distance = out[1] * set.clipRange[1];
        out[3] = a.size === 3 ? out[2] * set.bendRange : 0;
        out[0] = Math.cos(turn);
        out[1] = Math.sin(turn);
        out[2] = distance;
    } else if (a.size === 3) out[3] = 0;
    if (out[0] === 0 && out[1] === 0) fail(`splat ${i}: ${a.name} is no line: a and b are 0`);
    if (!(Math.abs(out[3]) <= 4)) fail(`splat ${i}: ${a.name} is bent by more than 4`);
    return out;
}

// ---- textures --------------------------------------------------------------------------------

/** An array for rows of `row` splats with so many texels, and the texture that shows it. */
function makeTexture(count, row, texels) {
    if (!texels) return null;
    const height = Math.ceil(count / row), data = new Float32Array(4 * row * texels * height);
    const texture = new DataTexture(data, row * texels, height, RGBAFormat, FloatType);
    texture.needsUpdate = true;
    return texture;
}

/** How far down the wall under the rim of a curved splat reaches, and how far behind it what it hides begins, in depth
 *  tolerances (layout.h). */
const WALL = 0.25;
export const WALL_SHIFT = 8;

/** Enlarges boxes by a splat's whole ellipse, of curved ones by more than that. @returns how far the
 *  surface leaves its tangent plane. */
function enlarge(s, isCurved, boxes) {
    const [ru, rv] = s.radii, tilt = s.slope ? s.tilt : [0, 0];
    const [a, b, c] = [s.second[0], s.ratio * s.second[2], s.ratio * s.second[1]];
    const sagitta = isCurved ? 0.5 * ru * (Math.abs(0.5 * (a + c)) + Math.hypot(0.5 * (a - c), b)) : 0;
    const reach = [0, 0, 0];
    for (let k = 0; k < 3; ++k) {
        const n = isCurved ? s.axes[6 + k] : 0;
        reach[k] = Math.hypot(ru * (s.axes[k] - tilt[0] * n), rv * (s.axes[3 + k] - tilt[1] * n)) + sagitta * Math.abs(n);
    }
    for (const box of boxes) {
        box.min.set(Math.min(box.min.x, s.center[0] - reach[0]), Math.min(box.min.y, s.center[1] - reach[1]), Math.min(box.min.z, s.center[2] - reach[2]));
        box.max.set(Math.max(box.max.x, s.center[0] + reach[0]), Math.max(box.max.y, s.center[1] + reach[1]), Math.max(box.max.z, s.center[2] + reach[2]));
    }
    return sagitta;
}

/** A polygon of 16 corners around the unit circle. */
const CIRCLE = Array.from({ length: 16 }, (_, k) => [Math.cos(k * Math.PI / 8) / Math.cos(Math.PI / 16), Math.sin(k * Math.PI / 8) / Math.cos(Math.PI / 16)]);

/** Clips a polygon by a line (Sutherland and Hodgman 1974). A line that bulges out keeps no more than
 *  the straight one that lies as much farther out as it does at the polygon's or the circle's ends. */
function cut(polygon, [a, b, c, kappa]) {
    const reach = Math.min(a * a + b * b, polygon.reduce((most, [u, v]) => Math.max(most, (a * v - b * u) ** 2), 0));
    const bulge = 0.5 * Math.max(kappa, 0) * reach;
    const height = polygon.map(([u, v]) => a * u + b * v + c + bulge), kept = [];
    polygon.forEach((p, k) => {
        const next = (k + 1) % polygon.length, t = height[k] / (height[k] - height[next]);
        if (height[k] >= 0) kept.push(p);
        if ((height[k] >= 0) !== (height[next] >= 0)) kept.push([p[0] + t * (polygon[next][0] - p[0]), p[1] + t * (polygon[next][1] - p[1])]);
    });
    return kept;
}

/** @returns whether a point lies in a convex polygon whose corners go round it to the left. */
function isInside(polygon, u, v) {
    return polygon.every((p, k) => {
        const q = polygon[(k + 1) % polygon.length];
        return (q[0] - p[0]) * (v - p[1]) - (q[1] - p[1]) * (u - p[0]) >= 0;
    });
}

/** Enlarges a range by a quadratic over a polygon: x u + y v + (xx u^2 + 2 xy u v + yy v^2) / 2. It is least and greatest at
 *  a corner, within an edge, or where its gradient vanishes. */
function enlargeRange(polygon, x, y, xx, xy, yy, range) {
    const at = (u, v) => {
        const f = x * u + y * v + 0.5 * (xx * u * u + 2 * xy * u * v + yy * v * v);
        range[0] = Math.min(range[0], f);
        range[1] = Math.max(range[1], f);
    };
    polygon.forEach(([u, v], k) => {
        const q = polygon[(k + 1) % polygon.length], du = q[0] - u, dv = q[1] - v;
        const t = -((x + xx * u + xy * v) * du + (y + xy * u + yy * v) * dv) / (xx * du * du + 2 * xy * du * dv + yy * dv * dv);
        at(u, v);
        if (t > 0 && t < 1) at(u + t * du, v + t * dv);
    });
    const det = xx * yy - xy * xy, u = (xy * y - yy * x) / det, v = (xy * x - xx * y) / det;
    if (Number.isFinite(u + v) && u * u + v * v < 2 && isInside(polygon, u, v)) at(u, v);
}

const range = [0, 0];

/** Enlarges a box by what clip lines leave of a splat. lines are those that cut its shape. */
function enlargeTight(s, isCurved, lines, box) {
    let polygon = CIRCLE;
    for (const line of [...lines, ...lines]) polygon = cut(polygon, line); // the second time the ends are nearer
    if (!polygon.length) return;
    const [ru, rv] = s.radii, tilt = isCurved && s.slope ? s.tilt : [0, 0];
    const [a, b, c] = isCurved ? [s.second[0], s.ratio * s.second[2], s.ratio * s.second[1]] : [0, 0, 0];
    for (let k = 0; k < 3; ++k) {
        const n = s.axes[6 + k], axis = 'xyz'[k];
        range[0] = Infinity;
        range[1] = -Infinity;
        enlargeRange(polygon, ru * (s.axes[k] - tilt[0] * n), rv * (s.axes[3 + k] - tilt[1] * n), -ru * a * n, -ru * b * n, -ru * c * n, range);
        box.min[axis] = Math.min(box.min[axis], s.center[k] + range[0]);
        box.max[axis] = Math.max(box.max[axis], s.center[k] + range[1]);
    }
}

/** Writes what a splat has in the textures of colours, finishes and texture coordinates. */
function packRest(of, set, i, batch, v) {
    let alpha = 1;
    if (of.COLOR_0) {
        checkParts(of.COLOR_0, i, read(of.COLOR_0, i, 1, v));
        batch.splats.image.data.set(v.subarray(0, 3), batch.splatFloats * i + 12);
        if (of.COLOR_0.size === 4) alpha = v[3];
    }
    if (batch.finishes) {
        let at = batch.finishFloats * i;
        for (const [name, factor] of [['OCCLUSION_ROUGHNESS_METALLIC'], ['EMISSIVE'], ['COLOR_U', set.colorRange], ['COLOR_V', set.colorRange]]) {
            if (!of[name]) continue;
            read(of[name], i, factor, v);
            if (!factor) checkParts(of[name], i, v);
            batch.finishes.image.data.set(v.subarray(0, 3), at);
            at += 4;
        }
    }
    if (batch.texcoords) {
        const names = ['TEXCOORD_0', 'TEXCOORD_U', 'TEXCOORD_V', 'TEXCOORD_UU', 'TEXCOORD_UV', 'TEXCOORD_VV'];
        const ranges = [1, set.texcoordRange, set.texcoordRange, set.texcoordBendRange, set.texcoordBendRange, set.texcoordBendRange];
        const data = batch.texcoords.image.data, texels = batch.texcoordFloats / 4;
        for (let k = 0; k < 1.5 * texels; ++k) {
            if (of[names[k]]) read(of[names[k]], i, ranges[k], v);
            else v.fill(0);
            for (let c = 0; c < 2; ++c) {
                const at = 2 * k + c;
                data[batch.texcoordFloats * i + 4 * Math.floor(at / 3) + at % 3] = v[c];
            }
        }
        for (let k = 0; k < texels; ++k) data[batch.texcoordFloats * i + 4 * k + 3] = alpha;
    }
}

function packSplat(s, batch, i) {
    const data = batch.splats.image.data, at = batch.splatFloats * i, root = Math.sqrt(s.radii[0]);
    data.set([s.center[0], s.center[1], s.center[2], s.ratio, s.q[0] * root, s.q[1] * root, s.q[2] * root, s.q[3] * root,
        s.tilt[0], s.tilt[1], s.field[0], s.field[1]], at);
    if (batch.isWide) {
        data.fill(1, at + 12, at + 15);
        data[at + 15] = s.field[2];
    }
    if (batch.hasShape) data.set(s.shape.subarray(0, 3), at + (batch.isWide ? 16 : 12));
}

/** Returns a batch without its values: what follows from which attributes there are. */
function describe(of, set, count) {
    const hasGamma = of.NORMAL_FIELD?.size === 3, isWide = hasGamma || !!of.COLOR_0, hasShape = set.curved && !!of.SHAPE;
    if (set.curved && !hasShape && !hasGamma) fail('a curved primitive has a NORMAL_FIELD of three numbers or a SHAPE');
    const surface = of.OCCLUSION_ROUGHNESS_METALLIC ? FINISH.surface : 0, emissive = of.EMISSIVE ? FINISH.emissive : 0;
    const gradient = of.COLOR_U ? FINISH.gradient : 0, row = isWide && hasShape ? 256 : 512;
    const splatTexels = 3 + isWide + hasShape, finishTexels = !!surface + !!emissive + (gradient ? 2 : 0);
    const texcoordTexels = !of.TEXCOORD_0 || set.version < 3 ? 0 : of.TEXCOORD_UU ? 4 : 2;
    const bends = [0, 1, 2, 3].some((k) => of[`CLIP_${k}`] && of[`CLIP_${k}`].size === (of[`CLIP_${k}`].isFloat ? 4 : 3));
    return {
        count,
        clipLines: set.clipLines,
        seamLines: set.seamLines,
        cutCount: 0, // splats that a line cuts which is no seam
        isCurved: set.curved,
        hasColor: !!of.COLOR_0,
        hasGamma,
        isWide,
        hasShape,
        hasBends: bends,
        finish: surface | emissive | gradient,
        finishUniform: surface | emissive | gradient | (of.COLOR_0 ? FINISH.color : 0),
        hasSurface: !!surface,
        hasEmissive: !!emissive,
        hasGradient: !!gradient,
        hasTexcoordBend: texcoordTexels === 4,
        sharpness: set.sharpness,
        exponent: set.exponent,
        depthTolerance: set.depthTolerance,
        wall: set.curved ? WALL * set.depthTolerance : 0,
        splatFloats: 4 * splatTexels,
        finishFloats: 4 * finishTexels,
        texcoordFloats: 4 * texcoordTexels,
        splats: makeTexture(count, row, splatTexels),
        clips: makeTexture(count, row, set.clipLines),
        finishes: makeTexture(count, row, finishTexels),
        texcoords: makeTexture(count, row, texcoordTexels),
        bounds: new Box3(), // of whole ellipses and walls, as the renderer's
        box: new Box3(), // of what clip lines that are no seams leave of them, and of walls
        spheres: [],
        sagitta: 0,
    };
}

/** Another tool may have scaled POSITION without SCALE (section 6.2). */
function checkExtent(centers, stated) {
    const found = centers.getSize(new Vector3()).toArray(), largest = Math.max(...found, ...stated);
    if (found.some((x, k) => Math.abs(x - stated[k]) > 1e-4 * largest)) {
        fail(`POSITION extends over ${found.map((x) => +x.toPrecision(6)).join(' x ')}, was written as ${stated.join(' x ')}: another tool rescaled it but not the radii`);
    }
}

function decodeAll(of, set, batch) {
    const s = { center: [0, 0, 0], radii: [0, 0], normal: [0, 0, 0], q: [0, 0, 0, 1], turn: [0], tilt: [0, 0], field: [0, 0, 0], shape: new Float32Array(3), axes: new Float64Array(9) };
    const v = new Float32Array(4), lines = Array.from({ length: set.clipLines }, () => [0, 0, 0, 0]), centers = new Box3(), chunk = new Box3(), point = new Vector3();
    for (let i = 0; i < batch.count; ++i) {
        readSurface(of, set, i, s);
        packSplat(s, batch, i);
        centers.expandByPoint(point.fromArray(s.center));
        const sagitta = enlarge(s, set.curved, [batch.bounds]);
        batch.sagitta = Math.max(batch.sagitta, sagitta);
        for (let k = 0; k < set.clipLines; ++k) batch.clips.image.data.set(readLine(of[`CLIP_${k}`], i, set, lines[k]), 4 * (set.clipLines * i + k));
        const cutting = lines.slice(0, set.clipLines - set.seamLines);
        batch.cutCount += cutting.some(([a, b, c, kappa]) => a !== 1 || b !== 0 || c !== 1 || kappa !== 0);
        enlargeTight(s, set.curved, cutting, chunk);
        packRest(of, set, i, batch, v);
        if (i % CHUNK === CHUNK - 1 || i === batch.count - 1) {
            chunk.expandByScalar(batch.wall);
            batch.box.union(chunk);
            batch.spheres.push(chunk.getBoundingSphere(new Sphere()));
            chunk.makeEmpty();
        }
    }
    batch.bounds.expandByScalar(batch.wall);
    return centers;
}

// ---- primitives ------------------------------------------------------------------------------

/** @returns the attributes of a primitive's accessors, by name. */
async function loadAttributes(found, accessor) {
    const names = Object.keys(found), attributes = await Promise.all(names.map((name) => accessor(found[name])));
    return Object.fromEntries(names.map((name, k) => [name, attributes[k]]));
}

function decodeBatch(attributes, set, count) {
    const of = {};
    for (const [name, attribute] of Object.entries(attributes)) of[name] = open(name, attribute, set, count);
    const batch = describe(of, set, count);
    batch.extent = decodeAll(of, set, batch);
    return batch;
}

/** Part of an attribute, with the interface that open asks for. */
function partOf(attribute, first, count) {
    const { isInterleavedBufferAttribute, data, array, itemSize, normalized } = attribute;
    return { isInterleavedBufferAttribute, data, array, itemSize, normalized, count, getComponent: (i, k) => attribute.getComponent(first + i, k) };
}

/** Distances between integers are exact, so that every machine finds the same nearest splat. */
function checkCoarse({ array, data, normalized }) {
    if (normalized || (array ?? data.array) instanceof Float32Array) fail('POSITION: beside a stream, components must be integers that are not normalized');
}

/** Decodes a primitive with a stream: a batch for each section. */
async function decodeStreamed(primitive, object, accessor, view) {
    const found = findAttributes(primitive.attributes), set = { version: object.version };
    for (const name of IN_STREAM) if (object[name] !== undefined) fail(`${name} is present although the primitive has a stream`);
    for (const name of STREAMED) if (found[name] !== undefined) fail(`${name} is present although the primitive has a stream`);
    for (const name of BESIDE_STREAM) set[name] = positive(object, name);
    requireAll(found, ['POSITION'], '');
    checkPairs(found);
    const [bytes, attributes] = await Promise.all([view(object.stream), loadAttributes(found, accessor)]), position = attributes.POSITION;
    checkCoarse(position);
    const beside = {
        place: (i, out) => { for (let k = 0; k < 3; ++k) out[k] = position.getComponent(i, k); },
        seams: (sections) => readSectionSeams(object.seamLines, sections),
        image: (i) => [0, 1].map((k) => (attributes.TEXCOORD_0 ?? fail('TEXCOORD_0 is missing beside a stream with texture coordinates')).getComponent(i, k)),
    };
    const { head, sections } = readStream(bytes, position.count, beside, fail), centers = new Box3();
    for (const name of STREAMED_TEXCOORDS) if (head.hasTexcoord && found[name] !== undefined) fail(`${name} is present although the primitive has a stream`);
    const batches = sections.map(({ arrays, first, count, clipLines, seamLines, curved, depthTolerance }) => {
        const parts = Object.fromEntries(Object.entries(attributes).map(([name, attribute]) => [name, partOf(attribute, first, count)]));
        for (const [name, { size, array }] of Object.entries(arrays)) parts[name] = new BufferAttribute(array, size);
        const batch = decodeBatch(parts, { ...set, clipLines, seamLines, curved, depthTolerance, sharpness: head.sharpness, exponent: head.exponent }, count);
        centers.union(batch.extent);
        return batch;
    });
    checkExtent(centers, head.positionExtent);
    return batches;
}

/** Decodes a primitive of splats. accessor(index) returns a promise of three's attribute, view(index)
 *  one of the ArrayBuffer of a buffer view. @returns the batches: textures, bounds and what they hold,
 *  without a material. */
export async function decodePrimitive(primitive, accessor, view) {
    if (primitive.mode !== 0) fail('the mode of a primitive of splats is 0');
    if (primitive.indices !== undefined || primitive.targets) fail('a primitive of splats has neither indices nor morph targets');
    const object = primitive.extensions[EXTENSION];
    if (readVersion(object) >= 4 && object.stream !== undefined) return decodeStreamed(primitive, object, accessor, view);
    const set = readObject(object), found = findAttributes(primitive.attributes);
    checkPresence(found, set);
    if (set.version < 3) delete found.TEXCOORD_0;
    const attributes = await loadAttributes(found, accessor), batch = decodeBatch(attributes, set, attributes.POSITION.count);
    checkExtent(batch.extent, set.positionExtent);
    return [batch];
}
