/* SPDX-License-Identifier: MIT
 *
 * resolve_inputs.glsl - takes the uniforms of the resolve pass from its vertices (resolve.vert), and
 * reads the render targets by texture coordinates. GLs in software fetch each number of a uniform
 * once for each fragment, but what is flat over a triangle once for the triangle, and texelFetch
 * looks for its level of detail where textureLod of a texture without levels does not. On llvmpipe
 * a fragment of the resolve pass took a third less time; on GPUs it was not measured.
 *
 * It comes before shading.glsl and resolve.frag, which declare the uniforms themselves where it is
 * not there, as in three.js.
 */
#define HANDED_ON

uniform highp sampler2D u_target0;
uniform highp sampler2D u_target1;
uniform highp sampler2D u_target2;
uniform highp sampler2D u_target3;
uniform highp sampler2D u_depth;

flat in ivec2 v_origin;
flat in vec4 v_scales; /* texture coordinates of a pixel; u_to_host */
flat in vec3 v_base_color;
flat in vec3 v_emissive;
flat in vec3 v_surface;
flat in mat3 v_ray;
flat in vec3 v_ambient;
#define u_origin v_origin
#define u_to_host v_scales.zw
#define u_base_color v_base_color
#define u_emissive v_emissive
#define u_surface v_surface
#define u_ray v_ray
#define u_ambient v_ambient
#if LIGHT_COUNT > 0 && LIGHT_COUNT <= PSPLAT_HANDED_ON_LIGHTS
#define HANDED_ON_LIGHTS
flat in vec4 v_light_position[LIGHT_COUNT];
flat in vec4 v_light_color[LIGHT_COUNT];
#define u_light_position v_light_position
#define u_light_color v_light_color
#endif

vec4 target_at(highp sampler2D target, ivec2 at) {
    return textureLod(target, (vec2(at) + 0.5) * v_scales.xy, 0.0);
}
