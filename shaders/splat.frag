/* SPDX-License-Identifier: MIT
 *
 * splat.frag - the fragments of one splat. Those outside the ellipse or a clip line are discarded;
 * the others add to the sums of spec 5.4, which layout.h lists.
 *
 * gl_program.c defines PASS, CLIP_COUNT, CLIP_TYPE, COLOR, FINISH, COLORS, MATERIALS, OCCLUSION,
 * NEAR, POWER, FILTER, COUNT and WEIGHT_FLOOR, and for the pass that shades the macros of
 * shading.glsl.
 */
#if FILTER
in vec4 v_uv;
#else
in vec2 v_uv;
#endif
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
in float v_near;
#endif
#elif PASS == PSPLAT_PASS_PARAMETERS
flat in float v_index;
#else
in vec3 v_normal;
#if FINISH
in vec3 v_color;
flat in vec3 v_surface;
flat in vec3 v_emissive;
#elif COLOR
flat in vec3 v_color;
#endif
#endif
#if CLIP_COUNT > 0
in CLIP_TYPE v_clip;
#endif

#if PASS != PSPLAT_PASS_VISIBILITY
layout(location = 0) out vec4 o_sum;
#if OCCLUSION
layout(location = 1) out vec4 o_depth;
#elif MATERIALS
layout(location = 1) out vec2 o_depth;
#else
layout(location = 1) out float o_depth;
#endif
#endif
#if COLORS
layout(location = 2) out vec4 o_color;
#endif
#if MATERIALS
layout(location = 3) out vec4 o_surface;
#endif

uniform vec2 u_kernel; /* -sharpness, exponent / 2 */
uniform vec3 u_base_color;
uniform vec3 u_emissive;
uniform vec3 u_surface; /* metallic, roughness, unlit */

void discard_outside(float r2) {
    if (r2 > 1.0) discard;
#if CLIP_COUNT == 1
    if (v_clip < (FILTER == 1 ? -0.5 : 0.0)) discard;
#elif CLIP_COUNT > 1
    if (any(lessThan(v_clip, CLIP_TYPE(FILTER == 1 ? -0.5 : 0.0)))) discard;
#endif
#if PASS == PSPLAT_PASS_VISIBILITY && NEAR
    /* Here the splat itself lies between the eye and the near plane, outside the view; only the
     * shifted point lies behind that plane. */
    if (v_near < 0.0) discard;
#endif
}

/* Returns the factor of the weight that the filter of spec 5.8 gives, 1 without the filter. */
float filter_of() {
    float factor = 1.0;
#if FILTER
    factor = v_uv.z;
#if CLIP_COUNT > 0
    CLIP_TYPE inside = clamp(v_clip + 0.5, 0.0, 1.0);
#if CLIP_COUNT == 1
    factor *= inside;
#elif CLIP_COUNT == 2
    factor *= inside.x * inside.y;
#elif CLIP_COUNT == 3
    factor *= inside.x * inside.y * inside.z;
#else
    factor *= inside.x * inside.y * inside.z * inside.w;
#endif
#endif
#endif
    return factor;
}

/* Returns psi of spec 3.7 times the filter's factor. The lower bound keeps a covered pixel covered
 * where a sharp kernel underflows. */
float weight_of(float r2) {
#if COUNT
    return 1.0;
#elif POWER
    return max(exp(u_kernel.x * pow(r2, u_kernel.y)) * filter_of(), WEIGHT_FLOOR);
#else
    return max(exp(u_kernel.x * r2) * filter_of(), WEIGHT_FLOOR);
#endif
}

void main() {
    float r2 = dot(v_uv.xy, v_uv.xy);
    discard_outside(r2);

#if PASS == PSPLAT_PASS_PARAMETERS
    o_sum = vec4(v_uv.xy, v_index, 1.0);
    o_depth = gl_FragCoord.z;
#elif PASS != PSPLAT_PASS_VISIBILITY
    float weight = weight_of(r2);
    float depth = gl_FragCoord.z;
#if FILTER
    depth += v_uv.w;
#endif
    vec3 color = u_base_color;
    vec3 emissive = u_emissive;
    vec4 surface = vec4(u_surface, 1.0);
#if FINISH
    color *= clamp(v_color, 0.0, 1.0);
    emissive *= v_emissive;
    surface *= vec4(v_surface.zy, 1.0, v_surface.x);
#elif COLOR
    color *= v_color;
#endif
#if PASS == PSPLAT_PASS_NORMALS
    o_sum = weight * vec4(v_normal, 1.0);
#else
    vec3 window = vec3(gl_FragCoord.xy, depth);
    o_sum = weight * vec4(shade(v_normal, window, color, emissive, surface), 1.0);
#endif
#if OCCLUSION
    o_depth = weight * vec4(depth, surface.zw, 0.0);
#elif MATERIALS
    o_depth = weight * vec2(depth, surface.z);
#else
    o_depth = weight * depth;
#endif
#if MATERIALS
    o_surface = weight * vec4(emissive, surface.y);
#endif
#if COLORS
    o_color = weight * vec4(color, surface.x);
#endif
#endif
}
