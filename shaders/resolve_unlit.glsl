/* SPDX-License-Identifier: MIT
 *
 * The base colour alone.
 */
vec3 resolve(Pixel pixel) {
    return encode(pixel.color);
}
