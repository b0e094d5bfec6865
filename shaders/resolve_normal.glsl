/* SPDX-License-Identifier: MIT
 *
 * The normal in eye space, from -1 ... 1 to 0 ... 1.
 */
vec3 resolve(Pixel pixel) {
    return 0.5 + 0.5 * pixel.normal * inversesqrt(max(dot(pixel.normal, pixel.normal), 1e-30));
}
