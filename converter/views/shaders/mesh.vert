/* SPDX-License-Identifier: MIT
 *
 * mesh.vert - the vertex shader of the mesh renderer: positions and normals in eye space, for lighting
 * per pixel.
 */
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec3 a_color;
layout(location = 3) in vec4 a_texcoords; /* two sets */

uniform mat4 u_clip; /* composed in double, like that of the splat renderer */
uniform mat4 u_modelview;
uniform int u_parallel; /* 1 in an orthographic view */

out vec3 v_position;
out vec3 v_ray; /* from the eye */
out vec3 v_normal;
out vec3 v_color;
out vec4 v_texcoords;

void main() {
    gl_Position = u_clip * vec4(a_position, 1.0);
    v_position = (u_modelview * vec4(a_position, 1.0)).xyz;
    v_ray = u_parallel != 0 ? vec3(0.0, 0.0, -1.0) : v_position;
    v_normal = mat3(u_modelview) * a_normal;
    v_color = a_color;
    v_texcoords = a_texcoords;
}
