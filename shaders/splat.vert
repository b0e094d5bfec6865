/* SPDX-License-Identifier: MIT
 *
 * splat.vert - draws a splat as one triangle in its plane around its ellipse. The corners are
 * constants in (u, v). The normal field and the clip distances are linear in (u, v), so they are
 * exact at the corners, and the hardware interpolates them with perspective. Vertices are pulled
 * from textures by gl_VertexID (layout.h).
 *
 * gl_program.c defines PASS, CLIP_COUNT, CLIP_TYPE, WIDE, COLOR, FINISH, FIELD, GAMMA, NEAR,
 * TWO_SIDED and FILTER.
 */
invariant gl_Position;

uniform highp sampler2D u_splats;
uniform highp sampler2D u_clips;
#if FINISH
uniform highp sampler2D u_finishes;
uniform int u_finish; /* PSPLAT_FINISH_ bits */
#endif
uniform mat4 u_modelview;
uniform mat4 u_projection;
uniform mat4 u_clip_matrix; /* their product, used by the filter, which need not be as exact */
uniform mat3 u_normal_matrix;
uniform vec3 u_shift; /* psplat_placement.shift, see shift_of() */
uniform vec3 u_view_direction; /* of orthographic views, away from the eye; 0 0 0 in perspective */
uniform vec3 u_half_viewport; /* half the width and height in pixels, half the depth range */
uniform int u_first_index; /* the batch's first splat, counted over all batches */

#if FILTER
out vec4 v_uv; /* u, v; ratio of areas; window depth that was subtracted (spec 5.8) */
#else
out vec2 v_uv;
#endif
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
out float v_near;
#endif
#elif PASS == PSPLAT_PASS_PARAMETERS
flat out float v_index;
#else
out vec3 v_normal;
#if FINISH
out vec3 v_color; /* not clamped */
flat out vec3 v_surface;
flat out vec3 v_emissive;
#elif COLOR
flat out vec3 v_color;
#endif
#endif
#if CLIP_COUNT > 0
out CLIP_TYPE v_clip;
#endif

/* Returns a corner of an equilateral triangle, counter-clockwise seen from N. Its inscribed circle
 * is 1/256 larger than the unit circle. Rasterisers round corners to that part of a pixel, and
 * without it splats of about a pixel would lose fragments at the three points where the circle
 * touches the triangle. */
vec2 corner_uv(int corner) {
    return corner == 0 ? vec2(-1.7388, -1.0039)
                       : corner == 1 ? vec2(1.7388, -1.0039) : vec2(0.0, 2.0078);
}

/* Returns the rotation matrix of a quaternion times |q|^2: its columns are |q|^2 U, V, N. */
mat3 axes_of(vec4 q) {
    vec3 s = q.xyz * q.xyz;
    vec3 p = q.xyz * q.yzx; /* xy, yz, zx */
    vec3 w = q.xyz * q.w;
    float d = q.w * q.w;
    return mat3(vec3(d + s.x - s.y - s.z, 2.0 * (p.x + w.z), 2.0 * (p.z - w.y)),
                vec3(2.0 * (p.x - w.z), d - s.x + s.y - s.z, 2.0 * (p.y + w.x)),
                vec3(2.0 * (p.z + w.y), 2.0 * (p.y - w.x), d - s.x - s.y + s.z));
}

#if PASS == PSPLAT_PASS_VISIBILITY || TWO_SIDED
/* Returns the view ray of a point, away from the eye and of any length. */
vec3 view_ray(vec3 eye) {
    return u_shift.y > 0.0 ? eye : u_view_direction;
}
#endif

#if PASS == PSPLAT_PASS_VISIBILITY
/* Returns 1 / max(|cos|, 1/2) of eq. (5) for the angle between the splat's normal and the view ray.
 */
float grazing_of(vec3 normal, vec3 ray) {
    float projected = dot(normal, ray), both = dot(normal, normal) * dot(ray, ray);
    return sqrt(both / max(projected * projected, 0.25 * both));
}

/* Returns what to add to gl_Position.z so that the point lies epsilon further along its own view
 * ray (spec 5.3). With p the point and s = 1 + epsilon / |p| the shifted point is s p, and
 * z'/w' = (z_row.xyz * s p + z_row.w) / (s w). Over the old w that is
 * z - z_row.w * epsilon / (|p| + epsilon). x, y and w stay, so both passes rasterise the same
 * pixels.
 *
 * Epsilon is at least 2^-20 of the distance times grazing (spec 5.3). The shift is at least 2^-20
 * of w, eight steps of a 24-bit depth buffer; but this least shift does not move a point beyond the
 * far plane, because then nothing would tell that the pixel is covered. Between the corners of a
 * splat of radius R at distance D the shift has an error of up to (2 R / D)^2 of epsilon. */
float shift_of(vec3 eye, vec2 zw, float grazing) {
    float distance = length(eye);
    float epsilon = max(u_shift.z, 9.5367431640625e-7 * distance) * grazing;
    float bottom = u_shift.y > 0.0 ? distance + epsilon : 1.0;
    float room = zw.y * (1.0 - 1.1920929e-7) - zw.x;
    float least = abs(zw.y) * 9.5367431640625e-7;
    if (room > 0.0) least = min(least, room);
    return max(u_shift.x * epsilon / bottom, least);
}
#endif

#if FILTER
/* The screen-space filter of spec 5.8. A 2 x 2 matrix is a rotation times q plus a reflection times
 * r. Its singular values are q + r and q - r (negative where it is seen from behind). A matrix with
 * other singular values and the same singular vectors has another q and r alone, so the vectors are
 * not needed. */
struct Footprint {
    mat2 widened; /* J' */
    mat2 change;  /* J' - J */
    float ratio;  /* det J / det J' */
    float nearer; /* in normalised device coordinates */
    float lines;  /* 1 / t of spec 5.8; 1e6 where clip lines are hard */
    bool is_known; /* false: the filter does not apply (spec 5.8) and the rest is not used */
};

Footprint footprint_of(vec4 center, vec4 along_u, vec4 along_v) {
    /* j is J times w, by the quotient rule at the centre. */
    vec3 ndc = center.xyz / center.w;
    vec3 by_u = along_u.xyz - ndc * along_u.w, by_v = along_v.xyz - ndc * along_v.w;
    mat2 j = mat2(u_half_viewport.xy * by_u.xy, u_half_viewport.xy * by_v.xy);
    vec2 turn = 0.5 * vec2(j[0].x + j[1].y, j[0].y - j[1].x);
    vec2 flip = 0.5 * vec2(j[0].x - j[1].y, j[0].y + j[1].x);
    float q = length(turn), r = length(flip), w = abs(center.w);
    float slope = length(vec2(by_u.z, by_v.z)) / w;

    Footprint result = Footprint(j / w, mat2(0.0), 1.0, 0.0, 1e6, true);
    result.is_known = ndc.z - 2.0 * slope > -1.0 && ndc.z < 1.0 &&
                      abs(along_u.w) + abs(along_v.w) < 0.25 * center.w;
    if (abs(q - r) < w) {
        float large = max(q + r, w);
        float small = q < r ? -w : w;
        turn *= 0.5 * (large + small) / max(q, 1e-30);
        flip *= 0.5 * (large - small) / max(r, 1e-30);
        result.widened =
            mat2(turn.x + flip.x, turn.y + flip.y, flip.y - turn.y, turn.x - flip.x) / w;
        result.change = result.widened - j / w;
        result.ratio = (q + r) * abs(q - r) / (large * w);
        result.lines = 1.0 / clamp(w / max(abs(q - r), 1e-30) - 1.0, 1e-6, 1.0);
        /* The splat is compared as if it were nearer by what its plane rises within a pixel, so
         * that slanted surfaces do not lose the near half of the kernel. It is limited by a slant
         * of 87 degrees for a splat of one pixel, and by the near plane. */
        result.nearer = min(1.1 * (w / max(abs(q - r), 0.05 * w) - 1.0) * slope,
                            ndc.z + 1.0 - 2.0 * slope);
    }
    return result;
}
#endif

#if CLIP_COUNT > 0
/* Returns a clip line's signed distance: in (u, v), or with the filter in pixels times the factor
 * by which widened is scaled. */
float clip_distance(ivec2 first, int line, vec2 uv, mat2 widened) {
    vec3 abc = texelFetch(u_clips, first + ivec2(line, 0), 0).xyz;
    float value = dot(abc.xy, uv) + abc.z;
#if FILTER
    /* |J'^-T (a, b)| is computed by cofactors. */
    vec2 turned = abc.x * vec2(widened[1].y, -widened[1].x) +
                  abc.y * vec2(-widened[0].y, widened[0].x);
    value *= abs(determinant(widened)) * inversesqrt(dot(turned, turned));
#endif
    return value;
}

CLIP_TYPE clip_distances(int column, int row, vec2 uv, mat2 widened) {
    ivec2 first = ivec2(column * CLIP_COUNT, row);
#if CLIP_COUNT == 1
    return clip_distance(first, 0, uv, widened);
#elif CLIP_COUNT == 2
    return vec2(clip_distance(first, 0, uv, widened), clip_distance(first, 1, uv, widened));
#elif CLIP_COUNT == 3
    return vec3(clip_distance(first, 0, uv, widened), clip_distance(first, 1, uv, widened),
                clip_distance(first, 2, uv, widened));
#else
    return vec4(clip_distance(first, 0, uv, widened), clip_distance(first, 1, uv, widened),
                clip_distance(first, 2, uv, widened), clip_distance(first, 3, uv, widened));
#endif
}
#endif

#if PASS != PSPLAT_PASS_VISIBILITY && PASS != PSPLAT_PASS_PARAMETERS
/* Returns the normal field at uv (spec 3.5) in eye space. */
vec3 normal_of(ivec2 texel, mat3 axes, float length2, float ratio, vec2 uv) {
    vec4 field = texelFetch(u_splats, texel + ivec2(2, 0), 0);
#if FIELD
    field.xy += field.zw * uv;
#if GAMMA
    field.xy += texelFetch(u_splats, texel + ivec2(3, 0), 0).w * vec2(ratio * uv.y, uv.x);
#endif
#endif
    return u_normal_matrix * (axes * vec3(field.xy, 1.0) / length2);
}
#endif

#if FINISH
/* Sets the outputs of the finish (spec 3.10). The factors that all splats share are applied in
 * splat.frag. Eq. (4a) is linear in (u, v), so the rasteriser interpolates it exactly. */
void find_finish(int column, int row, vec2 uv) {
    int surface = u_finish & PSPLAT_FINISH_SURFACE;
    int emissive = (u_finish & PSPLAT_FINISH_EMISSIVE) / PSPLAT_FINISH_EMISSIVE;
    int gradient = (u_finish & PSPLAT_FINISH_GRADIENT) / PSPLAT_FINISH_GRADIENT;
    ivec2 texel = ivec2(column * (surface + emissive + 2 * gradient), row);
    v_surface = v_emissive = vec3(1.0);
    if (surface > 0) v_surface = texelFetch(u_finishes, texel, 0).rgb;
    texel.x += surface;
    if (emissive > 0) v_emissive = texelFetch(u_finishes, texel, 0).rgb;
#if FIELD
    texel.x += emissive;
    if (gradient > 0)
        v_color += uv.x * texelFetch(u_finishes, texel, 0).rgb +
                   uv.y * texelFetch(u_finishes, texel + ivec2(1, 0), 0).rgb;
#endif
}
#endif

#if TWO_SIDED
/* Returns whether the splat clearly turns its back to the eye (cos <= -1/2 of spec 5.2), which
 * gl_FrontFacing does not say. */
bool is_behind(vec3 normal, vec3 eye_center) {
    vec3 ray = view_ray(eye_center);
    return dot(normal, ray) >= 0.5 * sqrt(dot(normal, normal) * dot(ray, ray));
}
#endif

void main() {
    int splat = gl_VertexID / 3;
    vec2 uv = corner_uv(gl_VertexID - 3 * splat);
    int row = splat >> PSPLAT_ROW_BITS;
    int column = splat & (PSPLAT_ROW_SPLATS - 1);
    ivec2 texel = ivec2(column * (PSPLAT_SPLAT_TEXELS + WIDE), row);
    vec4 center = texelFetch(u_splats, texel, 0);
    vec4 rotation = texelFetch(u_splats, texel + ivec2(1, 0), 0);
    mat3 axes = axes_of(rotation);

    /* The position goes through eye space, so that z and w of a point, and with them its depth,
     * come from one rounded number. */
    vec3 eye_center = (u_modelview * vec4(center.xyz, 1.0)).xyz;
    vec3 offset = axes[0] * uv.x + axes[1] * (center.w * uv.y);
    vec3 eye = eye_center + mat3(u_modelview) * offset;
    gl_Position = u_projection * vec4(eye, 1.0);

    mat2 widened = mat2(1.0);
#if FILTER
    vec4 clip_center = u_clip_matrix * vec4(center.xyz, 1.0);
    vec4 along_u = u_clip_matrix * vec4(axes[0], 0.0);
    vec4 along_v = u_clip_matrix * vec4(axes[1] * center.w, 0.0);
    Footprint footprint = footprint_of(clip_center, along_u, along_v);
    v_uv = vec4(uv, 1.0, 0.0);
    widened *= 1e6; /* clip lines are hard, as with Footprint.lines */
    if (footprint.is_known) {
        widened = footprint.lines * footprint.widened;
        gl_Position.xy += clip_center.w / u_half_viewport.xy * (footprint.change * uv);
        gl_Position.z -= footprint.nearer * gl_Position.w;
        v_uv.zw = vec2(footprint.ratio, footprint.nearer * u_half_viewport.z);
    }
#else
    v_uv = uv;
#endif
#if CLIP_COUNT > 0
    v_clip = clip_distances(column, row, uv, widened);
#endif

    /* The length is about 1 whatever the unit of the scene is, so that squares stay in the range of
     * float. */
    vec3 normal = u_normal_matrix * (axes[2] / dot(rotation, rotation));
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
    v_near = gl_Position.z + gl_Position.w;
#endif
    float grazing = grazing_of(normal, view_ray(eye_center));
    gl_Position.z += shift_of(eye, gl_Position.zw, grazing);
#elif PASS == PSPLAT_PASS_PARAMETERS
    v_index = float(u_first_index + splat);
#else
    v_normal = normal_of(texel, axes, dot(rotation, rotation), center.w, uv);
#if TWO_SIDED
    if (is_behind(normal, eye_center)) v_normal = -v_normal;
#endif
#if FINISH
    v_color = vec3(1.0);
    if ((u_finish & PSPLAT_FINISH_COLOR) > 0)
        v_color = texelFetch(u_splats, texel + ivec2(3, 0), 0).rgb;
    find_finish(column, row, uv);
#elif COLOR
    v_color = texelFetch(u_splats, texel + ivec2(3, 0), 0).rgb;
#endif
#endif
}
