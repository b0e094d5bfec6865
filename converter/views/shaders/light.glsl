/* SPDX-License-Identifier: MIT
 *
 * light.glsl - the lighting of spec 5.6 for directional lights and ambient radiance, with directions in
 * eye space. It is written independently of the splat renderer's shading.glsl, so that a comparison
 * of both shows mistakes of either.
 */
#define MAX_LIGHTS 8
uniform vec3 u_light_directions[MAX_LIGHTS]; /* towards the lights */
uniform vec3 u_light_colors[MAX_LIGHTS];
uniform int u_light_count;
uniform vec3 u_ambient;
uniform vec3 u_emissive;
uniform vec3 u_surface; /* metallic, roughness, unlit */
uniform int u_linear_output;
uniform int u_unlit; /* 1: the base colour alone, whatever the material is */

const float PI = 3.14159265358979;

/* Returns D times V. The denominator of D, (n.h)^2 (a2 - 1) + 1, is computed as a sum, since the
 * difference would lose all digits at low roughness. */
float specular_lobe(vec3 n, vec3 h, float nl, float nv, float alpha) {
    float a2 = alpha * alpha;
    float nh = dot(n, h);
    vec3 across = cross(n, h);
    float d = nh > 0.0 ? dot(across, across) + nh * nh * a2 : 1.0;
    float smith = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
    return a2 / (PI * d * d) * 0.5 / max(smith, 1e-7);
}

/* The material at a pixel, with textures applied. */
struct surface {
    vec3 color, emissive;
    float metallic, roughness, occlusion;
};

surface plain_surface(vec3 color) {
    return surface(color, u_emissive, u_surface.x, u_surface.y, 1.0);
}

/* Lights a pixel. The normal may have any length; a zero normal faces the eye. */
vec3 light_finished(vec3 normal, vec3 view, surface s) {
    float square = dot(normal, normal);
    vec3 n = square > 0.0 ? normal * inversesqrt(square) : view;
    vec3 diffuse = s.color * (1.0 - s.metallic);
    vec3 f0 = mix(vec3(0.04), s.color, s.metallic);
    float alpha = max(s.roughness * s.roughness, 0.002);
    float nv = max(dot(n, view), 1e-4);
    vec3 result = s.occlusion * u_ambient * (diffuse + f0) + s.emissive;
    for (int i = 0; i < u_light_count; ++i) {
        vec3 l = u_light_directions[i];
        float nl = dot(n, l);
        if (nl <= 0.0) continue;
        vec3 h = normalize(l + view);
        vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(dot(view, h), 0.0, 1.0), 5.0);
        vec3 lobes =
            (1.0 - fresnel) * diffuse / PI + fresnel * specular_lobe(n, h, nl, nv, alpha);
        result += u_light_colors[i] * nl * lobes;
    }
    return u_unlit != 0 ? s.color : mix(result, s.color, u_surface.z);
}

vec3 light_surface(vec3 normal, vec3 view, vec3 color) {
    return light_finished(normal, view, plain_surface(color));
}

vec3 encode(vec3 linear) {
    if (u_linear_output != 0) return linear;
    vec3 c = clamp(linear, 0.0, 1.0);
    vec3 high = 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
