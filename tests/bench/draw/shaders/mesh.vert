/* SPDX-License-Identifier: MIT
 *
 * Triangles with normals, for lighting once per pixel.
 */
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 a_color;

uniform mat4 u_modelview;
uniform mat4 u_projection;

out vec3 v_eye;
out vec3 v_normal;
out vec3 v_color;

void main() {
    vec4 eye = u_modelview * vec4(a_position, 1.0);
    gl_Position = u_projection * eye;
    v_eye = eye.xyz;
    v_normal = mat3(u_modelview) * a_normal;
    v_color = a_color.rgb;
}
