/* SPDX-License-Identifier: MIT
 *
 * One triangle in the splat's plane around its ellipse. The corners are constants in (u, v), so
 * (u, v), the normal field and the clip distances, all linear in (u, v), are exact at the corners
 * and the hardware interpolates them with perspective. Vertices are pulled by gl_VertexID.
 *
 * Defined outside: PASS, CLIP_COUNT, COLOR, GAMMA, NEAR.
 */
invariant gl_Position;

#if COLOR || GAMMA
#define SPLAT_TEXELS (PSPLAT_SPLAT_TEXELS + 1)
#else
#define SPLAT_TEXELS PSPLAT_SPLAT_TEXELS
#endif

uniform highp sampler2D u_splats;
uniform highp sampler2D u_clips;
uniform mat4 u_modelview;
uniform mat4 u_projection;
uniform mat3 u_normal_matrix;
uniform vec3 u_shift;
uniform mat3 u_ray;
uniform int u_two_sided;
uniform int u_first_index;

out vec2 v_uv;
#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
out float v_near;
#endif
#elif PASS == PSPLAT_PASS_PARAMETERS
flat out float v_index;
#else
out vec3 v_normal;
#if COLOR
flat out vec3 v_color;
#endif
#endif
#if CLIP_COUNT > 0
out CLIP_TYPE v_clip;
#endif

/* Equilateral, its inscribed circle the unit circle; counter-clockwise seen from N. */
vec2 corner_uv(int corner) {
    return corner == 0 ? vec2(-1.7320508, -1.0)
                       : corner == 1 ? vec2(1.7320508, -1.0) : vec2(0.0, 2.0);
}

/* Columns are |q|^2 times U, V, N. */
mat3 axes_of(vec4 q) {
    vec3 s = q.xyz * q.xyz;
    vec3 p = q.xyz * q.yzx; /* xy, yz, zx */
    vec3 w = q.xyz * q.w;
    float d = q.w * q.w;
    return mat3(vec3(d + s.x - s.y - s.z, 2.0 * (p.x + w.z), 2.0 * (p.z - w.y)),
                vec3(2.0 * (p.x - w.z), d - s.x + s.y - s.z, 2.0 * (p.y + w.x)),
                vec3(2.0 * (p.z + w.y), 2.0 * (p.y - w.x), d - s.x - s.y + s.z));
}

/* Along the ray of a splat's centre, away from the eye; any length. */
vec3 view_ray(vec3 eye_center) {
    return u_shift.y > 0.0 ? eye_center : u_ray[2];
}

#if PASS == PSPLAT_PASS_VISIBILITY
/* 1 / max(|cos|, 1/2) of eq. (5), of the angle between the splat's normal and the view ray. */
float grazing_of(vec3 normal, vec3 eye_center) {
    vec3 ray = view_ray(eye_center);
    float cosine = abs(dot(normal, ray)) * inversesqrt(dot(normal, normal) * dot(ray, ray));
    return 1.0 / max(cosine, 0.5);
}

/* What to add to gl_Position.z so that the point lies epsilon further along its own view ray
 * (spec 5.3). With p the point and s = 1 + epsilon / |p| the shifted point is s p, and
 * z'/w' = (z_row.xyz * s p + z_row.w) / (s w); written over the old w that is
 * z - z_row.w * epsilon / (|p| + epsilon). x, y and w stay: both passes rasterise the same
 * pixels. u_shift holds the terms for a facing splat; grazing multiplies epsilon. Never less than
 * 2^-20 of w, eight steps of a 24-bit depth buffer. */
float shift_of(vec3 eye, float w, float grazing) {
    float bottom = u_shift.y * length(eye) + u_shift.z * (u_shift.y > 0.0 ? grazing : 1.0);
    return max(u_shift.x * grazing / bottom, abs(w) * 9.5367431640625e-7);
}
#endif

#if CLIP_COUNT > 0
float clip_distance(ivec2 first, int line, vec2 uv) {
    vec3 abc = texelFetch(u_clips, first + ivec2(line, 0), 0).xyz;
    return dot(abc.xy, uv) + abc.z;
}

CLIP_TYPE clip_distances(int column, int row, vec2 uv) {
    ivec2 first = ivec2(column * CLIP_COUNT, row);
#if CLIP_COUNT == 1
    return clip_distance(first, 0, uv);
#elif CLIP_COUNT == 2
    return vec2(clip_distance(first, 0, uv), clip_distance(first, 1, uv));
#elif CLIP_COUNT == 3
    return vec3(clip_distance(first, 0, uv), clip_distance(first, 1, uv),
                clip_distance(first, 2, uv));
#else
    return vec4(clip_distance(first, 0, uv), clip_distance(first, 1, uv),
                clip_distance(first, 2, uv), clip_distance(first, 3, uv));
#endif
}
#endif

#if PASS != PSPLAT_PASS_VISIBILITY && PASS != PSPLAT_PASS_PARAMETERS
/* Whether the splat clearly turns its back to the eye (spec 5.2), which gl_FrontFacing cannot
 * tell. */
bool is_behind(vec3 normal, vec3 eye_center) {
    vec3 ray = view_ray(eye_center);
    return dot(normal, ray) >= 0.5 * sqrt(dot(normal, normal) * dot(ray, ray));
}
#endif

void main() {
    int splat = gl_VertexID / 3;
    vec2 uv = corner_uv(gl_VertexID - 3 * splat);
    int row = splat / PSPLAT_ROW_SPLATS;
    int column = splat - row * PSPLAT_ROW_SPLATS;
    ivec2 texel = ivec2(column * SPLAT_TEXELS, row);
    vec4 center = texelFetch(u_splats, texel, 0);
    vec4 rotation = texelFetch(u_splats, texel + ivec2(1, 0), 0);
    mat3 axes = axes_of(rotation);

    vec3 eye_center = (u_modelview * vec4(center.xyz, 1.0)).xyz;
    vec3 offset = axes[0] * uv.x + axes[1] * (center.w * uv.y);
    vec3 eye = eye_center + mat3(u_modelview) * offset;
    gl_Position = u_projection * vec4(eye, 1.0);
    v_uv = uv;
#if CLIP_COUNT > 0
    v_clip = clip_distances(column, row, uv);
#endif

#if PASS == PSPLAT_PASS_VISIBILITY
#if NEAR
    v_near = gl_Position.z + gl_Position.w;
#endif
    float grazing = grazing_of(u_normal_matrix * axes[2], eye_center);
    gl_Position.z += shift_of(eye, gl_Position.w, grazing);
#elif PASS == PSPLAT_PASS_PARAMETERS
    v_index = float(u_first_index + splat);
#else
    vec4 field = texelFetch(u_splats, texel + ivec2(2, 0), 0);
#if COLOR || GAMMA
    vec4 extra = texelFetch(u_splats, texel + ivec2(3, 0), 0);
#endif
#if PASS == PSPLAT_PASS_PHONG
    field.xy += field.zw * uv;
#if GAMMA
    field.xy += extra.w * vec2(center.w * uv.y, uv.x);
#endif
#endif
    v_normal = u_normal_matrix * (axes * vec3(field.xy, 1.0) / dot(rotation, rotation));
    if (u_two_sided != 0 && is_behind(u_normal_matrix * axes[2], eye_center)) v_normal = -v_normal;
#if COLOR
    v_color = extra.rgb;
#endif
#endif
}
