/* SPDX-License-Identifier: MIT
 *
 * Splats blended into the pixel: the weight of each is 1 in this view.
 */
vec3 resolve(Pixel pixel) {
#if ENCODE
    /* blue 1, green 8, yellow 16, red 32, white 64 */
    float steps = log2(max(pixel.weight, 1.0));
    vec3 color = mix(vec3(0.0, 0.0, 0.5), vec3(0.0, 0.8, 0.0), clamp(steps / 3.0, 0.0, 1.0));
    color = mix(color, vec3(1.0, 0.9, 0.0), clamp(steps - 3.0, 0.0, 1.0));
    color = mix(color, vec3(1.0, 0.0, 0.0), clamp(steps - 4.0, 0.0, 1.0));
    return mix(color, vec3(1.0), clamp(steps - 5.0, 0.0, 1.0));
#else
    return vec3(pixel.weight);
#endif
}
