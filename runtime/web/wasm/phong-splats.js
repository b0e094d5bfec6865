// SPDX-License-Identifier: MIT
//
// phong-splats.js - Phong splats on a canvas, drawn by the C runtime as WebAssembly: for pages
// without three.js.
//
//     const renderer = await PhongSplatsRenderer.create(canvas);
//     const model = await renderer.open(await (await fetch('model.glb')).arrayBuffer());
//     renderer.draw(model, { view: lookAt([2, 1, 3], model.center), projection: perspective(40, canvas.width / canvas.height, 0.1, 100) });
import { makeGl } from './gl.js';

const SHADINGS = ['lit', 'unlit', 'toon', 'normal', 'depth', 'overdraw', 'splats'], LIGHTS = ['directional', 'point', 'spot'];
const MAX_LIGHTS = 8, LIGHT_NUMBERS = 14, VIEW_NUMBERS = 40 + MAX_LIGHTS * LIGHT_NUMBERS; // as module.c has them

const DISPOSED = 'a model, a pose or the renderer was disposed';

/** What the runtime refuses: `message` is its text, `code` its psplat_result. */
export class PhongSplatsError extends Error {
    constructor(message, code) {
        super(message);
        this.name = 'PhongSplatsError';
        this.code = code;
    }
}

/** Where the parts of a model are at a time of one of its animations; Model.createPose makes it. */
class Pose {
    constructor(model) {
        const { exports, handle } = model.renderer;
        this.model = model;
        this.handle = exports.ps_pose_create(handle, model.asset) || model.renderer.fail();
    }

    /** Moves all to where it is at `seconds` of animation `index`. For a loop pass `seconds % duration`. */
    set(index, seconds) {
        const { renderer } = this.model;
        if (!this.handle) throw new PhongSplatsError(DISPOSED, 1);
        if (!Number.isInteger(index)) throw new TypeError(`the index of an animation is an integer, not ${index}`);
        if (!renderer.exports.ps_pose_set(renderer.handle, this.handle, index, seconds)) renderer.fail();
        return this;
    }

    /** Moves all to where the file has it. */
    rest() {
        if (!this.handle) throw new PhongSplatsError(DISPOSED, 1);
        this.model.renderer.exports.ps_pose_rest(this.handle);
        return this;
    }

    /** Frees the pose, once or more often. Its model frees it, too. */
    dispose() {
        if (this.handle) this.model.renderer.exports.ps_pose_destroy(this.handle);
        this.model.poses.delete(this);
        this.handle = 0;
    }
}

/** A model on the GPU; PhongSplatsRenderer.open makes it. asset: 0, or what its animations need. */
class Model {
    constructor(renderer, handle, asset, animations, splatCount, bounds) {
        Object.assign(this, { renderer, handle, asset, animations, splatCount, min: bounds.slice(0, 3), max: bounds.slice(3), poses: new Set() });
        this.center = this.min.map((low, k) => 0.5 * (low + this.max[k]));
        this.radius = 0.5 * Math.hypot(...this.min.map((low, k) => this.max[k] - low));
    }

    /** @returns a pose of the model, at rest, for an item of draw(): a model is in as many poses at once as it has items. */
    createPose() {
        if (!this.handle) throw new PhongSplatsError(DISPOSED, 1);
        if (!this.asset) throw new PhongSplatsError('the model has no animations', 1);
        const pose = new Pose(this);
        this.poses.add(pose);
        return pose;
    }

    /** Frees the model and its poses, once or more often. */
    dispose() {
        if (!this.handle) return;
        for (const pose of [...this.poses]) pose.dispose();
        this.renderer.exports.ps_model_destroy(this.renderer.handle, this.handle);
        this.renderer.exports.ps_close(this.asset);
        this.renderer.models.delete(this);
        this.handle = 0;
    }
}

async function compile(wasm) {
    if (wasm instanceof WebAssembly.Module) return wasm;
    if (wasm instanceof ArrayBuffer || ArrayBuffer.isView(wasm)) return WebAssembly.compile(wasm);
    const response = await fetch(wasm);
    if (!response.ok) throw new Error(`${wasm}: the server answers ${response.status}`);
    return WebAssembly.compile(await response.arrayBuffer());
}

export class PhongSplatsRenderer {
    /** @param canvas a canvas without a context of another kind
     *  @param wasm where phong-splats.wasm is, its bytes, or a WebAssembly.Module
     *  @param attributes of the WebGL context */
    static async create(canvas, { wasm = new URL('phong-splats.wasm', import.meta.url), attributes = {} } = {}) {
        const gl = canvas.getContext('webgl2', { antialias: false, ...attributes });
        if (!gl) throw new PhongSplatsError('the browser has no WebGL 2 for this canvas', 0);
        const renderer = new PhongSplatsRenderer();
        await renderer.start(gl, await compile(wasm));
        return renderer;
    }

    async start(gl, module) {
        this.gl = gl;
        this.models = new Set();
        this.bitmaps = new Map(); // decoded images, by where their bytes are, while a model is made
        this.api = makeGl(gl, () => this.exports.memory, (size) => this.exports.ps_allocate(size));
        const env = {
            ...this.api.imports,
            ps_find_texture: (data, isSrgb) => (this.bitmaps.has(data) ? this.api.makeTexture(this.bitmaps.get(data), !!isSrgb) : 0),
            ps_drop_texture: (name) => this.api.dropTexture(name),
            ps_parse_number: (text) => Number(this.api.read(text)),
            ps_sin: Math.sin,
            ps_cos: Math.cos,
            ps_tan: Math.tan,
            ps_exp: Math.exp,
            emscripten_notify_memory_growth() {},
        };
        // The C library may ask for files, which there are none of: 52 is its ENOSYS.
        const system = Object.fromEntries(WebAssembly.Module.imports(module).filter((one) => one.module !== 'env').map(({ name }) => [name, () => 52]));
        const instance = await WebAssembly.instantiate(module, { env, wasi_snapshot_preview1: system });
        this.exports = instance.exports;
        this.exports._initialize?.();
        this.handle = this.exports.ps_create();
        if (!this.handle || !this.exports.ps_start(this.handle)) this.fail();
    }

    /** Throws what the runtime said last. */
    fail() {
        if (!this.handle) throw new PhongSplatsError('out of memory', 2);
        throw new PhongSplatsError(this.api.read(this.exports.ps_error(this.handle)), this.exports.ps_error_code(this.handle));
    }

    /** Runs f with memory of the module for these sizes, and frees it. */
    with(sizes, f) {
        const places = sizes.map((size) => this.exports.ps_allocate(Math.max(size, 1)));
        try {
            if (places.includes(0)) throw new PhongSplatsError('out of memory', 2);
            return f(...places);
        } finally {
            places.forEach((place) => this.exports.ps_free(place));
        }
    }

    /** Opens the bytes of a GLB, or of a glTF that holds all its data. @returns a model. */
    async open(bytes) {
        const data = new Uint8Array(bytes.buffer ?? bytes, bytes.byteOffset ?? 0, bytes.byteLength), { exports, handle } = this;
        const bounds = [], asset = this.with([data.length, 48], (place, at) => {
            this.api.view().u8.set(data, place);
            const opened = exports.ps_open(handle, place, data.length, at) || this.fail();
            bounds.push(...new Float64Array(exports.memory.buffer, at, 6));
            return opened;
        });
        let images = new Map(), isKept = false;
        try {
            images = await this.decode(asset);
            if (this.handle !== handle) throw new PhongSplatsError('the renderer was disposed', 1);
            this.bitmaps = images;
            const made = exports.ps_model_create(handle, asset) || this.fail();
            const animations = this.listAnimations(asset);
            isKept = animations.length > 0;
            const model = new Model(this, made, isKept ? asset : 0, animations, exports.ps_splat_count(made), bounds);
            this.models.add(model);
            return model;
        } finally {
            for (const bitmap of images.values()) bitmap.close();
            this.bitmaps = new Map();
            if (!isKept) exports.ps_close(asset);
        }
    }

    /** @returns the names of an asset's animations and how long they take, seconds. */
    listAnimations(asset) {
        const { exports } = this, count = exports.ps_animation_count(asset);
        return Array.from({ length: count }, (_, i) => ({ name: this.api.read(exports.ps_animation_name(asset, i)), duration: exports.ps_animation_duration(asset, i) }));
    }

    /** @returns what the browser decodes of an asset's images, by where their bytes are. */
    async decode(asset) {
        const { exports } = this, images = new Map(), options = { premultiplyAlpha: 'none', colorSpaceConversion: 'none' };
        for (let i = 0; i < exports.ps_image_count(asset); ++i) {
            const at = exports.ps_image_data(asset, i), bytes = this.api.view().u8.slice(at, at + exports.ps_image_size(asset, i));
            const blob = new Blob([bytes], { type: this.api.read(exports.ps_image_type(asset, i)) });
            const bitmap = await createImageBitmap(blob, options).catch(() => null);
            if (bitmap) images.set(at, bitmap);
        }
        return images;
    }

    /** Clears the canvas and draws. @param items a model, { model, transform, pose }, or an array of both */
    draw(items, { view, projection, shading = 'lit', lights = [cameraLight(view)], ambient = [0.12, 0.12, 0.12], background = [0, 0, 0, 1], shadowSize = 0 }) {
        const { gl, exports, handle } = this, list = [items].flat().map((item) => (item.handle === undefined ? item : { model: item }));
        const numbers = viewNumbers(gl, { view, projection, shading, lights, ambient, shadowSize });
        const transforms = list.flatMap(({ transform }) => [...transform ?? new Array(16).fill(0)]);
        if (!handle || list.some(({ model, pose }) => !model?.handle || model.renderer !== this || (pose && !pose.handle))) throw new PhongSplatsError(DISPOSED, 1);
        if (list.some(({ model, pose }) => pose && pose.model !== model)) throw new PhongSplatsError('a pose is of another model', 1);
        gl.clearColor(...background);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        this.with([8 * numbers.length, 4 * list.length, 4 * list.length, 8 * transforms.length], (at, models, poses, places) => {
            const { buffer } = exports.memory;
            new Float64Array(buffer, at, numbers.length).set(numbers);
            new Uint32Array(buffer, models, list.length).set(list.map(({ model }) => model.handle));
            new Uint32Array(buffer, poses, list.length).set(list.map(({ pose }) => pose?.handle ?? 0));
            new Float64Array(buffer, places, transforms.length).set(transforms);
            if (!exports.ps_draw(handle, at, models, poses, places, list.length)) this.fail();
        });
    }

    /** Frees the models and the renderer, once or more often. */
    dispose() {
        if (!this.handle) return;
        for (const model of [...this.models]) model.dispose();
        this.exports.ps_destroy(this.handle);
        this.handle = 0;
    }
}

/** A view as module.c reads it. */
function viewNumbers(gl, { view, projection, shading, lights, ambient, shadowSize }) {
    const numbers = new Float64Array(VIEW_NUMBERS), code = SHADINGS.indexOf(shading);
    if (view?.length !== 16 || projection?.length !== 16) throw new PhongSplatsError('view and projection are 16 numbers each', 1);
    if (code < 0) throw new PhongSplatsError(`unknown shading ${shading}`, 1);
    if (lights.length > MAX_LIGHTS) throw new PhongSplatsError(`${lights.length} lights are more than ${MAX_LIGHTS}`, 1);
    numbers.set(view, 0);
    numbers.set(projection, 16);
    // A lost context has no buffer; the runtime says that it is lost.
    numbers.set([gl.drawingBufferWidth || 1, gl.drawingBufferHeight || 1, code, shadowSize, ...ambient, lights.length], 32);
    lights.forEach(({ type = 'directional', color = [Math.PI, Math.PI, Math.PI], direction = [0, -1, 0], position = [0, 0, 0], range = 0, innerAngle = 0, outerAngle = 0, castsShadow = false }, k) => {
        if (!LIGHTS.includes(type)) throw new PhongSplatsError(`unknown light ${type}`, 1);
        numbers.set([LIGHTS.indexOf(type), ...color, ...direction, ...position, range, innerAngle, outerAngle, +castsShadow], 40 + k * LIGHT_NUMBERS);
    });
    return numbers;
}

/** The light of `phongsplat render`, from behind the camera. */
function cameraLight(view) {
    const along = [0.15, -0.65, -0.85], radiance = 0.85 * Math.PI;
    return { color: [radiance, radiance, radiance], direction: [0, 1, 2].map((i) => along.reduce((sum, x, k) => sum + view[4 * i + k] * x, 0)) };
}

// ---- cameras: matrices of 16 numbers, column by column -----------------------------------------

const minus = (a, b) => a.map((x, k) => x - b[k]);
const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));

/** @returns the view from `eye` to `target`. */
export function lookAt(eye, target, up = [0, 1, 0]) {
    const z = unit(minus(eye, target)), x = unit(cross(up, z)), y = cross(z, x);
    return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}

/** @returns a projection; `degrees` is the vertical angle of view, `aspect` width by height. */
export function perspective(degrees, aspect, near, far) {
    const zoom = 1 / Math.tan(degrees * Math.PI / 360);
    return [zoom / aspect, 0, 0, 0, 0, zoom, 0, 0, 0, 0, (near + far) / (near - far), -1, 0, 0, 2 * near * far / (near - far), 0];
}
