// SPDX-License-Identifier: MIT
//
// raycast.js - where a ray meets splats first, as curved.frag finds it, from the numbers that the
// textures hold.
import { Ray, Vector3 } from 'three';
import { axesOf, CHUNK } from './decode.js';

const axes = new Float64Array(9), hit = { t: 0, u: 0, v: 0 };

/** A splat as raycasting needs it: axes in units of r_u, slope and second derivatives (curved.vert). */
function readSplat(batch, i, s) {
    const data = batch.splats.image.data, at = batch.splatFloats * i;
    const [qx, qy, qz, qw] = [data[at + 4], data[at + 5], data[at + 6], data[at + 7]];
    s.radius = qx * qx + qy * qy + qz * qz + qw * qw;
    const by = 1 / Math.sqrt(s.radius);
    axesOf(qx * by, qy * by, qz * by, qw * by, axes);
    s.center = [data[at], data[at + 1], data[at + 2]];
    s.ratio = data[at + 3];
    const gamma = batch.isWide ? data[at + 15] : 0;
    s.field = [-data[at + 8], -s.ratio * data[at + 9], -data[at + 10], -s.ratio * gamma, -s.ratio * data[at + 11]];
    s.shape = s.field;
    if (batch.hasShape) {
        const k = at + (batch.isWide ? 16 : 12);
        s.shape = [0, 0, -data[k], -s.ratio * data[k + 2], -s.ratio * data[k + 1]];
    }
    if (!batch.isCurved) s.shape = [0, 0, 0, 0, 0];
}

/** Whether a point lies in the ellipse, or is known to lie on its rim, and is kept by the lines that cut the splat's shape:
 *  seams, the last ones, do not. */
function isKept(batch, i, u, v, isOnRim = false) {
    if (!isOnRim && u * u + v * v > 1) return false;
    const lines = batch.clips?.image.data;
    for (let k = 0; k < batch.clipLines - batch.seamLines; ++k) {
        const at = 4 * (batch.clipLines * i + k), a = lines[at], b = lines[at + 1], across = a * v - b * u;
        if (a * u + b * v + lines[at + 2] + 0.5 * lines[at + 3] * across * across < 0) return false;
    }
    return true;
}

/** Where a ray that meets no surface meets the wall under the rim (spec 5.1), as meets_wall() in curved.frag finds it, or false.
 *  The ray is o + t d, its height over the surface c + b t + a t^2, and the wall reaches down by depth. */
function meetWall(batch, i, o, d, [c, b, a], depth) {
    const length2 = d[0] * d[0] + d[1] * d[1], away = o[0] * d[1] - o[1] * d[0], square = length2 - away * away;
    if (!(square > 0)) return false;
    const t = -(o[0] * d[0] + o[1] * d[1] + Math.sqrt(square)) / length2, over = c + t * (b + t * a);
    if (!(t >= 0 && over < 0 && over > -depth && b + 2 * a * t < 0)) return false;
    hit.u = o[0] + t * d[0];
    hit.v = o[1] + t * d[1];
    hit.t = t;
    return isKept(batch, i, hit.u, hit.v, true);
}

/** The nearest point of a splat on the ray beyond its origin, or of its wall, or false. */
function meet(batch, i, s, ray, isTwoSided) {
    const o = [], d = [], delta = [ray.origin.x - s.center[0], ray.origin.y - s.center[1], ray.origin.z - s.center[2]];
    for (let k = 0; k < 3; ++k) {
        const by = 1 / (s.radius * (k === 1 ? s.ratio : 1));
        o[k] = by * (axes[3 * k] * delta[0] + axes[3 * k + 1] * delta[1] + axes[3 * k + 2] * delta[2]);
        d[k] = by * (axes[3 * k] * ray.direction.x + axes[3 * k + 1] * ray.direction.y + axes[3 * k + 2] * ray.direction.z);
    }
    const [x, y, xx, xy, yy] = s.shape, gx = x + o[0] * xx + o[1] * xy, gy = y + o[0] * xy + o[1] * yy;
    const c = o[2] - 0.5 * ((gx + x) * o[0] + (gy + y) * o[1]), b = d[2] - gx * d[0] - gy * d[1];
    const a = -0.5 * (xx * d[0] * d[0] + 2 * xy * d[0] * d[1] + yy * d[1] * d[1]), square = b * b - 4 * a * c;
    const depth = batch.wall / s.radius, root = Math.sqrt(Math.max(square, 0)), half = 0.5 * (b > 0 ? b + root : b - root);
    const front = b > 0 ? -half / a : -c / half, back = b > 0 ? -c / half : -half / a;
    for (const t of square < 0 ? [] : isTwoSided ? [Math.min(front, back), Math.max(front, back)] : [front]) {
        hit.u = o[0] + t * d[0];
        hit.v = o[1] + t * d[1];
        hit.t = t;
        if (t >= 0 && Number.isFinite(t) && isKept(batch, i, hit.u, hit.v)) return true;
    }
    return depth > 0 && meetWall(batch, i, o, d, [c, b, a], depth);
}

/** The normal field at a point, in the object's space. */
function normalAt(s, { u, v }, out) {
    const [x, y, xx, xy, yy] = s.field, gx = x + u * xx + v * xy, gy = (y + u * xy + v * yy) / s.ratio;
    out.set(axes[6] - gx * axes[0] - gy * axes[3], axes[7] - gx * axes[1] - gy * axes[4], axes[8] - gx * axes[2] - gy * axes[5]);
    return out.normalize();
}

/** @returns the nearest hit of a ray in the object's space with batches, or null: t along the ray,
 *  normal, batch, index of the splat, u and v. isTwoSided(batch) says whether backs are hit. */
export function raycastSplats(batches, ray, isTwoSided) {
    const s = {}, normal = new Vector3(), local = new Ray().copy(ray), length = local.direction.length();
    local.direction.normalize();
    let best = null;
    for (const batch of batches) {
        const both = isTwoSided(batch);
        for (let first = 0; first < batch.count; first += CHUNK) {
            if (!local.intersectsSphere(batch.spheres[first / CHUNK])) continue;
            for (let i = first; i < Math.min(first + CHUNK, batch.count); ++i) {
                readSplat(batch, i, s);
                if (!meet(batch, i, s, local, both) || (best && hit.t >= best.t * length)) continue;
                best = { t: hit.t / length, u: hit.u, v: hit.v, batch, index: i, normal: normalAt(s, hit, normal).clone() };
            }
        }
    }
    return best;
}
