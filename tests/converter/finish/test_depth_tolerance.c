/* SPDX-License-Identifier: MIT
 *
 * test_depth_tolerance.c - tests of the depth tolerance: twice the greatest deviation, half of that
 * where it reaches another layer beneath, and never less than a quarter of the tolerance; and of
 * which splats are flat.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "layers_fixture.h"
#include "fit/candidate.h"
#include "select/conversion.h"
#include "finish/depth_tolerance.h"

/* Returns a disc that faces up. */
static psplat_candidate disc_at(double x, double y, double z, double radius, double deviation) {
    return (psplat_candidate){.region = {.center = {x, y, z},
                                         .u = {1, 0, 0},
                                         .v = {0, 1, 0},
                                         .n = {0, 0, 1},
                                         .radius = {radius, radius}},
                              .taken = 1,
                              .deviation = deviation};
}

/* Chooses which of two discs on a surface are flat. */
static void choose(const fixture *f, double tolerance, psplat_candidate discs[2]) {
    psplat_conversion c = {.surface = f->surface,
                           .samples = f->samples,
                           .distance = f->distance,
                           .tolerance = tolerance,
                           .selection = {.candidates = discs, .count = 2}};
    float depth, flat_depth;
    assert_int_equal(psplat_depth_tolerances_choose(&c, &depth, &flat_depth), PSPLAT_OK);
}

/* Returns the depth tolerance where splats of a sheet in two layers deviate so far. */
static double depth_of(const fixture *f, double tolerance, double deviation) {
    psplat_candidate candidates[2] = {disc_at(0.3, 0.5, 0, 0.1, deviation / 2),
                                      disc_at(0.7, 0.5, 0, 0.1, deviation)};
    psplat_conversion c = {.surface = f->surface,
                           .samples = f->samples,
                           .distance = f->distance,
                           .tolerance = tolerance,
                           .selection = {.candidates = candidates, .count = 2}};
    float depth, flat_depth;
    assert_int_equal(psplat_depth_tolerances_choose(&c, &depth, &flat_depth), PSPLAT_OK);
    assert_near((double)flat_depth, 0.2 * tolerance, 1e-6 * tolerance);
    return (double)depth;
}

static void test_layers(void **state) {
    (void)state;
    fixture f;
    fixture_layers(&f);
    const double rounding = 1e-6 * layer_height;
    /* 0.9 of the distance of the layers does not reach the lower one, and 1.1 does. */
    assert_near(depth_of(&f, layer_height, 0.45 * layer_height), 0.9 * layer_height, rounding);
    assert_near(depth_of(&f, layer_height, 0.55 * layer_height), 0.55 * layer_height, rounding);
    assert_near(depth_of(&f, layer_height, 0.1 * layer_height), 0.25 * layer_height, rounding);
    fixture_free(&f);
}

/* A disc that is a twentieth of the tolerance off its face is flat unless a curved one comes within
 * the tolerance of its rim. None that is a seventh off is flat, and each that is a hundredth off
 * is.
 */
static void test_beside_curved(void **state) {
    (void)state;
    const struct {
        double deviation, gap; /* in tolerances; the gap between the rims */
        int is_flat;
    } cases[] = {{0.05, 1.2, 1}, {0.05, 0.8, 0}, {0.15, 1.2, 0}, {0.01, 0.8, 1}, {0.05, -2, 0}};
    const double tolerance = layer_height / 10, radius = 0.1;
    fixture f;
    fixture_layers(&f);
    for (int i = 0; i < 5; ++i)
        for (int is_other_curved = 0; is_other_curved < 2; ++is_other_curved) {
            double x = 0.3 + 2 * radius + cases[i].gap * tolerance;
            psplat_candidate discs[2] = {
                disc_at(0.3, 0.5, 0, radius, cases[i].deviation * tolerance),
                disc_at(x, 0.5, 0, radius, 0.05 * tolerance)};
            discs[1].region.hessian[0] = is_other_curved ? 0.1 : 0;
            choose(&f, tolerance, discs);
            int is_level = cases[i].deviation < 0.1;
            assert_int_equal(discs[0].is_flat, is_other_curved ? cases[i].is_flat : is_level);
            if (is_other_curved) assert_int_equal(discs[1].is_flat, 0);
        }
    fixture_free(&f);
}

/* What lies within a large disc, far from its middle and its rim, is beside it as well, and the
 * other way round. */
static void test_within(void **state) {
    (void)state;
    const double tolerance = layer_height / 10;
    fixture f;
    fixture_layers(&f);
    for (int is_inner_curved = 0; is_inner_curved < 2; ++is_inner_curved) {
        psplat_candidate discs[2] = {disc_at(0.5, 0.5, 0, 0.2, 0.05 * tolerance),
                                     disc_at(0.58, 0.5, 0, 0.01, 0.05 * tolerance)};
        discs[is_inner_curved].region.hessian[0] = 0.1;
        choose(&f, tolerance, discs);
        assert_int_equal(discs[!is_inner_curved].is_flat, 0);
    }
    fixture_free(&f);
}

/* A disc beside a curved one is flat if it hides the other layer within the depth tolerance, which
 * is half of twice the greatest deviation, as layers lie so near. */
static void test_over_layer(void **state) {
    (void)state;
    const double tolerance = layer_height / 1.5;
    fixture f;
    fixture_layers(&f);
    for (int is_upper = 0; is_upper < 2; ++is_upper)
        for (int is_deep = 0; is_deep < 2; ++is_deep) {
            double z = is_upper ? layer_height : 0, deviation = is_deep ? 1.05 : 0.95;
            psplat_candidate discs[2] = {disc_at(0.3, 0.5, z, 0.1, 0.05 * tolerance),
                                         disc_at(0.45, 0.5, z, 0.1, deviation * layer_height)};
            discs[1].region.hessian[0] = 0.1;
            choose(&f, tolerance, discs);
            assert_int_equal(discs[0].is_flat, is_upper && is_deep);
        }
    fixture_free(&f);
}

/* A floor, and a wall over it that leans to the right by 60 degrees and faces up to the left. */
static void place_wall(double s, double t, double p[3]) {
    const double foot = 0.01, slope[2] = {0.5, sqrt(0.75)};
    int column = (int)lrint(s * LAYERS_CELLS), is_wall = column > 4;
    double along = column % 5 / 4.0;
    p[0] = is_wall ? 0.3 + slope[0] * along : along, p[1] = t;
    p[2] = is_wall ? foot + slope[1] * along : 0;
}

/* From a disc 1.4 depths over the floor, a ray straight through the wall has 2.8 depths to go
 * there, and the steepest one 1.4, of which it may go 2. From one at four depths none gets there.
 * The depth is the greatest deviation: enough of the wall lies that close over the floor. */
static void test_over_corner(void **state) {
    (void)state;
    const double depth = 0.06, tolerance = 0.04, radius = 0.02, along = 0.085;
    fixture f;
    fixture_grid(&f, LAYERS_CELLS, LAYERS_CELLS, place_wall);
    fixture_build(&f);
    fixture_sample(&f, 0.05);
    for (int is_high = 0; is_high < 2; ++is_high) {
        double at = along + is_high * 0.18, c = 0.5, s = sqrt(0.75);
        psplat_candidate discs[2] = {
            disc_at(0.3 + c * at, 0.5, 0.01 + s * at, radius, 0.05 * tolerance),
            disc_at(0.3 + c * at, 0.55, 0.01 + s * at, radius, depth)};
        for (int i = 0; i < 2; ++i) {
            psplat_region *region = &discs[i].region;
            const double u[3] = {c, 0, s}, n[3] = {-s, 0, c};
            memcpy(region->u, u, sizeof u);
            memcpy(region->n, n, sizeof n);
        }
        discs[1].region.hessian[0] = 0.1;
        choose(&f, tolerance, discs);
        assert_int_equal(discs[0].is_flat, !is_high);
    }
    fixture_free(&f);
}

int test_depth_tolerance_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers), cmocka_unit_test(test_beside_curved),
        cmocka_unit_test(test_within), cmocka_unit_test(test_over_layer),
        cmocka_unit_test(test_over_corner)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
