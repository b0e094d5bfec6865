// SPDX-License-Identifier: MIT
//
// levels.js - levels of detail of a mesh (section 3.13): an object that shows the one that suits the
// view, chosen as psplat_model_choose_level of the C runtime does.
import { LOD, Matrix4, Object3D, Vector2, Vector4 } from 'three';

// Where normals err by so many degrees, the outline counts as it is; the weight of normals beside
// outlines, and of the proven distance (eq. 4d).
const USUAL_NORMAL = 5, NORMAL_EXPONENT = 1.5, DISTANCE_WEIGHT = 0.25;

const DEFAULT_TAU = 0.5; // pixels

const modelview = new Matrix4(), viewport = new Vector4();

/** @returns the error of a level as it is seen, in pixels, where a unit is so many pixels. */
export function levelError({ distance, normal, outline }, pixels) {
    return Math.max(DISTANCE_WEIGHT * distance * pixels, outline * pixels * (normal / USUAL_NORMAL) ** NORMAL_EXPONENT);
}

/** @returns by how much a matrix stretches at most: the root of the largest eigenvalue of the products
 *  of its columns (Smith: Eigenvalues of a symmetric 3 x 3 matrix, 1961). */
function stretchOf({ elements: m }) {
    const largest = Math.max(...[0, 1, 2, 4, 5, 6, 8, 9, 10].map((i) => Math.abs(m[i])));
    if (!(largest > 0) || !Number.isFinite(largest)) return largest;
    const a = [0, 1, 2].map((i) => [0, 1, 2].map((k) => [0, 1, 2].reduce((sum, row) => sum + m[4 * i + row] / largest * (m[4 * k + row] / largest), 0)));
    const mean = (a[0][0] + a[1][1] + a[2][2]) / 3;
    for (let i = 0; i < 3; ++i) a[i][i] -= mean;
    const p = Math.sqrt(a.flat().reduce((sum, x) => sum + x * x, 0) / 6);
    if (!(p > 0)) return largest * Math.sqrt(mean);
    const determinant = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) + a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    const angle = Math.acos(Math.min(Math.max(determinant / (2 * p ** 3), -1), 1)) / 3;
    return largest * Math.sqrt(mean + 2 * p * Math.cos(angle));
}

/** @returns the least and the greatest w of clip space of a box's corners. */
function depthsOf(box, camera) {
    const p = camera.projectionMatrix.elements, m = modelview.elements, depths = [];
    for (let corner = 0; corner < 8; ++corner) {
        const at = [0, 1, 2].map((axis) => (corner >> axis & 1 ? box.max : box.min).getComponent(axis));
        depths.push([0, 1, 2].reduce((w, row) => w + p[4 * row + 3] * (m[12 + row] + m[row] * at[0] + m[4 + row] * at[1] + m[8 + row] * at[2]), p[15]));
    }
    return [Math.min(...depths), Math.max(...depths)];
}

export class PhongSplatsLOD extends LOD {
    /** @param levels { object, distance, normal, outline } of each level, the finest first; objects are
     *  PhongSplats. */
    constructor(levels = []) {
        super();
        this.type = 'PhongSplatsLOD';
        this.isPhongSplatsLOD = true;
        this.tau = DEFAULT_TAU;
        this.hysteresis = 0.1;
        this.resolution = null;
        this.currentLevel = 0;
        this.views = new WeakMap(); // by camera: what drew the object with it last, and which level
        this.lastRenderer = null;
        this.addLevels(levels);
    }

    /** three's way to add an object from a distance on, which says nothing of errors. */
    addLevel() {
        throw new Error('PhongSplatsLOD: levels and their errors are given to the constructor, not to addLevel');
    }

    removeLevel() {
        throw new Error('PhongSplatsLOD: levels stay as the constructor made them; make another object of those that remain');
    }

    addLevels(levels) {
        for (const { object, distance, normal, outline } of levels) {
            this.levels.push({ object, distance: 0, hysteresis: 0, errors: { distance, normal, outline } });
            this.add(object);
        }
        this.showLevel(0);
    }

    copy(source) {
        Object3D.prototype.copy.call(this, source, false);
        this.autoUpdate = source.autoUpdate;
        this.tau = source.tau;
        this.hysteresis = source.hysteresis;
        this.resolution = source.resolution;
        this.addLevels(source.levels.map(({ object, errors }) => ({ object: object.clone(), ...errors })));
        return this;
    }

    getCurrentLevel() {
        return this.currentLevel;
    }

    /** @returns the coarsest level whose error in pixels, at the corner of the finest one's box that is
     *  nearest to the eye, is at most tau; a tau that is not above 0 is the default. Changes nothing. */
    chooseLevel(camera, width, height, { tau = this.tau, hysteresis = this.hysteresis, current = this.currentLevel } = {}) {
        const p = camera.projectionMatrix.elements, last = this.levels.length - 1;
        if (last < 1) return 0;
        modelview.multiplyMatrices(camera.matrixWorldInverse, this.matrixWorld);
        const [least, greatest] = depthsOf(this.levels[0].object.geometry.boundingBox, camera);
        if (greatest <= 0) return last;
        if (!(least > 0)) return 0;
        const atOne = 0.5 * Math.max(Math.hypot(p[0], p[4], p[8]) * width, Math.hypot(p[1], p[5], p[9]) * height);
        const pixels = atOne * stretchOf(modelview) / least;
        const limit = tau > 0 ? tau : DEFAULT_TAU;
        let chosen = 0;
        for (let level = 1; level <= last; ++level) {
            const most = level > current ? limit * (1 - hysteresis) : limit;
            if (!(levelError(this.levels[level].errors, pixels) <= most)) break;
            chosen = level;
        }
        return chosen;
    }

    showLevel(level) {
        this.currentLevel = level;
        this.levels.forEach(({ object }, k) => { object.visible = k === level; });
    }

    viewOf(camera) {
        if (!this.views.has(camera)) this.views.set(camera, { renderer: null, level: this.currentLevel });
        return this.views.get(camera);
    }

    /** Tells what draws one of the levels with a camera. Renderers are not kept alive. */
    noteRenderer(camera, renderer) {
        const view = this.viewOf(camera);
        if (view.renderer?.deref() !== renderer) view.renderer = new WeakRef(renderer);
        this.lastRenderer = view.renderer;
    }

    /** @returns the size of the picture that is about to be drawn with a camera, null if none is known:
     *  that of the viewport that its renderer has now; the renderer is the one that drew with the camera
     *  last, or any that drew the object. Before one did, the picture is taken to be as large as the window. */
    sizeOf(camera) {
        const eyes = (camera.cameras ?? []).filter((eye) => eye.viewport);
        if (eyes.length) return new Vector2(Math.max(...eyes.map((eye) => eye.viewport.z)), Math.max(...eyes.map((eye) => eye.viewport.w)));
        const renderer = (this.views.get(camera)?.renderer ?? this.lastRenderer)?.deref();
        if (renderer) return new Vector2(renderer.getCurrentViewport(viewport).z, viewport.w);
        const { innerWidth, innerHeight } = globalThis; // workers have none
        return innerWidth > 0 && innerHeight > 0 ? new Vector2(innerWidth, innerHeight) : null;
    }

    /** three's hook before each render: shows the level for its picture. */
    update(camera) {
        if (!this.levels.length) return;
        const view = this.viewOf(camera), size = this.resolution ?? this.sizeOf(camera);
        view.level = size ? this.chooseLevel(camera, size.x, size.y, { current: view.level }) : 0;
        if (view.level !== this.currentLevel) this.showLevel(view.level);
    }

    /** A ray hits what is shown. */
    raycast(raycaster, intersects) {
        this.levels[this.currentLevel]?.object.raycast(raycaster, intersects);
        return false; // the levels are not asked once more
    }

    /** Frees the textures and programs of all levels, as PhongSplats.dispose() does. */
    dispose() {
        for (const { object } of this.levels) object.dispose();
    }
}
