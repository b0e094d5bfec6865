/* SPDX-License-Identifier: MIT
 *
 * BSK04 section 4: the pixel's ray meets the splat's plane, (u, v) decide, the depth is replaced.
 * The weighted normal and colour go to two targets (BHZK05 section 4.1); the screen-space filter is
 * that of BHZK05 section 5.
 *
 * Defined outside: VISIBILITY, CLIP_COUNT, FILTER, POWER.
 */
#define FILTER_CENTER_DEPTH 1

flat in vec3 v_plane;
flat in vec4 v_u, v_v;
#if !VISIBILITY
flat in mat3 v_axes;
flat in vec4 v_field;
flat in vec4 v_color;
flat in vec4 v_center;
layout(location = 0) out vec4 o_normal;
layout(location = 1) out vec4 o_color;
#endif
#if CLIP_COUNT > 0
flat in vec3 v_clip[CLIP_COUNT];
#endif

uniform mat4 u_projection;
uniform mat3 u_ray; /* of a pixel, z = -1 */
uniform float u_epsilon;
uniform vec3 u_base_color;
uniform vec2 u_kernel; /* -sharpness, half the exponent */

void main() {
    vec3 ray = u_ray * vec3(gl_FragCoord.xy, 1.0);
    vec3 q = ray / dot(ray, v_plane); /* eq. 6 */
    vec2 uv = vec2(dot(v_u.xyz, q) - v_u.w, dot(v_v.xyz, q) - v_v.w);
    float r2 = dot(uv, uv);
    float z = q.z;
#if !VISIBILITY && FILTER
    vec2 d = gl_FragCoord.xy - v_center.xy;
#if FILTER == FILTER_CENTER_DEPTH
    if (r2 > 1.0) z = v_center.z; /* the plane may be far from the splat there */
#endif
    r2 = min(r2, dot(d, d));
#endif
    if (r2 > 1.0) discard;
#if CLIP_COUNT > 0
    for (int i = 0; i < CLIP_COUNT; ++i)
        if (dot(v_clip[i], vec3(uv, 1.0)) < 0.0) discard;
#endif

#if VISIBILITY
    z -= u_epsilon;
#else
#if POWER
    float weight = exp(u_kernel.x * pow(r2, u_kernel.y));
#else
    float weight = exp(u_kernel.x * r2);
#endif
    vec2 field = v_field.xy + v_field.zw * uv + v_color.w * vec2(v_center.w * uv.y, uv.x);
    o_normal = weight * vec4(v_axes * vec3(field, 1.0), 1.0);
    o_color = weight * vec4(u_base_color * v_color.rgb, 1.0);
#endif
    gl_FragDepth = 0.5 - 0.5 * (u_projection[2][2] * z + u_projection[3][2]) / z;
}
