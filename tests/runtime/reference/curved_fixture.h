/* SPDX-License-Identifier: MIT
 *
 * curved_fixture.h - curved splats before the reference's camera, and closed forms of where rays
 * meet them (spec 3.4, 5.1). Include this file after cmocka.h.
 *
 * Where the axes are x, y, z, the surface is z = -(p X + q Y + (A X^2 + 2 B X Y + C Y^2) / 2) in
 * lengths, and the ray of pixel (x, y) is (s dx, s dy, 5 - s): it meets the surface where
 *
 *     k s^2 / 2 - m s + 5 = 0,    k = A dx^2 + 2 B dx dy + C dy^2,    m = 1 - p dx - q dy
 *
 * and its height above the surface falls by m - k s, so that s = 10 / (m + sqrt(m^2 - 10 k)) is the
 * front.
 */
#ifndef PHONGSPLAT_TEST_CURVED_FIXTURE_H
#define PHONGSPLAT_TEST_CURVED_FIXTURE_H

#include "near.h"
#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>
#include <string.h>

#define WIDTH 120
#define HEIGHT 90
#define FOCAL 100.0
#define DISTANCE 5.0
#define NEAR 0.5
#define FAR 20.0

/* The tolerance for some ten sums and products of numbers near 1 in double, 1e-15 each, with a
 * margin. */
#define ROUNDING 1e-12
/* Slopes of surfaces that stem from normals are rounded to floats, where they are at most 2. */
#define FLOAT_STEP 2.5e-7

static inline psplat_view front_view(void) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
    camera_perspective(&view, FOCAL, NEAR, FAR);
    return view;
}

static inline double ray_x(int x) {
    return (x + 0.5 - WIDTH / 2.0) / FOCAL;
}

static inline double ray_y(int y) {
    return (y + 0.5 - HEIGHT / 2.0) / FOCAL;
}

static inline double depth_of(double s) {
    return 0.5 + 0.5 * ((FAR + NEAR) / (FAR - NEAR) - 2 * FAR * NEAR / ((FAR - NEAR) * s));
}

/* Returns one splat at the origin whose surface has its own alpha, beta and gamma. The normal field
 * stays constant. */
static inline scene shaped(double radius_u, double radius_v, double alpha, double beta,
                           double gamma) {
    scene s = scene_blank(1);
    psplat_splat *splat = &s.splats[0];
    splat->radius[0] = (float)radius_u, splat->radius[1] = (float)radius_v;
    splat->shape[2] = (float)alpha, splat->shape[3] = (float)beta, splat->shape[4] = (float)gamma;
    return s;
}

/* ---- a surface before the camera ------------------------------------------------------------- */

/* The coefficients of the file's comment, and the radii. */
typedef struct surface {
    double p, q, a, b, c, radius_u, radius_v;
} surface;

static inline surface surface_of(const psplat_splat *splat) {
    double u = splat->radius[0], v = splat->radius[1];
    return (surface){.p = splat->shape[0],
                     .q = splat->shape[1],
                     .a = (double)splat->shape[2] / u,
                     .b = (double)splat->shape[4] / u,
                     .c = (double)splat->shape[3] / v,
                     .radius_u = u,
                     .radius_v = v};
}

/* ---- from the side --------------------------------------------------------------------------- */

#define SIDE 81
#define HALF 1.0

/* Looks along -x in a parallel view: the image's x is -z and its y is y, both from -HALF. */
static inline psplat_view side_view(void) {
    psplat_view view = camera_view(SIDE, SIDE);
    camera_look(&view, (double[]){DISTANCE, 0, 0}, (double[]){0, 0, 0});
    camera_parallel(&view, HALF, 1, 10);
    view.shading = PSPLAT_SHADING_NORMAL;
    return view;
}

static inline double side_of(int i) {
    return (i + 0.5) * 2 * HALF / SIDE - HALF;
}

#endif
