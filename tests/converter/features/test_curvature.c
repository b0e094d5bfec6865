/* SPDX-License-Identifier: MIT
 *
 * test_curvature.c - tests that noise is distinguished from the shape and removed from the normals,
 * at every strength of noise. The shape is a flat square with noise of the vertices, so that any
 * remaining bend is an error.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "shape_fixture.h"
#include "stage_fixture.h"
#include "features/surface.h"
#include "mesh/mesh.h"
#include "features/curvature.h"

#include <math.h>

enum { CELLS = 60 };

static void place_square(double s, double t, double p[3]) {
    p[0] = CELLS * s, p[1] = CELLS * t, p[2] = 0;
}

static double root_mean_square(const float *bends, const psplat_surface *surface) {
    double squares = 0, count = 0;
    for (size_t e = 0; e < 3 * surface->mesh->triangle_count; ++e) {
        if (surface->neighbors[e] == PSPLAT_NONE) continue;
        squares += (double)bends[e] * (double)bends[e];
        ++count;
    }
    return sqrt(squares / count);
}

/* Returns the ratio of the smoothed bends of a noisy square to the measured ones, both as root mean
 * squares. *bend receives the latter, in radians; noise is in edge lengths of the mesh. */
static double left_of(double noise, double *bend) {
    fixture f;
    psplat_curvature c;
    fixture_grid(&f, CELLS, CELLS, place_square);
    shape_noise(&f.mesh, noise);
    fixture_build(&f);
    assert_int_equal(psplat_curvature_measure(&f.surface, 0.5, &c), PSPLAT_OK);
    *bend = root_mean_square(c.angles, &f.surface);
    double left = root_mean_square(c.smooth_angles, &f.surface) / *bend;
    psplat_curvature_free(&c);
    fixture_free(&f);
    return left;
}

/* The ratio is the same whether noise bends edges by 1 degree or by 17: the bends above 50 degrees,
 * which count as shape, are compensated for. That estimate is at most 5 % off; the rest of the
 * tolerance allows for bends that do not follow the sines of the model. */
static void test_noise(void **state) {
    (void)state;
    static const double parts[] = {0.03, 0.06, 0.09, 0.125};
    double bend, little = left_of(0.01, &bend);
    assert_near(bend, 0.023, 0.002);
    assert_true(little < 0.15);
    for (int i = 0; i < 4; ++i) assert_near(left_of(parts[i], &bend) / little, 1, 0.07);
    assert_near(bend, 0.3, 0.02);
}

int test_curvature_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_noise)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
