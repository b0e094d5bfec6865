/* SPDX-License-Identifier: MIT
 *
 * splat.frag - the fragments of one flat splat. Those outside the ellipse or a clip line are
 * discarded; the others add to the sums of spec 5.4.
 *
 * gl_program.c defines PASS, CLIP_COUNT, CLIP_TYPE, SEAM_COUNT, BENDS, COLOR, FINISH, NEAR, FILTER, TEXTURED,
 * MASK and NORMAL_MAP. texels.glsl, maps.glsl where splats are textured, and sums.glsl come before
 * this file.
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
#if NORMAL_MAP
flat in vec3 v_axis_u;
flat in vec3 v_axis_v;
#endif
#if CLIP_COUNT > 0
#if SEAM_COUNT > 0
/* More than any value of a line where the line is a seam, less where it cuts: the last are seams. */
#define SEAM(i) (i < CLIP_COUNT - SEAM_COUNT ? -1e30 : 1e30)
#if CLIP_COUNT == 1
#define SEAMS SEAM(0)
#elif CLIP_COUNT == 2
#define SEAMS vec2(SEAM(0), SEAM(1))
#elif CLIP_COUNT == 3
#define SEAMS vec3(SEAM(0), SEAM(1), SEAM(2))
#else
#define SEAMS vec4(SEAM(0), SEAM(1), SEAM(2), SEAM(3))
#endif
#endif
in CLIP_TYPE v_clip;
#if BENDS
in CLIP_TYPE v_across;
flat in CLIP_TYPE v_bend;
#if FILTER
flat in CLIP_TYPE v_slope0;
flat in CLIP_TYPE v_slope1;
flat in CLIP_TYPE v_slope2;
#endif
#endif

/* Returns the values of the clip lines: with the filter in pixels, as clip lines are softened. */
CLIP_TYPE clip_values() {
    CLIP_TYPE values = v_clip;
#if BENDS
    values += v_bend * v_across * v_across;
#if FILTER
    values *= inversesqrt(v_slope0 + v_across * (v_slope1 + v_across * v_slope2));
#endif
#endif
    return values;
}

/* Returns the values of the lines that cut the splat's shape; seams keep all of it. */
CLIP_TYPE edge_values() {
#if SEAM_COUNT > 0
    return max(clip_values(), SEAMS);
#else
    return clip_values();
#endif
}

/* Returns the product of the factors that lines of these values have. */
float factor_of(CLIP_TYPE values) {
    CLIP_TYPE inside = clamp(values + 0.5, 0.0, 1.0);
#if CLIP_COUNT == 1
    return inside;
#elif CLIP_COUNT == 2
    return inside.x * inside.y;
#elif CLIP_COUNT == 3
    return inside.x * inside.y * inside.z;
#else
    return inside.x * inside.y * inside.z * inside.w;
#endif
}
#endif

void discard_outside(float r2) {
    if (r2 > 1.0) discard;
#if CLIP_COUNT == 1
    if (edge_values() < (FILTER == 1 ? -0.5 : 0.0)) discard;
#elif CLIP_COUNT > 1
    if (any(lessThan(edge_values(), CLIP_TYPE(FILTER == 1 ? -0.5 : 0.0)))) discard;
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
    factor *= factor_of(edge_values());
#endif
#endif
    return factor;
}

#if SEAM_COUNT > 0
/* Returns the factor of what the material adds: 1 inside all seams, next to nothing beyond. */
float seam_of() {
    CLIP_TYPE values = max(clip_values(), -SEAMS);
#if !FILTER
    values = step(0.0, values) - 0.5; /* seams are hard */
#endif
    return max(factor_of(values), BEYOND_SEAMS);
}
#endif

#if TEXTURED
/* Returns the derivatives of (u, v) by window x and y. It has to be called before a discard, after
 * which neighbours of a pixel have none. 1 / w and (u, v) / w are linear over the window, so that
 * their differences between pixels are their derivatives. */
mat2 reach_of() {
    float inverse_w = gl_FragCoord.w;
    vec2 uv = v_uv.xy, over_w = uv * inverse_w;
    return mat2(dFdx(over_w) - uv * dFdx(inverse_w), dFdy(over_w) - uv * dFdy(inverse_w)) /
           inverse_w;
}
#endif

void main() {
    float r2 = dot(v_uv.xy, v_uv.xy);
#if TEXTURED
    mat2 reach = reach_of();
#endif
    discard_outside(r2);
#if MASK
    if (is_masked(v_uv.xy, reach)) discard;
#endif

#if PASS == PSPLAT_PASS_PARAMETERS
    write_parameters(v_uv.xy, v_index, gl_FragCoord.z);
#elif PASS != PSPLAT_PASS_VISIBILITY
    float depth = gl_FragCoord.z;
#if FILTER
    depth += v_uv.w;
#endif
    vec3 color = vec3(1.0), surface = vec3(1.0), emissive = vec3(1.0);
#if FINISH
    color = clamp(v_color, 0.0, 1.0);
    surface = v_surface;
    emissive = v_emissive;
#elif COLOR
    color = v_color;
#endif
    vec3 normal = v_normal;
#if TEXTURED
    Place place = place_of_colors(v_uv.xy, reach);
    apply_maps(place, color, surface, emissive);
#endif
#if NORMAL_MAP
    normal = turn_normal(place, normal, v_axis_u, v_axis_v);
#endif
    float weight = weight_of(r2, filter_of());
#if SEAM_COUNT > 0
    weight = beyond_seam(seam_of(), weight, normal);
#endif
    write_sums(weight, depth, normal, color, surface, emissive);
#endif
}
