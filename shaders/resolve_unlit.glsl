/* SPDX-License-Identifier: MIT
 *
 * resolve_unlit.glsl - the base colour (albedo) without light.
 */
vec3 resolve(Pixel pixel) {
    return encode(pixel.color);
}
