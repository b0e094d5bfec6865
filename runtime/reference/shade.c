/* SPDX-License-Identifier: MIT
 * Spec 5.6: the metallic-roughness material of glTF 2.0 (appendix B of that specification) under
 * one directional light and a constant ambient term. */
#include "oracle.h"

#include <math.h>

void psplat_oracle_light_set(psplat_oracle_light *light, const psplat_view *view) {
    double direction[3], moved[4];
    for (int i = 0; i < 3; ++i) {
        direction[i] = -view->lights[0].direction[i];
        light->irradiance[i] = view->light_count ? view->lights[0].color[i] : 0;
        light->ambient[i] = view->ambient[i];
    }
    psplat_oracle_transform(view->view, direction, 0, moved);
    for (int i = 0; i < 3; ++i) light->direction[i] = moved[i];
    psplat_oracle_normalise(light->direction);
}

/* Trowbridge-Reitz (GGX) distribution of microfacet normals. */
static double distribution(double normal_half, double alpha) {
    double a2 = alpha * alpha;
    double k = normal_half * normal_half * (a2 - 1) + 1;
    return a2 / (3.14159265358979323846 * k * k);
}

/* Height-correlated Smith masking and shadowing, divided by 4 (n.l) (n.e). */
static double visibility(double normal_light, double normal_eye, double alpha) {
    double a2 = alpha * alpha;
    double light = normal_light * sqrt(normal_eye * normal_eye * (1 - a2) + a2);
    double eye = normal_eye * sqrt(normal_light * normal_light * (1 - a2) + a2);
    return 0.5 / (light + eye);
}

static double mix(double a, double b, double s) {
    return a + (b - a) * s;
}

void psplat_oracle_shade(const psplat_oracle_surface *surface, const psplat_oracle_light *light,
                         const double normal[3], const double to_eye[3], double radiance[3]) {
    double half[3];
    for (int i = 0; i < 3; ++i) half[i] = light->direction[i] + to_eye[i];
    psplat_oracle_normalise(half);
    double normal_light = fmax(psplat_oracle_dot(normal, light->direction), 0);
    double normal_eye = fmax(psplat_oracle_dot(normal, to_eye), 1e-4);
    double alpha = fmax(surface->roughness * surface->roughness, 0.002);
    double normal_half = fmax(psplat_oracle_dot(normal, half), 0);
    double specular = normal_light > 0 ? visibility(normal_light, normal_eye, alpha) *
                                             distribution(normal_half, alpha)
                                       : 0;
    double grazing = pow(1 - fmax(psplat_oracle_dot(to_eye, half), 0), 5);
    for (int i = 0; i < 3; ++i) {
        double base = surface->base[i];
        double diffuse = base * (1 - surface->metallic);
        double f0 = mix(0.04, base, surface->metallic);
        double fresnel = mix(f0, 1, grazing);
        double reflected = (1 - fresnel) * diffuse / 3.14159265358979323846 + fresnel * specular;
        double lit = light->ambient[i] * (diffuse + f0) +
                     light->irradiance[i] * reflected * normal_light + surface->emissive[i];
        radiance[i] = mix(lit, base, surface->unlit);
    }
}

double psplat_oracle_encode(double linear) {
    double x = fmin(fmax(linear, 0), 1);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}
