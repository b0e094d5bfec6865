/* SPDX-License-Identifier: MIT
 *
 * The material and lights of the renderer's resolve pass, or the interpolated normal.
 *
 * Defined outside: NORMALS.
 */
in vec3 v_ray;
in vec3 v_normal;
in vec3 v_color;

uniform vec3 u_base_color;
uniform int u_two_sided;

layout(location = 0) out vec4 o_color;

void main() {
#if NORMALS
    o_color = vec4(v_normal, 1.0);
#else
    vec3 normal = u_two_sided != 0 && !gl_FrontFacing ? -v_normal : v_normal;
    o_color = vec4(encode(light_surface(normal, -normalize(v_ray), u_base_color * v_color)), 1.0);
#endif
}
