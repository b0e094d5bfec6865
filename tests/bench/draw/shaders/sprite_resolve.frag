/* SPDX-License-Identifier: MIT
 *
 * BHZK05 section 4: the sums divided by their weights are lit once per pixel.
 */
uniform sampler2D u_normals;
uniform sampler2D u_colors;
uniform sampler2D u_depth;
uniform mat3 u_ray;

layout(location = 0) out vec4 o_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(u_normals, pixel, 0);
    if (!(normal.a > 0.0)) discard;
    vec3 color = texelFetch(u_colors, pixel, 0).rgb / normal.a;
    vec3 view = -normalize(u_ray * vec3(gl_FragCoord.xy, 1.0));
    o_color = vec4(encode(light_surface(normal.xyz, view, color)), 1.0);
    gl_FragDepth = texelFetch(u_depth, pixel, 0).r;
}
