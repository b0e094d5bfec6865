/* SPDX-License-Identifier: MIT
 *
 * sky.c - an environment made by formulas: a hazy sky, a low sun behind a thin cloud, the ground.
 */
#include "viewer.h"

#include <math.h>
#include <stdlib.h>

enum { SKY_SIZE = 64 };

static double mix(double a, double b, double t) {
    return a + t * (b - a);
}

/* Computes the linear radiance from direction d (unit length). The sky as a whole lights a white
 * surface that faces up to about 1. */
static void sky_radiance(const double d[3], float rgb[3]) {
    static const double zenith[3] = {0.34, 0.46, 0.7}, horizon[3] = {0.8, 0.82, 0.85};
    static const double ground[3] = {0.22, 0.2, 0.17}, sun[3] = {1, 0.86, 0.66};
    static const double to_sun[3] = {-0.48, 0.6, 0.64};
    double height = sqrt(fmax(d[1], 0)), above = fmin(fmax(20 * d[1] + 0.5, 0), 1);
    double glow = fmax(d[0] * to_sun[0] + d[1] * to_sun[1] + d[2] * to_sun[2], 0);
    double light = 6 * pow(glow, 150) + 0.8 * pow(glow, 6);
    for (int i = 0; i < 3; ++i) {
        double sky = mix(horizon[i], zenith[i], height) + light * sun[i];
        rgb[i] = (float)mix(ground[i], sky, above);
    }
}

/* Computes the direction of the point (s, t), -1 ... 1, of a face of a cube map (OpenGL 3.3,
 * section 3.8.10). */
static void face_direction(int face, double s, double t, double d[3]) {
    const double table[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
    double length = sqrt(1 + s * s + t * t);
    for (int i = 0; i < 3; ++i) d[i] = table[face][i] / length;
}

psplat_environment *sky_create(psplat_renderer *renderer, psplat_error *error) {
    enum { TEXELS = 6 * SKY_SIZE * SKY_SIZE };
    float *radiance = malloc(TEXELS * 3 * sizeof *radiance);
    psplat_environment *environment = NULL;
    if (!radiance) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a sky"), NULL;
    for (int i = 0; i < TEXELS; ++i) {
        int row = i / SKY_SIZE % SKY_SIZE, column = i % SKY_SIZE;
        double d[3], s = (2.0 * column + 1) / SKY_SIZE - 1, t = (2.0 * row + 1) / SKY_SIZE - 1;
        face_direction(i / (SKY_SIZE * SKY_SIZE), s, t, d);
        sky_radiance(d, radiance + 3 * i);
    }
    psplat_environment_desc desc = {.radiance = radiance, .size = SKY_SIZE};
    psplat_environment_create(renderer, &desc, &environment, error);
    free(radiance);
    return environment;
}
