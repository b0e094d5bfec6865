/* SPDX-License-Identifier: MIT
 *
 * sums.glsl - what a fragment of a splat writes: its part of the sums of spec 5.4, which layout.h
 * lists.
 *
 * gl_program.c defines PASS, SEAM_COUNT, NORMAL_MAP, COLORS, MATERIALS, EMISSIVE (where it is not defined, it is as
 * MATERIALS), OCCLUSION, POWER, COUNT, FADE and WEIGHT_FLOOR, and for the pass that shades the macros of
 * shading.glsl, which then comes before this file.
 */
#ifndef EMISSIVE
#define EMISSIVE MATERIALS
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
#if EMISSIVE
layout(location = 3) out vec4 o_surface;
#endif

uniform vec2 u_kernel; /* -sharpness, exponent / 2 */
uniform vec3 u_base_color;
uniform vec3 u_emissive;
uniform vec3 u_surface; /* metallic, roughness, unlit */

#if FADE
flat in float v_fade;
#endif

/* Returns psi of spec 3.7 times a factor, the filter's, and that of the item's fade. The lower bound
 * keeps a covered pixel covered where a sharp kernel underflows. */
float weight_of(float r2, float factor) {
#if FADE
    factor *= v_fade;
#endif
#if COUNT
    return 1.0;
#elif POWER
    return max(exp(u_kernel.x * pow(r2, u_kernel.y)) * factor, WEIGHT_FLOOR);
#else
    return max(exp(u_kernel.x * r2) * factor, WEIGHT_FLOOR);
#endif
}

#if SEAM_COUNT > 0
/* The part of a weight that is left to the material beyond a seam (spec 3.6): enough to fill a gap
 * between splats of the right side, and beside them at most a step of 8 bits. */
const float BEYOND_SEAMS = 0.00390625;

/* Returns the weight of a fragment whose material has the factor seam. The normal is made longer by
 * as much, so that it has the whole weight in its sum, of which only the direction counts; but not
 * where a texture of the material has turned it or light has been computed from it. */
float beyond_seam(float seam, float weight, inout vec3 normal) {
#if PASS == PSPLAT_PASS_NORMALS && !NORMAL_MAP
    normal /= seam;
#endif
    return weight * seam;
}
#endif

#if PASS == PSPLAT_PASS_PARAMETERS
void write_parameters(vec2 uv, float index, float depth) {
    o_sum = vec4(uv, index, 1.0);
    o_depth = depth;
}
#elif PASS != PSPLAT_PASS_VISIBILITY
/* Adds a fragment of this window depth. The last three are what varies over the batch: colour,
 * occlusion with roughness and metallic, and emission; 1 each where they do not. */
void write_sums(float weight, float depth, vec3 normal, vec3 varied_color, vec3 varied_surface,
                vec3 varied_emissive) {
    vec3 color = u_base_color * varied_color;
    vec3 emissive = u_emissive * varied_emissive;
    vec4 surface = vec4(u_surface, 1.0) * vec4(varied_surface.zy, 1.0, varied_surface.x);
#if PASS == PSPLAT_PASS_NORMALS
    o_sum = weight * vec4(normal, 1.0);
#else
    vec3 window = vec3(gl_FragCoord.xy, depth);
    o_sum = weight * vec4(shade(normal, window, color, emissive, surface), 1.0);
#endif
#if EMISSIVE
    float second = surface.z;
#else
    float second = surface.y;
#endif
#if OCCLUSION
    o_depth = weight * vec4(depth, second, surface.w, 0.0);
#elif MATERIALS
    o_depth = weight * vec2(depth, second);
#else
    o_depth = weight * depth;
#endif
#if EMISSIVE
    o_surface = weight * vec4(emissive, surface.y);
#endif
#if COLORS
    o_color = weight * vec4(color, surface.x);
#endif
}
#endif
