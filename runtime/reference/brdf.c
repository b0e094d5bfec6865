/* SPDX-License-Identifier: MIT
 *
 * brdf.c - the two microfacet terms D and V of spec 5.6, after appendix B of glTF 2.0, which lights
 * (shade.c) and the environment (environment_light.c) share.
 */
#include "reference/oracle.h"

#include <math.h>

double psplat_oracle_distribution(double normal_half, double alpha) {
    double a2 = alpha * alpha;
    double k = normal_half * normal_half * (a2 - 1) + 1;
    return a2 / (PSPLAT_ORACLE_PI * k * k);
}

double psplat_oracle_visibility(double normal_light, double normal_eye, double alpha) {
    double a2 = alpha * alpha;
    double light = normal_light * sqrt(normal_eye * normal_eye * (1 - a2) + a2);
    double eye = normal_eye * sqrt(normal_light * normal_light * (1 - a2) + a2);
    return 0.5 / (light + eye);
}
