/* SPDX-License-Identifier: MIT
 *
 * Spec 5.6: glTF 2.0's metallic-roughness material (appendix B of that document) under one
 * directional light and a constant ambient radiance. Directions in eye space.
 */
uniform vec3 u_light_direction;
uniform vec3 u_light_color;
uniform vec3 u_ambient;

const float PI = 3.14159265358979;

/* D times V: Trowbridge-Reitz distribution and height-correlated Smith visibility. Written with
 * |n x h| where n and h are close: 1 - (n.h)^2 has no digits left at low roughness. */
float specular_lobe(vec3 n, vec3 h, float nl, float nv, float alpha) {
    float a2 = alpha * alpha;
    vec3 c = cross(n, h);
    float nh = dot(n, h);
    float d = nh > 0.0 ? dot(c, c) + nh * nh * a2 : 1.0;
    float smith = nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2);
    return a2 / (PI * d * d) * 0.5 / max(smith, 1e-7);
}

/* surface: metallic, roughness, unlit (1: unlit; between, where such splats blend with lit ones). */
vec3 shade(vec3 normal, vec3 view, vec3 color, vec3 emissive, vec3 surface) {
    float length2 = dot(normal, normal);
    vec3 n = length2 > 0.0 ? normal * inversesqrt(length2) : view;
    vec3 l = u_light_direction;
    vec3 h = normalize(l + view + 1e-12 * n);
    float nl = dot(n, l);

    vec3 diffuse = color * (1.0 - surface.x);
    vec3 f0 = mix(vec3(0.04), color, surface.x);
    vec3 result = u_ambient * (diffuse + f0) + emissive;
    if (nl > 0.0) {
        float alpha = max(surface.y * surface.y, 0.002);
        float nv = max(dot(n, view), 1e-4);
        vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - clamp(dot(view, h), 0.0, 1.0), 5.0);
        vec3 lobes = (1.0 - fresnel) * diffuse / PI + fresnel * specular_lobe(n, h, nl, nv, alpha);
        result += u_light_color * nl * lobes;
    }
    return mix(result, color, surface.z);
}
