/* SPDX-License-Identifier: MIT
 *
 * The same material and lights as the resolve passes.
 */
in vec3 v_eye;
in vec3 v_normal;
in vec3 v_color;

uniform vec3 u_base_color;
uniform int u_two_sided;

layout(location = 0) out vec4 o_color;

void main() {
    vec3 view = -normalize(v_eye);
    vec3 normal = u_two_sided != 0 && !gl_FrontFacing ? -v_normal : v_normal;
    o_color = vec4(encode(light_surface(normal, view, u_base_color * v_color)), 1.0);
}
