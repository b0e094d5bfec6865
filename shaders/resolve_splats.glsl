/* SPDX-License-Identifier: MIT
 *
 * resolve_splats.glsl - debug shading: the nearest splat's index as a colour. The hues of
 * consecutive indices are a golden ratio apart, so they are easy to tell from each other.
 */
vec3 resolve(Pixel pixel) {
    float hue = fract(pixel.normal.z * 0.61803399);
    vec3 color = clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(1.0), color, 0.6) * (1.0 - 0.35 * dot(pixel.normal.xy, pixel.normal.xy));
}
