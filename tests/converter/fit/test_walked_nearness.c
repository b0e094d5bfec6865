/* SPDX-License-Identifier: MIT
 *
 * test_walked_nearness.c - the walk over the triangles under a region against branch and bound over
 * all of them: random regions over waves, over a plane with holes, and over steps.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/walked_nearness.h"
#include "measure/splat_distance.h"
#include "mesh/distance.h"

enum { KINDS = 5, TURNS = 60, GRID = 24, COARSE = 3 };

static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

/* Waves; steps that are nearly upright, seen from in front; steps that lean over, so that some
 * triangles turn their backs; and waves of triangles wider than most regions. */
static int kind;
static void place(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0.1 * sin(3 * p[0]) * cos(2 * p[1]);
    if (kind < 2 || kind == 4) return;
    double step = sin(5 * p[0] + 1);
    p[2] = step > 0 ? 0.15 : 0;
    if (kind == 3) p[0] += step > 0 ? 0.2 : 0;
}

/* Removes triangles around three places, so that walks meet borders inside of regions. */
static void make_holes(psplat_mesh *mesh) {
    static const double holes[3][2] = {{0.3, 0.2}, {-0.5, 0.1}, {0.1, -0.6}};
    size_t kept = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const double *p = mesh->positions + 3 * (size_t)mesh->triangles[3 * t];
        int is_left = 1;
        for (int k = 0; k < 3; ++k) {
            double u = p[0] - holes[k][0], v = p[1] - holes[k][1];
            is_left &= u * u + v * v > 0.03;
        }
        if (is_left) memmove(mesh->triangles + 3 * kept++, mesh->triangles + 3 * t, 12);
    }
    mesh->triangle_count = kept;
}

static psplat_region random_region(uint64_t *random) {
    psplat_region r = {.radius = {between(random, 0.1, 1), 0}};
    double turn = between(random, 0, 7), tilt = between(random, -0.2, 0.2);
    r.radius[1] = r.radius[0] * between(random, 0.2, 1);
    r.u[0] = cos(turn) * cos(tilt), r.u[1] = sin(turn) * cos(tilt), r.u[2] = sin(tilt);
    r.v[0] = -sin(turn), r.v[1] = cos(turn);
    cross3(r.n, r.u, r.v);
    for (int k = 0; k < 2; ++k) r.center[k] = between(random, -1, 1);
    r.center[2] = between(random, -0.05, 0.1);
    int is_curved = psplat_random_unit(random) < 0.6;
    for (int k = 0; k < 2; ++k) r.slope[k] = is_curved * between(random, -0.2, 0.2);
    for (int k = 0; k < 3; ++k) r.hessian[k] = is_curved * between(random, -0.8, 0.8);
    r.line_count = (uint32_t)(psplat_random_unit(random) * 4);
    for (uint32_t i = 0; i < r.line_count; ++i) {
        double angle = between(random, 0, 7), length = between(random, 0.5, 2);
        r.lines[i][0] = length * cos(angle), r.lines[i][1] = length * sin(angle);
        r.lines[i][2] = length * between(random, -0.1, 0.8);
        if (psplat_random_unit(random) < 0.5) r.bends[i] = between(random, -1.5, 1.5);
    }
    return r;
}

/* Asserts that a walk finds what branch and bound does, a little below and above the greatest
 * distance, which that finds first. Returns whether the walk could tell. */
static int compare(const psplat_region *region, const psplat_distance *distance,
                   const psplat_distance *cgal) {
    const psplat_splat_distance_desc fine = {.tolerance = 0.01};
    psplat_splat_distance all;
    int is_known = 0, near;
    assert_int_equal(psplat_splat_distance_find(region, cgal, &fine, &all), PSPLAT_OK);
    const double factors[] = {0.5, 0.97, 1.03, 2};
    for (size_t i = 0; i < sizeof factors / sizeof *factors; ++i) {
        double tolerance = factors[i] * (i < 2 ? all.found : all.bound);
        if (!(tolerance > 1e-3)) continue;
        assert_int_equal(psplat_walked_nearness(region, distance, tolerance, &is_known, &near),
                         PSPLAT_OK);
        if (is_known) assert_int_equal(near, factors[i] > 1);
    }
    return is_known;
}

static void test_random_regions(void **state) {
    (void)state;
    uint64_t random = 41;
    for (kind = 0; kind < KINDS; ++kind) {
        fixture f;
        int known = 0;
        uint32_t cells = kind == 4 ? COARSE : GRID;
        fixture_grid(&f, cells, cells, place);
        if (kind == 1) make_holes(&f.mesh);
        fixture_build(&f);
        psplat_distance *distance = psplat_distance_create_connected(&f.mesh, f.surface.neighbors);
        psplat_distance *cgal = psplat_distance_create_cgal(&f.mesh);
        assert_true(distance && cgal);
        for (int turn = 0; turn < TURNS; ++turn) {
            psplat_region region = random_region(&random);
            known += compare(&region, distance, cgal);
        }
        print_message("kind %d: %d of %d known\n", kind, known, TURNS);
        assert_true(known > TURNS / 2);
        psplat_distance_destroy(distance);
        psplat_distance_destroy(cgal);
        fixture_free(&f);
    }
}

/* A disc over a hole that its rim does not touch is as far from the mesh as the hole is wide,
 * though triangles lie under all of its rim and its middle is near one. */
static void place_level(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

static void test_hole(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 40, 40, place_level);
    make_holes(&f.mesh);
    fixture_build(&f);
    psplat_distance *distance = psplat_distance_create_connected(&f.mesh, f.surface.neighbors);
    assert_non_null(distance);
    psplat_region disc = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {0.9, 0.9}};
    int is_known, near;
    for (int wide = 0; wide < 2; ++wide) { /* Holes are some 0.17 to all sides. */
        assert_int_equal(
            psplat_walked_nearness(&disc, distance, wide ? 0.3 : 0.1, &is_known, &near), PSPLAT_OK);
        assert_int_equal(is_known, 1);
        assert_int_equal(near, wide);
    }
    disc.n[2] = -1, disc.v[1] = -1; /* From behind a walk sees nothing. */
    assert_int_equal(psplat_walked_nearness(&disc, distance, 0.1, &is_known, &near), PSPLAT_OK);
    assert_int_equal(is_known, 0);
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

/* A sheet that turns back under itself at x = 1/2. Nothing lies under a disc beyond that. */
static void place_fold(double s, double t, double p[3]) {
    p[0] = s < 0.5 ? 5 * s - 2 : 2 - 3 * s, p[1] = 4 * t - 2, p[2] = s < 0.5 ? 0 : 0.15 - 0.3 * s;
}

static void test_fold(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 20, 20, place_fold);
    fixture_build(&f);
    psplat_distance *distance = psplat_distance_create_connected(&f.mesh, f.surface.neighbors);
    assert_non_null(distance);
    psplat_region disc = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {0.9, 0.9}};
    int is_known, near;
    for (int wide = 0; wide < 2; ++wide) {
        assert_int_equal(
            psplat_walked_nearness(&disc, distance, wide ? 0.41 : 0.39, &is_known, &near),
            PSPLAT_OK);
        assert_int_equal(is_known, 1);
        assert_int_equal(near, wide);
    }
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

/* A wheel of slits whose sides, but for rounding, meet in its middle. */
enum { SLITS = 76, RINGS = 4 };

static void place_slits(double s, double t, double p[3]) {
    double angle = 2 * 3.14159265358979323846 * s * (1 - 0.5 / SLITS);
    p[0] = (0.1 + t) * cos(angle), p[1] = (0.1 + t) * sin(angle), p[2] = 0;
}

/* The walls along slits divide a disc into so many cells that branch and bound is left with the
 * rest. */
static void test_slits(void **state) {
    (void)state;
    fixture f;
    size_t kept = 0;
    int known = 0;
    fixture_grid(&f, 2 * SLITS, RINGS, place_slits);
    for (size_t t = 0; t < f.mesh.triangle_count; ++t) { /* Odd sectors stay outside alone. */
        double middle[3] = {0};
        for (int k = 0; k < 3; ++k)
            for (int c = 0; c < 3; ++c)
                middle[c] +=
                    f.mesh.positions[3 * (size_t)f.mesh.triangles[3 * t + (size_t)k] + (size_t)c] /
                    3;
        double turn = atan2(middle[1], middle[0]) / (2 * 3.14159265358979323846);
        int sector = (int)floor((turn < 0 ? turn + 1 : turn) / (1 - 0.5 / SLITS) * 2 * SLITS);
        if (sector % 2 && length3(middle) < 0.8) continue;
        memmove(f.mesh.triangles + 3 * kept++, f.mesh.triangles + 3 * t, 12);
    }
    f.mesh.triangle_count = kept;
    fixture_build(&f);
    psplat_distance *distance = psplat_distance_create_connected(&f.mesh, f.surface.neighbors);
    assert_non_null(distance);
    for (int turn = 0; turn < 24; ++turn) {
        psplat_region disc = {
            .u = {1, 0, 0}, .v = {0, -1, 0}, .n = {0, 0, -1}, .radius = {0.9, 0.9}};
        disc.center[0] = 0.15 * cos(turn), disc.center[1] = 0.15 * sin(turn);
        for (int wide = 0; wide < 2; ++wide) { /* The middle is 0.1 from where the slits begin. */
            int is_known, near;
            assert_int_equal(
                psplat_walked_nearness(&disc, distance, wide ? 0.11 : 0.09, &is_known, &near),
                PSPLAT_OK);
            known += is_known;
            assert_int_equal(near, is_known && wide);
        }
    }
    assert_true(known >= 8); /* A walk from the edge of a slit cannot tell. */
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

int test_walked_nearness_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_regions),
        cmocka_unit_test(test_hole),
        cmocka_unit_test(test_fold),
        cmocka_unit_test(test_slits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
