// SPDX-License-Identifier: MIT
//
// camera.js - what the shaders need of a view, and of a batch's place in it, in double precision as
// runtime/renderer/camera.c and depth_span.c compute it.
import { Matrix3, Matrix4, Vector2, Vector3 } from 'three';

const corner = new Vector3();

/** Calls f with the corners of a box. */
function eachCorner(box, f) {
    for (let k = 0; k < 8; ++k) {
        f(corner.set(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z));
    }
}

/** Returns row `row` of m times (p, 1). */
function rowTimes(m, row, p) {
    return m[row] * p.x + m[4 + row] * p.y + m[8 + row] * p.z + m[12 + row];
}

/** Where a batch lies in a view. */
export class Placement {
    constructor() {
        this.modelview = new Matrix4();
        this.clip = new Matrix4();
        this.normal = new Matrix3();
        this.scale = 1; // of lengths, on average: |det|^(1/3)
        this.isNear = false; // the near plane may cut the box
    }

    /** @returns false where the matrices are singular, so that nothing is drawn (section 4). */
    set(world, view) {
        this.modelview.multiplyMatrices(view, world);
        const e = this.modelview.elements, det = this.modelview.determinant();
        if (!Number.isFinite(det) || det === 0) return false;
        this.scale = Math.cbrt(Math.abs(det));
        const by = this.scale / det, n = this.normal.elements;
        for (let c = 0; c < 3; ++c) {
            const a = 4 * ((c + 1) % 3), b = 4 * ((c + 2) % 3);
            for (let k = 0; k < 3; ++k) {
                const i = (k + 1) % 3, j = (k + 2) % 3;
                n[3 * c + k] = (e[a + i] * e[b + j] - e[a + j] * e[b + i]) * by;
            }
        }
        return true;
    }

    /** Finds what depends on the projection. */
    project(projection, bounds) {
        this.clip.multiplyMatrices(projection, this.modelview);
        this.isNear = false;
        const c = this.clip.elements;
        eachCorner(bounds, (p) => { this.isNear ||= !(rowTimes(c, 2, p) + rowTimes(c, 3, p) > 0); });
    }

    /** @returns by how many pixels images of points of the box move, at most, where the points move
     *  by a length. */
    pixels(bounds, length, width, height) {
        const c = this.clip.elements, rows = [0, 1, 3].map((r) => length * Math.hypot(c[r], c[4 + r], c[8 + r]));
        let least = Infinity;
        eachCorner(bounds, (p) => { least = Math.min(least, rowTimes(c, 3, p) - rows[2]); });
        if (!(least > 0)) return Infinity;
        return Math.hypot(0.5 * width * (rows[0] + rows[2]), 0.5 * height * (rows[1] + rows[2])) / least;
    }
}

/** The part of the depth range that is in use, -1 ... 1 each. */
export class DepthSpan {
    constructor() {
        this.low = Infinity;
        this.high = -Infinity;
    }

    /** Adds a box; depth_span.c says how much room it gets. */
    add(modelview, projection, bounds, shift) {
        const m = modelview.elements, p = projection.elements, clips = [];
        eachCorner(bounds, (at) => {
            const eye = new Vector3(rowTimes(m, 0, at), rowTimes(m, 1, at), rowTimes(m, 2, at));
            clips.push([0, 1, 2, 3].map((row) => rowTimes(p, row, eye)));
        });
        if (isOutside(clips)) return;
        const length = Math.hypot(p[3], p[7], p[11]);
        let low = Infinity, high = -Infinity, room = 0;
        for (const [, , z, w] of clips) {
            if (!(w > 0) || !Number.isFinite(z / w)) {
                this.low = -1;
                this.high = 1;
                return;
            }
            const byScale = Math.abs(z - p[14] - z / w * (w - p[15])) / w;
            const byLength = length > 0 ? byScale * length / w : Math.abs(p[10] / w);
            low = Math.min(low, z / w);
            high = Math.max(high, z / w);
            room = Math.max(room, byScale / 4096 + byLength * shift);
        }
        this.low = Math.min(this.low, Math.max(low - 2 * (high - low) - room, -1));
        this.high = Math.max(this.high, Math.min(high + room, 1));
    }

    get isEmpty() {
        return !(this.low < this.high);
    }
}

/** @returns whether all corners lie behind the eye or beyond one side of the view. */
function isOutside(clips) {
    let outside = 127;
    for (const [x, y, z, w] of clips) {
        outside &= (w <= 0 ? 1 : 0) | (x < -w ? 2 : 0) | (x > w ? 4 : 0) | (y < -w ? 8 : 0) | (y > w ? 16 : 0) | (z < -w ? 32 : 0) | (z > w ? 64 : 0);
    }
    return outside !== 0;
}

/** A camera as the shaders see it. */
export class SplatCamera {
    constructor() {
        this.view = new Matrix4();
        this.projection = new Matrix4();
        this.inverse = new Matrix4(); // of the projection
        this.ray = new Matrix3(); // from pixel x, y, 1 to the view ray
        this.unproject = new Matrix4(); // from pixel x, y and window depth to eye space
        this.direction = new Vector3();
        this.halfViewport = new Vector3();
        this.toHost = new Vector2(1, 0);
        this.planes = new Vector3();
        this.isPerspective = true;
    }

    /** Takes three's camera, a viewport in pixels, and whether the depth buffer is reversed, which the
     *  camera's projection becomes only when three first draws with it. */
    set(camera, width, height, isReversed) {
        this.view.copy(camera.matrixWorldInverse);
        this.host = standardProjection(camera.projectionMatrix, camera.reversedDepth === true);
        this.isReversed = isReversed;
        this.width = width;
        this.height = height;
        const e = this.host.elements, near = e[14] / (e[10] - 1), far = e[14] / (e[10] + 1);
        this.isPerspective = e[3] !== 0 || e[7] !== 0 || e[11] !== 0;
        this.planes.set(near, Number.isFinite(far) && far > near ? 1 / (far - near) : 0, Number.isFinite(far) && far > near ? 1 : 0);
        this.fit(null);
    }

    /** Fits the depth range to a span, and finds all that depends on it. */
    fit(span) {
        this.span = span;
        const middle = span ? 0.5 * (span.low + span.high) : 0, half = span ? Math.max(0.5 * (span.high - span.low), 2 ** -44) : 1;
        const p = this.projection.copy(this.host).elements;
        for (let k = 0; k < 4; ++k) p[4 * k + 2] = (p[4 * k + 2] - middle * p[4 * k + 3]) / half;
        this.toHost.set(half, 0.5 + 0.5 * middle - 0.5 * half);
        if (this.isReversed) this.toHost.set(-this.toHost.x, 1 - this.toHost.y);
        const i = this.inverse.copy(this.projection).invert().elements;
        this.unproject.makeScale(2 / this.width, 2 / this.height, 2).setPosition(-1, -1, -1).premultiply(this.inverse);
        this.halfViewport.set(0.5 * this.width, 0.5 * this.height, 0.5);
        for (let k = 0; k < 3; ++k) {
            const x = this.isPerspective ? i[k] : 0, y = this.isPerspective ? i[4 + k] : 0;
            this.ray.elements[k] = 2 * x / this.width;
            this.ray.elements[3 + k] = 2 * y / this.height;
            this.ray.elements[6 + k] = i[8 + k] + (this.isPerspective ? i[12 + k] : 0) - x - y;
        }
        if (this.isPerspective) this.direction.set(0, 0, 0);
        else this.direction.set(i[8], i[9], i[10]);
    }

    /** Sets the uniforms of a splat pass. */
    apply(u, placement, tolerance) {
        const p = this.projection.elements;
        u.u_modelview.value.copy(placement.modelview);
        u.u_projection.value.copy(this.projection);
        u.u_normal_matrix.value.copy(placement.normal);
        u.u_half_viewport.value.copy(this.halfViewport);
        u.u_shift.value.set(this.isPerspective ? -p[14] : -p[10], this.isPerspective ? 1 : 0, Math.max(tolerance * placement.scale, 1e-30));
        u.u_view_direction.value.copy(this.direction);
        u.u_ray.value.copy(this.ray);
        u.u_unproject.value.copy(this.unproject);
        u.u_unstretch.value = 1 / placement.scale;
    }
}

/** @returns a projection whose depths are -1 ... 1 from near to far; three's are 1 ... 0 with a
 *  reversed depth buffer. */
function standardProjection(projection, isReversed) {
    const m = projection.clone(), e = m.elements;
    if (isReversed) for (let k = 0; k < 4; ++k) e[4 * k + 2] = e[4 * k + 3] - 2 * e[4 * k + 2];
    return m;
}

/** Finds the pixels, -1 ... 1, that a box may cover: x0, y0, x1, y1 with room for a pixel. */
export function screenRect(clip, bounds, width, height, rect) {
    const c = clip.elements;
    let isBehind = false;
    rect.set(1, 1, -1, -1);
    eachCorner(bounds, (p) => {
        const w = rowTimes(c, 3, p), x = rowTimes(c, 0, p) / w, y = rowTimes(c, 1, p) / w;
        isBehind ||= !(w > 0);
        rect.set(Math.min(rect.x, x), Math.min(rect.y, y), Math.max(rect.z, x), Math.max(rect.w, y));
    });
    if (isBehind) return rect.set(-1, -1, 1, 1);
    const px = 2 / width, py = 2 / height;
    return rect.set(Math.max(rect.x - px, -1), Math.max(rect.y - py, -1), Math.min(rect.z + px, 1), Math.min(rect.w + py, 1));
}
