/* SPDX-License-Identifier: MIT
 *
 * Triangles with normals, for lighting once per pixel. Eye space.
 */
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec3 a_color;

uniform mat4 u_clip; /* composed in double, as the renderer's is */
uniform mat4 u_modelview;
uniform int u_parallel; /* orthographic view */

out vec3 v_ray; /* from the eye */
out vec3 v_normal;
out vec3 v_color;

void main() {
    gl_Position = u_clip * vec4(a_position, 1.0);
    v_ray = u_parallel != 0 ? vec3(0.0, 0.0, -1.0) : (u_modelview * vec4(a_position, 1.0)).xyz;
    v_normal = mat3(u_modelview) * a_normal;
    v_color = a_color;
}
