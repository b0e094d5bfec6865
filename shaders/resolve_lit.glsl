/* SPDX-License-Identifier: MIT
 *
 * The material under the view's lights.
 */
vec3 resolve(Pixel pixel) {
    return encode(shade(pixel.normal, pixel.window, pixel.color, pixel.emissive, pixel.surface));
}
