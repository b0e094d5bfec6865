// SPDX-License-Identifier: MIT
//
// targets.js - the float render targets of the splat passes (layout.h): one set for each renderer
// and number of attachments, which all splats share, because those of one set of passes are resolved
// before the next one is drawn.
import { DepthTexture, FloatType, HalfFloatType, NearestFilter, RedFormat, RGFormat, UnsignedByteType, WebGLRenderTarget } from 'three';

/** After so many uses that needed less than a quarter of its pixels a target shrinks. */
const PATIENCE = 120;

const pools = new WeakMap();

/** @returns whether this renderer blends halves instead of floats, which WebGL 2 may lack. */
export function usesHalves(renderer) {
    const { extensions } = renderer;
    if (extensions.has('EXT_color_buffer_float') && extensions.has('EXT_float_blend')) return false;
    if (extensions.has('EXT_color_buffer_float') || extensions.has('EXT_color_buffer_half_float')) return true;
    throw new Error('PhongSplats: this WebGL renders neither to floats nor to half floats');
}

/** Makes a target, and one with the same depths for the numbers of objects. */
function makeTargets(count, type, width, height) {
    const options = { minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false, depthTexture: new DepthTexture(width, height, FloatType) };
    const owners = new WebGLRenderTarget(width, height, { ...options, type: UnsignedByteType, format: RGFormat });
    const target = new WebGLRenderTarget(width, height, { ...options, count, type });
    if (count === 2) target.textures[1].format = RedFormat;
    target.scissorTest = owners.scissorTest = true;
    return { target, owners, idle: 0 };
}

/** Frees a target and its owners on the GPU. three frees the depths that they share with the target to
 *  which it counts them, and only if that was drawn to. */
function release({ target, owners }) {
    target.depthTexture.dispose();
    target.dispose();
    owners?.dispose();
}

/** Resizes a target and its owners. */
function resize(entry, width, height) {
    release(entry);
    entry.target.setSize(width, height);
    entry.owners.setSize(width, height);
}

/** @returns a target and its owners with at least so many pixels; the caller sets viewport and
 *  scissor. */
export function findTarget(renderer, count, isHalf, width, height) {
    if (!pools.has(renderer)) pools.set(renderer, new Map());
    const pool = pools.get(renderer), key = `${count} ${isHalf}`;
    if (!pool.has(key)) pool.set(key, makeTargets(count, isHalf ? HalfFloatType : FloatType, width, height));
    const entry = pool.get(key), { target } = entry;
    entry.idle = 4 * width * height < target.width * target.height ? entry.idle + 1 : 0;
    if (entry.idle > PATIENCE) {
        resize(entry, width, height);
        entry.idle = 0;
    } else if (width > target.width || height > target.height) {
        resize(entry, Math.max(width, target.width), Math.max(height, target.height));
    }
    return entry;
}

/** @returns a target of depths alone with exactly so many pixels. */
export function findDepths(renderer, width, height) {
    if (!pools.has(renderer)) pools.set(renderer, new Map());
    const pool = pools.get(renderer), options = { minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false, type: UnsignedByteType, format: RedFormat };
    if (!pool.has('depths')) pool.set('depths', { target: new WebGLRenderTarget(width, height, { ...options, depthTexture: new DepthTexture(width, height, FloatType) }) });
    const { target } = pool.get('depths');
    target.setSize(width, height);
    target.scissorTest = true;
    return target;
}

/** Frees the render targets that splats have used with a renderer. */
export function disposeTargets(renderer) {
    for (const entry of pools.get(renderer)?.values() ?? []) release(entry);
    pools.delete(renderer);
}
