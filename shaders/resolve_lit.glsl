/* SPDX-License-Identifier: MIT
 *
 * resolve_lit.glsl - the material under the view's lights.
 */
vec3 resolve(Pixel pixel) {
    return encode(shade(pixel.normal, pixel.window, pixel.color, pixel.emissive, pixel.surface));
}
