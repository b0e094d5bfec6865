/* SPDX-License-Identifier: MIT
 *
 * shade.c - the radiance of one surface point, eq. (7) of spec 5.6: the metallic-roughness material
 * of glTF 2.0 (appendix B of that specification) under lights, an environment and a constant
 * ambient term. Also the sRGB encoding of the result.
 */
#include "reference/oracle.h"

#include <math.h>

static double mix(double a, double b, double s) {
    return a + (b - a) * s;
}

/* Adds one light's term of the sum in eq. (7). All directions are unit vectors. */
static void add_light(const psplat_oracle_surface *surface, const double to_light[3],
                      const double irradiance[3], const double normal[3], const double to_eye[3],
                      double radiance[3]) {
    double half[3];
    for (int i = 0; i < 3; ++i) half[i] = to_light[i] + to_eye[i];
    psplat_oracle_normalise(half);
    double normal_light = psplat_oracle_dot(normal, to_light);
    if (!(normal_light > 0)) return;
    double normal_eye = fmax(psplat_oracle_dot(normal, to_eye), 1e-4);
    double normal_half = fmax(psplat_oracle_dot(normal, half), 0);
    double alpha = fmax(surface->roughness * surface->roughness, 0.002);
    double specular = psplat_oracle_visibility(normal_light, normal_eye, alpha) *
                      psplat_oracle_distribution(normal_half, alpha);
    double grazing = pow(1 - fmax(psplat_oracle_dot(to_eye, half), 0), 5);
    for (int i = 0; i < 3; ++i) {
        double diffuse = surface->base[i] * (1 - surface->metallic);
        double fresnel = mix(mix(0.04, surface->base[i], surface->metallic), 1, grazing);
        double reflected = (1 - fresnel) * diffuse / PSPLAT_ORACLE_PI + fresnel * specular;
        radiance[i] += irradiance[i] * reflected * normal_light;
    }
}

void psplat_oracle_shade(const psplat_oracle_surface *surface,
                         const psplat_oracle_lighting *lighting, const double point[3],
                         const double normal[3], const double to_eye[3], double radiance[3]) {
    for (int i = 0; i < 3; ++i) {
        double diffuse = surface->base[i] * (1 - surface->metallic);
        double f0 = mix(0.04, surface->base[i], surface->metallic);
        radiance[i] = surface->occlusion * lighting->ambient[i] * (diffuse + f0);
        radiance[i] += surface->emissive[i];
    }
    for (int k = 0; k < lighting->count; ++k) {
        double to_light[3], irradiance[3];
        psplat_oracle_light_at(lighting, &lighting->lights[k], point, to_light, irradiance);
        add_light(surface, to_light, irradiance, normal, to_eye, radiance);
    }
    psplat_oracle_environment_add(&lighting->environment, surface, normal, to_eye, radiance);
    for (int i = 0; i < 3; ++i) radiance[i] = mix(radiance[i], surface->base[i], surface->unlit);
}

double psplat_oracle_encode(double linear) {
    double x = fmin(fmax(linear, 0), 1);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}
