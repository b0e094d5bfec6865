/* SPDX-License-Identifier: MIT
 *
 * shading.glsl - lighting by spec 5.6: glTF 2.0's metallic-roughness material (appendix B of that
 * document) under lights with the units of KHR_lights_punctual, their shadow maps, a constant
 * ambient radiance and an environment. All positions and directions are in eye space.
 *
 * resolve_inputs.glsl comes before this file in the resolve pass. gl_program.c defines LIGHT_COUNT,
 * PUNCTUAL (some light is not directional), ENVIRONMENT and SHADOWS; and HOST_LIGHT where a host's
 * resolve function filters the lights (psplat_resolve).
 */
#ifndef HANDED_ON
uniform mat3 u_ray;       /* from (pixel x, pixel y, 1) to the view ray */
uniform vec3 u_ambient;
#endif
uniform mat4 u_unproject; /* from pixel x, y and window depth to eye space */
#if LIGHT_COUNT > 0
#ifndef HANDED_ON_LIGHTS
uniform vec4 u_light_position[LIGHT_COUNT]; /* w = 0: the direction towards a directional light */
uniform vec4 u_light_color[LIGHT_COUNT];    /* w: 1 / range^2, 0 without a range */
#endif
uniform vec3 u_light_axis[LIGHT_COUNT];     /* the direction in which it shines */
uniform vec4 u_light_cone[LIGHT_COUNT];     /* psplat_lights.cone */
#endif
#if ENVIRONMENT
uniform highp samplerCube u_diffuse;
uniform highp samplerCube u_glossy;
uniform highp sampler2D u_split_sum;
uniform mat3 u_eye_to_scene;
uniform float u_glossy_levels;
#endif
#if SHADOWS
uniform highp sampler2DShadow u_shadows;
uniform mat4 u_shadow_matrix[PSPLAT_SHADOW_COUNT];
uniform vec2 u_shadow_scale; /* width of a map as part of the texture's; psplat_shadows.lift */
#endif

const float PI = 3.14159265358979;

/* Returns the unit direction from a pixel's point to the eye. */
vec3 view_direction(vec2 pixel) {
    return -normalize(u_ray * vec3(pixel, 1.0));
}

/* Returns the point of a pixel with this window depth. */
vec3 position_of(vec3 window) {
    vec4 position = u_unproject * vec4(window, 1.0);
    return position.xyz / position.w;
}

/* Returns the radiance that a light of unit irradiance sends to the eye, times n.l. D and V of (7)
 * share one denominator, and h keeps its length, as |h|^2 = 2 + 2 l.e and e.h = |h|^2 / 2. At low
 * roughness, where n and h are close, 1 - (n.h)^2 would cancel, so |n x h|^2 takes its place. */
vec3 reflect_light(vec3 n, vec3 view, vec3 l, vec3 diffuse, vec3 f0, float alpha) {
    float a2 = alpha * alpha;
    float nl = max(dot(n, l), 0.0);
    float nv = max(dot(n, view), 1e-4);
    vec3 h = l + view;
    vec3 across = cross(n, h);
    float h2 = max(dot(h, h), 1e-12);
    float nh = dot(n, h);
    float d = nh > 0.0 ? dot(across, across) + nh * nh * a2 : h2;
    float smith = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
    float specular = 0.5 / PI * a2 * h2 * h2 / max(d * d * smith, 1e-30);
    float s = 1.0 - 0.5 * sqrt(h2);
    float s2 = s * s;
    vec3 fresnel = f0 + (1.0 - f0) * (s2 * s2 * s);
    return nl * ((diffuse - fresnel * diffuse) / PI + fresnel * specular);
}

#if SHADOWS
/* Returns the part of a light, 0 ... 1, that reaches a point: the texels of a shadow map are
 * compared, then filtered. The point is lifted off the surface by a texel and a half, so that a
 * slope within a texel casts no shadow, and by the distance that splats of one surface lie apart.
 */
float lit_part(vec4 cone, vec3 position, vec3 normal, float distance) {
    if (cone.z < 0.0) return 1.0;
    vec3 lifted = position + normal * (1.5 * cone.w * distance + u_shadow_scale.y);
    vec4 at = u_shadow_matrix[int(cone.z)] * vec4(lifted, 1.0);
    at.xyz /= at.w;
    vec3 outside = abs(at.xyz * 2.0 - 1.0);
    if (at.w <= 0.0 || max(outside.x, max(outside.y, outside.z)) >= 1.0) return 1.0;
    return textureLod(u_shadows, vec3((at.x + cone.z) * u_shadow_scale.x, at.yz), 0.0);
}
#endif

#ifdef HOST_LIGHT
/* Returns the part of a light that reaches a point, 0 ... 1; the host defines it. */
float light_part(int light, vec3 position, vec3 normal);
#endif

#if ENVIRONMENT
/* Returns L_env of eq. (9), from the textures of prefiltered radiance. */
vec3 reflect_environment(vec3 n, vec3 view, vec3 diffuse, vec3 f0, float roughness) {
    float nv = clamp(dot(n, view), 0.0, 1.0);
    vec3 direction = u_eye_to_scene * (2.0 * dot(n, view) * n - view);
    vec3 glossy = textureLod(u_glossy, direction, roughness * u_glossy_levels).rgb;
    const float table = float(PSPLAT_SPLIT_SUM_SIZE);
    vec2 entry = (vec2(sqrt(nv), roughness) * (table - 1.0) + 0.5) / table;
    vec2 split_sum = textureLod(u_split_sum, entry, 0.0).rg;
    return diffuse / PI * textureLod(u_diffuse, u_eye_to_scene * n, 0.0).rgb +
           (f0 * split_sum.x + split_sum.y) * glossy;
}
#endif

/* Returns the radiance of eq. (7). window is pixel x, y and depth; surface is metallic, roughness,
 * unlit (1 for unlit, and between 0 and 1 where unlit splats blend with lit ones) and occlusion. */
vec3 shade(vec3 normal, vec3 window, vec3 color, vec3 emissive, vec4 surface) {
    vec3 view = view_direction(window.xy);
    float length2 = dot(normal, normal);
    vec3 n = length2 > 0.0 ? normal * inversesqrt(length2) : view;
    vec3 diffuse = color * (1.0 - surface.x);
    vec3 f0 = mix(vec3(0.04), color, surface.x);
    vec3 result = surface.w * u_ambient * (diffuse + f0) + emissive;
#if LIGHT_COUNT > 0
    float alpha = max(surface.y * surface.y, 0.002);
#if PUNCTUAL || SHADOWS || defined(HOST_LIGHT)
    vec3 position = position_of(window);
#endif
    for (int i = 0; i < LIGHT_COUNT; ++i) {
        vec3 l = u_light_position[i].xyz;
        vec3 irradiance = u_light_color[i].rgb;
        float distance = 1.0;
#if PUNCTUAL
        if (u_light_position[i].w > 0.0) {
            l -= position;
            distance = max(length(l), 1e-15);
            l /= distance;
            float far = distance * distance * u_light_color[i].w;
            float cone =
                clamp(u_light_cone[i].y - u_light_cone[i].x * dot(l, u_light_axis[i]), 0.0, 1.0);
            irradiance *= cone * cone * max(1.0 - far * far, 0.0) / (distance * distance);
        }
#endif
#if SHADOWS
        irradiance *= lit_part(u_light_cone[i], position, n, distance);
#endif
#ifdef HOST_LIGHT
        irradiance *= light_part(i, position, n);
#endif
        result += irradiance * reflect_light(n, view, l, diffuse, f0, alpha);
    }
#endif
#if ENVIRONMENT
    result += surface.w * reflect_environment(n, view, diffuse, f0, surface.y);
#endif
    return mix(result, color, surface.z);
}
