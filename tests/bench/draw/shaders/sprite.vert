/* SPDX-License-Identifier: MIT
 *
 * BSK04 section 4.1: one vertex a splat, a square of the size that eq. 5 estimates. Back-facing
 * splats go outside the clip volume. What the ray caster needs is constant over the square.
 *
 * Defined outside: VISIBILITY, CLIP_COUNT, FILTER.
 */
layout(location = 0) in vec3 a_center;
layout(location = 1) in vec3 a_u; /* scaled by the radii */
layout(location = 2) in vec3 a_v;
layout(location = 3) in vec4 a_field; /* x, y, alpha, beta of BSK04 eq. 2 */
layout(location = 4) in vec4 a_color; /* and gamma of spec 3.5 */
layout(location = 5) in vec3 a_clip[4];

uniform mat4 u_modelview;
uniform mat4 u_projection;
uniform vec2 u_viewport;
uniform int u_two_sided;

flat out vec3 v_plane;  /* n / (c.n), BSK04 eq. 6 */
flat out vec4 v_u, v_v; /* u = v_u.xyz.q - v_u.w */
#if !VISIBILITY
flat out mat3 v_axes; /* U, V, N */
flat out vec4 v_field;
flat out vec4 v_color;
flat out vec4 v_center; /* window x and y, eye z; ratio of radii */
#endif
#if CLIP_COUNT > 0
flat out vec3 v_clip[CLIP_COUNT];
#endif

void main() {
    vec3 center = (u_modelview * vec4(a_center, 1.0)).xyz;
    vec3 u = mat3(u_modelview) * a_u;
    vec3 v = mat3(u_modelview) * a_v;
    vec3 n = cross(u, v);
    float facing = dot(center, n);
    gl_Position = u_projection * vec4(center, 1.0);
    if (u_two_sided == 0 && facing >= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);

    float radius = sqrt(max(dot(u, u), dot(v, v)));
    float size = radius * u_projection[1][1] / -center.z * u_viewport.y; /* eq. 5 */
#if !VISIBILITY && FILTER
    size = max(size, 2.0); /* BHZK05 section 5 */
#endif
    gl_PointSize = size;

    v_plane = n / facing;
    float scale = 1.0 / dot(n, n);
    vec3 along_u = cross(v, n) * scale, along_v = cross(n, u) * scale;
    v_u = vec4(along_u, dot(along_u, center));
    v_v = vec4(along_v, dot(along_v, center));
#if !VISIBILITY
    float side = u_two_sided != 0 && facing > 0.0 ? -1.0 : 1.0;
    v_axes = mat3(normalize(u), normalize(v), side * normalize(n));
    v_field = a_field;
    v_color = a_color;
    v_center = vec4((gl_Position.xy / gl_Position.w * 0.5 + 0.5) * u_viewport, center.z,
                    length(a_v) / length(a_u));
#endif
#if CLIP_COUNT > 0
    for (int i = 0; i < CLIP_COUNT; ++i) v_clip[i] = a_clip[i];
#endif
}
