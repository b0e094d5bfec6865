// SPDX-License-Identifier: MIT
//
// targets.js - the float render targets of the splat passes (layout.h): one set for each renderer
// and number of attachments, which all splats share, because each object is resolved before the
// next one is drawn.
import { DepthTexture, FloatType, HalfFloatType, NearestFilter, RedFormat, WebGLRenderTarget } from 'three';

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

function makeTarget(count, type, width, height) {
    const target = new WebGLRenderTarget(width, height, {
        count, type, minFilter: NearestFilter, magFilter: NearestFilter, generateMipmaps: false,
        depthTexture: new DepthTexture(width, height, FloatType),
    });
    if (count === 2) target.textures[1].format = RedFormat;
    target.scissorTest = true;
    return target;
}

/** @returns a target with at least so many pixels; the caller sets viewport and scissor. */
export function findTarget(renderer, count, isHalf, width, height) {
    if (!pools.has(renderer)) pools.set(renderer, new Map());
    const pool = pools.get(renderer), key = `${count} ${isHalf}`;
    let entry = pool.get(key);
    if (!entry) {
        entry = { target: makeTarget(count, isHalf ? HalfFloatType : FloatType, width, height), idle: 0 };
        pool.set(key, entry);
    }
    const { target } = entry;
    entry.idle = 4 * width * height < target.width * target.height ? entry.idle + 1 : 0;
    if (entry.idle > PATIENCE) {
        target.setSize(width, height);
        entry.idle = 0;
    } else if (width > target.width || height > target.height) {
        target.setSize(Math.max(width, target.width), Math.max(height, target.height));
    }
    return target;
}

/** Frees the render targets that splats have used with a renderer. */
export function disposeTargets(renderer) {
    for (const { target } of pools.get(renderer)?.values() ?? []) target.dispose();
    pools.delete(renderer);
}
