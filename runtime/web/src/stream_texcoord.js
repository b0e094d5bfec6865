// SPDX-License-Identifier: MIT
//
// stream_texcoord.js - texture coordinates in the coded stream of a primitive of splats (section
// 3.12 of the specification), as runtime/asset/stream_texcoord.c predicts them.

const LEAST_CARRIED = 0.01, TURNOVER = 0.49;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Adds s times a to r. */
function add(r, s, a) {
    for (let k = 0; k < 3; ++k) r[k] += s * a[k];
    return r;
}

/** The axes U, V, N of an octahedral code of so many bits and of a turn in half turns. */
export function axesOf([x, y], bits, turn) {
    const z = 2 ** (bits - 1) - 1 - Math.abs(x) - Math.abs(y), fold = Math.min(z, 0), n = [x + (x >= 0 ? fold : -fold), y + (y >= 0 ? fold : -fold), z];
    const length = Math.sqrt(dot(n, n)), c = Math.cos(Math.PI * turn), s = Math.sin(Math.PI * turn);
    for (let k = 0; k < 3; ++k) n[k] /= length;
    const side = n[2] < 0 ? -1 : 1, a = -1 / (side + n[2]), b = n[0] * n[1] * a;
    const b1 = [1 + side * n[0] * n[0] * a, side * b, -side * n[0]], b2 = [b, side + n[1] * n[1] * a, -n[1]];
    const u = [0, 1, 2].map((k) => c * b1[k] + s * b2[k]);
    return [u, [0, 1, 2].map((k) => n[(k + 1) % 3] * u[(k + 2) % 3] - n[(k + 2) % 3] * u[(k + 1) % 3]), n];
}

/** The gradient of a coordinate at the centre, over a unit of length. */
function gradient({ along, radius, axes }, k) {
    return [0, 1].reduce((sum, axis) => add(sum, along[axis][k] / radius[axis], axes[axis]), [0, 0, 0]);
}

/** How much the gradient of a coordinate changes over d. */
function change({ bends, radius, axes }, k, d) {
    const u = dot(d, axes[0]) / radius[0], v = dot(d, axes[1]) / radius[1];
    const out = add([0, 0, 0], (2 * u * bends[0][k] + v * bends[1][k]) / radius[0], axes[0]);
    return add(out, (u * bends[1][k] + 2 * v * bends[2][k]) / radius[1], axes[1]);
}

/** Turns a direction of the plane of one normal into that of the other; 0 for opposite ones. */
function carry(from, to, x) {
    const whole = 1 + dot(from, to), part = -dot(x, to) / whole;
    return whole < LEAST_CARRIED ? x.fill(0) : add(add(x, part, from), part, to);
}

/** The predicted change with u and v of a splat, of which all else is known, from another one. */
export function predictSlopes(from, to) {
    const d = [0, 1, 2].map((k) => to.center[k] - from.center[k]), slopes = [0, 1].map((k) => {
        const slope = carry(from.axes[2], to.axes[2], add(gradient(from, k), 0.5, change(from, k, d)));
        return add(slope, 0.5, change(to, k, d));
    });
    return [0, 1].map((axis) => slopes.map((slope) => to.radius[axis] * dot(slope, to.axes[axis])));
}

/** How far the coordinates at a splat's centre differ from those at another's, predicted. */
export function predictMove(from, to) {
    const d = [0, 1, 2].map((k) => to.center[k] - from.center[k]);
    return [0, 1].map((k) => (dot(gradient(from, k), d) + dot(gradient(to, k), d)) / 2 + (dot(change(from, k, d), d) - dot(change(to, k, d), d)) / 12);
}

/** A prediction in steps, rounded and limited to -most ... most; what is none is 0. */
export function roundPrediction(prediction, most) {
    return Number.isNaN(prediction) ? 0 : Math.floor(Math.min(Math.max(prediction, -most), most) + TURNOVER);
}
