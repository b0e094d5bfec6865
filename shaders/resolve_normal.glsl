/* SPDX-License-Identifier: MIT
 *
 * resolve_normal.glsl - debug shading: the normal in eye space, mapped from -1 ... 1 to 0 ... 1.
 */
vec3 resolve(Pixel pixel) {
    return 0.5 + 0.5 * pixel.normal * inversesqrt(max(dot(pixel.normal, pixel.normal), 1e-30));
}
