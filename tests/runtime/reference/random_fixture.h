/* SPDX-License-Identifier: MIT
 *
 * random_fixture.h - random views, transforms and clip lines for tests of the reference against
 * another way to find what it finds. Include this file after cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_RANDOM_FIXTURE_H
#define PHONGSPLAT_TEST_RANDOM_FIXTURE_H

#include "near.h"
#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>

#define WIDTH 24
#define HEIGHT 18

static inline double between(uint32_t *random, double low, double high) {
    return low + (high - low) * (double)scene_random(random);
}

/* Returns a log-uniform number, for sizes from far below a pixel to far beyond the view. */
static inline double magnitude(uint32_t *random, double low, double high) {
    return low * pow(high / low, (double)scene_random(random));
}

/* Gives a splat up to four clip lines, bent or straight. */
static inline void random_lines(psplat_splat *splat, int has_bends, uint32_t *random) {
    splat->clip_count = (uint32_t)between(random, 0, 4.99);
    for (uint32_t k = 0; k < splat->clip_count; ++k) {
        double angle = between(random, 0, 6.28);
        splat->clip[k][0] = (float)cos(angle);
        splat->clip[k][1] = (float)sin(angle);
        splat->clip[k][2] = (float)between(random, 0, 1);
        if (has_bends) splat->bend[k] = (float)between(random, -3, 3);
    }
}

/* Returns a view from about the origin to about there, of any width, parallel or in perspective,
 * with an oblique frustum. culls: half of the views leave backs out whatever materials say. */
static inline psplat_view random_view(uint32_t *random, int culls) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    double eye[3], target[3];
    for (int i = 0; i < 3; ++i) {
        eye[i] = between(random, -3, 3);
        target[i] = between(random, -3, 3);
    }
    camera_look(&view, eye, target);
    view.culling = culls && scene_random(random) >= 0.5f ? PSPLAT_CULL_ALWAYS : PSPLAT_CULL_NEVER;
    double near = magnitude(random, 1e-3, 1), far = near + magnitude(random, 1, 1e4);
    if (scene_random(random) < 0.3f)
        camera_parallel(&view, magnitude(random, 0.1, 10), -1, far);
    else
        camera_perspective(&view, magnitude(random, 5, 100), near, far);
    for (int i = 8; i < 10; ++i) view.projection[i] = between(random, -0.5, 0.5);
    return view;
}

/* Makes a random matrix that scales, shears, mirrors and moves. */
static inline void random_transform(double m[16], uint32_t *random) {
    for (int i = 0; i < 16; ++i) m[i] = between(random, -0.3, 0.3);
    for (int i = 0; i < 3; ++i) {
        m[i * 5] = between(random, 0.6, 1.5) * (scene_random(random) < 0.2f ? -1 : 1);
        m[i * 4 + 3] = 0;
    }
    m[15] = 1;
}

/* Multiplies a matrix by a vector. */
static inline void apply(const double m[16], const double v[4], double out[4]) {
    for (int row = 0; row < 4; ++row)
        out[row] = m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row] * v[3];
}

#endif
