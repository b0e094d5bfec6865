/* SPDX-License-Identifier: MIT
 *
 * resolve.vert - one triangle that covers the viewport; it needs no vertex data. It hands the
 * uniforms of the resolve pass on to its fragments (resolve_inputs.glsl).
 *
 * gl_program.c defines LIGHT_COUNT.
 */
uniform highp sampler2D u_target0;
uniform ivec2 u_origin;
uniform vec2 u_to_host;
uniform vec3 u_base_color;
uniform vec3 u_emissive;
uniform vec3 u_surface;
uniform mat3 u_ray;
uniform vec3 u_ambient;

flat out ivec2 v_origin;
flat out vec4 v_scales; /* texture coordinates of a pixel; u_to_host */
flat out vec3 v_base_color;
flat out vec3 v_emissive;
flat out vec3 v_surface;
flat out mat3 v_ray;
flat out vec3 v_ambient;
#if LIGHT_COUNT > 0 && LIGHT_COUNT <= PSPLAT_HANDED_ON_LIGHTS
uniform vec4 u_light_position[LIGHT_COUNT];
uniform vec4 u_light_color[LIGHT_COUNT];
flat out vec4 v_light_position[LIGHT_COUNT];
flat out vec4 v_light_color[LIGHT_COUNT];
#endif

void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
    v_origin = u_origin;
    v_scales = vec4(1.0 / vec2(textureSize(u_target0, 0)), u_to_host);
    v_base_color = u_base_color;
    v_emissive = u_emissive;
    v_surface = u_surface;
    v_ray = u_ray;
    v_ambient = u_ambient;
#if LIGHT_COUNT > 0 && LIGHT_COUNT <= PSPLAT_HANDED_ON_LIGHTS
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        v_light_position[i] = u_light_position[i];
        v_light_color[i] = u_light_color[i];
    }
#endif
}
