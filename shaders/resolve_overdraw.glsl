/* SPDX-License-Identifier: MIT
 *
 * resolve_overdraw.glsl - debug shading: the number of splats that are blended into the pixel,
 * which is the pixel's weight, because the weight of each splat is 1 in this shading.
 */
vec3 resolve(Pixel pixel) {
#if ENCODE
    /* 1 is blue, 8 green, 16 yellow, 32 red and 64 white. */
    float steps = log2(max(pixel.weight, 1.0));
    vec3 color = mix(vec3(0.0, 0.0, 0.5), vec3(0.0, 0.8, 0.0), clamp(steps / 3.0, 0.0, 1.0));
    color = mix(color, vec3(1.0, 0.9, 0.0), clamp(steps - 3.0, 0.0, 1.0));
    color = mix(color, vec3(1.0, 0.0, 0.0), clamp(steps - 4.0, 0.0, 1.0));
    return mix(color, vec3(1.0), clamp(steps - 5.0, 0.0, 1.0));
#else
    return vec3(pixel.weight);
#endif
}
