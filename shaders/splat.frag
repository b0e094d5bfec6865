/* SPDX-License-Identifier: MIT
 *
 * Fragments of one splat: outside the ellipse or a clip line they are dropped, the others add to
 * the sums of spec 5.4 (see layout.h for the targets).
 *
 * Defined outside: PASS, CLIP_COUNT, COLOR, MATERIALS, NEAR, POWER, WEIGHT_FLOOR.
 */
in vec2 v_uv;
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
in float v_near;
#endif
#elif PASS == PSPLAT_PASS_PARAMETERS
flat in float v_index;
#else
in vec3 v_normal;
#if COLOR
flat in vec3 v_color;
#endif
#endif
#if CLIP_COUNT > 0
in CLIP_TYPE v_clip;
#endif

#if PASS != PSPLAT_PASS_VISIBILITY
layout(location = 0) out vec4 o_target0;
layout(location = 1) out vec4 o_target1;
#endif
#if MATERIALS
layout(location = 2) out vec4 o_target2;
layout(location = 3) out vec4 o_target3;
#endif

uniform vec2 u_kernel;
uniform vec3 u_base_color;
uniform vec3 u_emissive;
uniform vec3 u_surface; /* metallic, roughness, unlit */
uniform mat3 u_ray;

void discard_outside(float r2) {
    if (r2 > 1.0) discard;
#if CLIP_COUNT == 1
    if (v_clip < 0.0) discard;
#elif CLIP_COUNT > 1
    if (any(lessThan(v_clip, CLIP_TYPE(0.0)))) discard;
#endif
#if PASS == PSPLAT_PASS_VISIBILITY && NEAR
    /* Only the shifted point lies beyond the near plane: there is nothing to see here. */
    if (v_near < 0.0) discard;
#endif
}

/* psi of spec 3.7; u_kernel holds -sharpness and half the exponent. The floor keeps a covered pixel
 * covered where a sharp kernel underflows. */
float weight_of(float r2) {
#if PASS == PSPLAT_PASS_FLAT
    return 1.0;
#elif POWER
    return max(exp(u_kernel.x * pow(r2, u_kernel.y)), WEIGHT_FLOOR);
#else
    return max(exp(u_kernel.x * r2), WEIGHT_FLOOR);
#endif
}

void main() {
    float r2 = dot(v_uv, v_uv);
    discard_outside(r2);

#if PASS == PSPLAT_PASS_PARAMETERS
    o_target0 = vec4(v_uv, v_index, 1.0);
    o_target1 = vec4(0.0, 0.0, 0.0, gl_FragCoord.z);
#elif PASS != PSPLAT_PASS_VISIBILITY
    vec3 color = u_base_color;
#if COLOR
    color *= v_color;
#endif
    float weight = weight_of(r2);
#if PASS == PSPLAT_PASS_PHONG
    o_target0 = weight * vec4(v_normal, 1.0);
#else
    vec3 view = -normalize(u_ray * vec3(gl_FragCoord.xy, 1.0));
    o_target0 = weight * vec4(shade(v_normal, view, color, u_emissive, u_surface), 1.0);
#endif
    o_target1 = weight * vec4(color, gl_FragCoord.z);
#if MATERIALS
    o_target2 = weight * vec4(u_emissive, u_surface.x);
    o_target3 = weight * vec4(u_surface.yz, 0.0, 0.0);
#endif
#endif
}
