/* SPDX-License-Identifier: MIT
 *
 * test_splat_texcoord.c - tests of texture coordinates over a splat and of the length by which an
 * error of theirs moves a texture over the surface. That length is compared with places on the
 * surface whose coordinates differ by the error.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <cmocka.h>

#include "near.h"
#include "base/region.h"
#include "base/vector.h"
#include "splats/splat_texcoord.h"

static const psplat_texcoord some = {.at = {0.5f, 0.25f},
                                     .along_u = {0.5f, 0.125f},
                                     .along_v = {-0.25f, 0.5f},
                                     .along_uu = {0.0625f, 0.03125f},
                                     .along_uv = {0.125f, 0},
                                     .along_vv = {-0.03125f, 0.0625f}};
static const double texels[2] = {1000, 500};

/* What a quarter of a texel hides is taken off. */
static double seen(double length, const double error[2]) {
    return length * (1 - 0.25 / hypot(error[0] * texels[0], error[1] * texels[1]));
}

static void test_values(void **state) {
    (void)state;
    const double uv[2] = {0.5, -0.25}, step = 1e-4;
    double at[2], slopes[2][2];
    psplat_texcoord_at(&some, uv, at);
    assert_near(at[0], 0.5 + 0.25 + 0.0625 + 0.015625 - 0.015625 - 0.001953125, 1e-12);
    assert_near(at[1], 0.25 + 0.0625 - 0.125 + 0.0078125 + 0.00390625, 1e-12);
    psplat_texcoord_slopes(&some, uv, slopes);
    for (int k = 0; k < 2; ++k) {
        double more[2] = {uv[0], uv[1]}, less[2] = {uv[0], uv[1]}, above[2], below[2];
        more[k] += step, less[k] -= step;
        psplat_texcoord_at(&some, more, above);
        psplat_texcoord_at(&some, less, below);
        for (int i = 0; i < 2; ++i) /* A central difference of a parabola is exact. */
            assert_near(slopes[k][i], (above[i] - below[i]) / (2 * step), 1e-9);
    }
}

static psplat_region bowl(void) {
    return (psplat_region){.u = {1, 0, 0},
                           .v = {0, 1, 0},
                           .n = {0, 0, 1},
                           .radius = {3, 2},
                           .slope = {0.1, -0.2},
                           .hessian = {0.2, 0.1, -0.3}};
}

/* The slide of the error between two places close together is their distance. */
static void test_slide_is_a_distance(void **state) {
    (void)state;
    const psplat_region region = bowl();
    const double uv[2] = {0.4, 0.3};
    for (int i = 0; i < 8; ++i) {
        double near[2] = {uv[0] + 1e-3 * cos(i), uv[1] + 1e-3 * sin(i)}, a[3], b[3], here[2];
        double error[2];
        psplat_region_point(&region, uv, a);
        psplat_region_point(&region, near, b);
        psplat_texcoord_at(&some, uv, here);
        psplat_texcoord_at(&some, near, error);
        for (int k = 0; k < 2; ++k) error[k] -= here[k];
        psplat_slide slide = psplat_texcoord_slide(&some, &region, uv, texels, error);
        double length = sqrt(distance2_3(a, b));
        /* Both change to the first order; the second one adds a thousandth. */
        assert_near(slide.length, seen(length, error), 2e-3 * length);
        assert_near(slide.texels, hypot(1000 * error[0], 500 * error[1]), 1e-9);
    }
}

/* An error of a quarter of a texel does not count, and what exceeds it grows from 0. */
static void test_less_than_a_texel(void **state) {
    (void)state;
    const psplat_region region = bowl();
    const double uv[2] = {0, 0}, quarter[2] = {0.25e-3, 0}, more[2] = {0.2501e-3, 0};
    assert_true(psplat_texcoord_slide(&some, &region, uv, texels, quarter).length == 0);
    double length = psplat_texcoord_slide(&some, &region, uv, texels, more).length;
    assert_true(length > 0 && length < 1e-5);
}

/* Along a direction in which coordinates do not change the tenth of the fastest change counts. */
static void test_stretched(void **state) {
    (void)state;
    const psplat_region region = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}};
    const psplat_texcoord line = {.along_u = {0.5f, 0}};
    const psplat_texcoord point = {.at = {0.5f, 0.5f}};
    const double uv[2] = {0, 0}, across[2] = {0, 0.01}, along[2] = {0.01, 0};
    /* Texels of both axes are alike for a length: 500 s and 500 t. */
    const double square[2] = {1000, 1000};
    psplat_slide slide = psplat_texcoord_slide(&line, &region, uv, square, across);
    assert_near(slide.length, 0.01 / 0.05 * (1 - 0.25 / 10), 1e-6);
    slide = psplat_texcoord_slide(&line, &region, uv, square, along);
    assert_near(slide.length, 0.01 / 0.5 * (1 - 0.25 / 10), 1e-6);
    assert_true(psplat_texcoord_slide(&point, &region, uv, square, along).length ==
                2 * region.radius[0]);
    assert_int_equal(psplat_texcoord_sense(&line, uv), 0);
}

static void test_sense(void **state) {
    (void)state;
    const double center[2] = {0, 0}, beyond[2] = {0, 5};
    psplat_texcoord mirrored = some;
    assert_int_equal(psplat_texcoord_sense(&some, center), 1);
    for (int k = 0; k < 2; ++k) mirrored.along_u[k] *= -1;
    assert_int_equal(psplat_texcoord_sense(&mirrored, center), -1);
    const psplat_texcoord turning = {.along_u = {1, 0}, .along_v = {0, 1}, .along_uv = {-0.5f, 0}};
    assert_int_equal(psplat_texcoord_sense(&turning, center), 1);
    assert_int_equal(psplat_texcoord_sense(&turning, beyond), -1); /* s runs back there. */
}

static void test_tolerances(void **state) {
    (void)state;
    const psplat_slide slide = {.length = 0.5, .texels = 2};
    assert_true(psplat_slide_is_kept(&slide, 0.5, 0));
    assert_false(psplat_slide_is_kept(&slide, 0.49, 0));
    assert_true(psplat_slide_is_kept(&slide, 0.1, 2));
    assert_false(psplat_slide_is_kept(&slide, 1, 1.9));
    assert_true(psplat_slide_is_kept(&slide, 0, 0));
}

/* On a triangle on which s changes by 0.5 with x and t by 0.25 with y, an error is a way along
 * both; a direction in which nothing changes counts as a tenth. */
static void test_way_on_a_triangle(void **state) {
    (void)state;
    float slopes[6] = {0.5f, 0, 0, 0, 0.25f, 0};
    const double along[2] = {0.02, 0}, both[2] = {0.03, 0.02}, none[2] = {0, 0};
    assert_near(psplat_texcoord_way(slopes, texels, along), 0.04, 1e-7);
    assert_near(psplat_texcoord_way(slopes, texels, both), 0.1, 1e-7); /* 0.06 by 0.08 */
    assert_near(psplat_texcoord_way(slopes, texels, none), 0, 1e-12);
    slopes[4] = 0; /* 0.01 of t are 5 texels, and s changes by 500 of them a unit. */
    const double across[2] = {0, 0.01};
    assert_near(psplat_texcoord_way(slopes, texels, across), 0.1, 1e-7);
    slopes[0] = 0;
    assert_true(psplat_texcoord_way(slopes, texels, along) == HUGE_VAL);
}

int test_splat_texcoord_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_slide_is_a_distance),
        cmocka_unit_test(test_less_than_a_texel),
        cmocka_unit_test(test_stretched),
        cmocka_unit_test(test_way_on_a_triangle),
        cmocka_unit_test(test_sense),
        cmocka_unit_test(test_tolerances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
