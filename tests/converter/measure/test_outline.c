/* SPDX-License-Identifier: MIT
 *
 * test_outline.c - tests the outline error (spec 3.13) on a polygon of 200 sides under one round
 * splat, whose areas in each view are known: both shrink by the same cosine. Lengths are for a
 * polygon of radius 1, of which a cell of the grid is 1/128.
 */
#include "measure/outline.h"
#include "mesh/mesh.h"
#include "splats/splats.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

enum { SIDES = 200, DIRECTIONS = 12 };
static const double pi = 3.14159265358979323846;

typedef struct disc {
    double positions[3 * (SIDES + 1)];
    uint32_t triangles[3 * SIDES];
    psplat_mesh mesh;
} disc;

static void make_disc(disc *d, double radius) {
    *d = (disc){.positions = {0}};
    for (uint32_t i = 0; i < SIDES; ++i) {
        double angle = 2 * pi * i / SIDES;
        d->positions[3 * (i + 1)] = radius * cos(angle);
        d->positions[3 * (i + 1) + 1] = radius * sin(angle);
        d->triangles[3 * i] = 0;
        d->triangles[3 * i + 1] = i + 1;
        d->triangles[3 * i + 2] = (i + 1) % SIDES + 1;
    }
    d->mesh = (psplat_mesh){.positions = d->positions,
                            .vertex_count = SIDES + 1,
                            .triangles = d->triangles,
                            .triangle_count = SIDES};
}

static psplat_splat round_splat(double radius) {
    return (psplat_splat){
        .normal = {0, 0, 1}, .rotation = {0, 0, 0, 1}, .radius = {(float)radius, (float)radius}};
}

static double measure(const disc *d, psplat_splat *splat) {
    const psplat_splats splats = {.splats = splat, .count = 1};
    psplat_error error = {0};
    double outline = -1;
    assert_int_equal(psplat_outline_measure(&d->mesh, &splats, &outline, &error), PSPLAT_OK);
    return outline;
}

/* Returns the mean of the root of the cosines of the directions, which are evenly spread. */
static double mean_root_cosine(void) {
    double sum = 0;
    for (int i = 0; i < DIRECTIONS; ++i) sum += sqrt((i + 0.5) / DIRECTIONS) / DIRECTIONS;
    return sum;
}

/* Of circles of radius 1 and r, |1 - r^2| pi c lies between both where the first has pi c. The
 * tolerance is a third of a cell. */
static void test_larger_and_smaller(void **state) {
    (void)state;
    static const double radii[] = {0.8, 0.95, 1.05, 1.2, 1.4};
    disc d;
    make_disc(&d, 1);
    for (size_t i = 0; i < sizeof radii / sizeof *radii; ++i) {
        psplat_splat splat = round_splat(radii[i]);
        double expected = fabs(1 - radii[i] * radii[i]) * sqrt(pi) / 4 * mean_root_cosine();
        assert_float_equal(measure(&d, &splat), expected, 1.0 / 384);
    }
}

/* Equal outlines differ by what the grid and 200 sides leave: a twentieth of a cell. */
static void test_equal(void **state) {
    (void)state;
    disc d;
    make_disc(&d, 1);
    psplat_splat splat = round_splat(1);
    assert_true(measure(&d, &splat) < 0.05 / 128 + 1e-3);
}

/* A line cuts half of the splat off, and nothing of it shows. */
static void test_half(void **state) {
    (void)state;
    disc d;
    make_disc(&d, 1);
    psplat_splat splat = round_splat(1);
    splat.clip_count = 1;
    splat.clip[0][0] = 1;
    double expected = 0.5 * sqrt(pi) / 4 * mean_root_cosine();
    assert_float_equal(measure(&d, &splat), expected, 1.0 / 384);
}

/* The error is a length: it grows with both, and is the same wherever they are. */
static void test_units(void **state) {
    (void)state;
    disc d;
    make_disc(&d, 1000);
    psplat_splat splat = round_splat(1100);
    double expected = 1000 * 0.21 * sqrt(pi) / 4 * mean_root_cosine();
    assert_float_equal(measure(&d, &splat), expected, 1000.0 / 384);
    for (size_t i = 0; i < 3 * (SIDES + 1); i += 3) d.positions[i] += 5e4;
    splat.center[0] += 5e4f;
    assert_float_equal(measure(&d, &splat), expected, 1000.0 / 384);
}

/* A mesh that is a point, and splats that are elsewhere: then half a cell that the grid adds to one
 * outline it adds to no other. */
static void test_extremes(void **state) {
    (void)state;
    disc d;
    make_disc(&d, 0);
    psplat_splat splat = round_splat(1);
    assert_true(measure(&d, &splat) == 0);
    make_disc(&d, 1);
    splat.center[0] = 1e9f;
    double expected = sqrt(pi) / 4 * mean_root_cosine();
    assert_float_equal(measure(&d, &splat), expected, 1.0 / 256);
}

int test_outline_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_larger_and_smaller),
        cmocka_unit_test(test_equal),
        cmocka_unit_test(test_half),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_extremes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
