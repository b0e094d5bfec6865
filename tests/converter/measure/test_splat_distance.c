/* SPDX-License-Identifier: MIT
 *
 * test_splat_distance.c - tests of the greatest distance from all points of a splat to a mesh:
 * places of which it is known, and dense points of random regions over random meshes.
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
#include "measure/splat_distance.h"
#include "mesh/distance.h"

/* How far the bound may exceed the greatest distance found, as the header promises, with room for
 * rounding. */
static const double slack = 1.01 * (1 + 1e-9);

static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

static psplat_region level_region(double ru, double rv) {
    return (psplat_region){.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {ru, rv}};
}

/* Two triangles of the plane z = 0, far wider than the regions. */
static void place_on_plane(double s, double t, double p[3]) {
    p[0] = 20 * s - 10, p[1] = 20 * t - 10, p[2] = 0;
}

static psplat_distance *grid_distance(uint32_t columns, uint32_t rows,
                                      void (*place)(double s, double t, double p[3])) {
    fixture f;
    fixture_grid(&f, columns, rows, place);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    fixture_free(&f);
    return distance;
}

static double distance_at(const psplat_distance *distance, const double point[3]) {
    double result;
    assert_int_equal(psplat_distance_query(distance, point, 1, &result), PSPLAT_OK);
    return result;
}

/* Searches, and asserts what holds of every result: the point found lies on the region and is as
 * far away as stated, and the bound is where it may be. */
static psplat_splat_distance find(const psplat_region *region, const psplat_distance *distance,
                                  double tolerance, int stop_at_first) {
    const psplat_splat_distance_desc desc = {.tolerance = tolerance,
                                             .stop_at_first = stop_at_first};
    psplat_splat_distance r;
    double uvh[3];
    assert_int_equal(psplat_splat_distance_find(region, distance, &desc, &r), PSPLAT_OK);
    assert_int_equal(r.nearness == PSPLAT_NEARNESS_EXCEEDS, r.found > tolerance);
    if (r.nearness == PSPLAT_NEARNESS_WITHIN) assert_true(r.bound <= tolerance);
    assert_true(r.bound >= r.found);
    if (!(r.found > 0)) return r;
    psplat_region_local(region, r.point, uvh);
    assert_near(uvh[2], 0, 1e-9); /* roundings of coordinates of some units */
    assert_true(psplat_region_contains(region, uvh, 1 + 2e-8, 2e-8));
    assert_near(distance_at(distance, r.point), r.found, 1e-9);
    return r;
}

/* Asserts that the search finds a greatest distance that is known, and proves it, whatever it is
 * asked for. */
static void assert_greatest(const psplat_region *region, const psplat_distance *distance,
                            double known) {
    psplat_splat_distance r = find(region, distance, 0.3 * known, 0);
    assert_int_equal(r.nearness, PSPLAT_NEARNESS_EXCEEDS);
    assert_true(r.found <= known * (1 + 1e-9) && r.bound >= known * (1 - 1e-9));
    assert_true(r.bound <= r.found * slack);
    /* A part in a hundred more is proven, and a part less is refuted at once. */
    assert_int_equal(find(region, distance, 1.01 * known, 0).nearness, PSPLAT_NEARNESS_WITHIN);
    assert_int_equal(find(region, distance, 0.99 * known, 1).nearness, PSPLAT_NEARNESS_EXCEEDS);
}

/* ---- known places --------------------------------------------------------------------------- */

/* A plane with a pit, a pyramid on its head. It is 1 / 20 wide and lies between the points at which
 * a disc of radius 1 was measured before: these are about a sixth apart. */
enum { PIT_GRID = 160 };
static const double pit[2] = {0.3, -0.2};
static void place_with_pit(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2;
    p[2] = hypot(p[0] - pit[0], p[1] - pit[1]) < 0.3 / PIT_GRID ? -1 : 0;
}

static void test_pit_between_points(void **state) {
    (void)state;
    psplat_distance *distance = grid_distance(PIT_GRID, PIT_GRID, place_with_pit);
    psplat_region disc = level_region(1, 1);
    double points[PSPLAT_REGION_POINTS][3], distances[PSPLAT_REGION_POINTS], greatest = 0;
    size_t count = psplat_region_points(&disc, points);
    assert_int_equal(psplat_distance_query(distance, points[0], count, distances), PSPLAT_OK);
    for (size_t i = 0; i < count; ++i) greatest = max2(greatest, distances[i]);
    assert_true(greatest < 1e-9); /* These points see nothing. */
    /* Over the pit, the rim is nearer than its floor. Its deepest point is as far as the largest
     * circle within the rim, a hexagon of two sides of a square and its diagonals, is wide; walls
     * that are 40 times as steep as wide take away less than 3 parts in a hundred. */
    double side = 4.0 / PIT_GRID, wide = side / sqrt(2);
    psplat_splat_distance r = find(&disc, distance, 0.5 * wide, 0);
    assert_int_equal(r.nearness, PSPLAT_NEARNESS_EXCEEDS);
    assert_in_range((unsigned)(1000 * r.found / wide), 970, 1000);
    assert_true(hypot(r.point[0] - pit[0], r.point[1] - pit[1]) < side);
    assert_true(r.bound <= r.found * slack);
    assert_int_equal(find(&disc, distance, 1.02 * wide, 0).nearness, PSPLAT_NEARNESS_WITHIN);
    psplat_distance_destroy(distance);
}

/* Over a plane, the distance is the height. That of a dome is greatest at its top, that of a saddle
 * at its rim, and that of a slope at the ends of the ellipse. */
static void test_heights_over_a_plane(void **state) {
    (void)state;
    psplat_distance *distance = grid_distance(1, 1, place_on_plane);
    psplat_region dome = level_region(1, 0.7);
    dome.slope[0] = 0.2, dome.slope[1] = -0.1;
    dome.hessian[0] = -0.5, dome.hessian[1] = 0.1, dome.hessian[2] = -0.6;
    dome.center[2] = 0.5;
    /* The top is at (s, t) with hessian (s, t) = -slope, which lies within the ellipse. */
    double det = 0.5 * 0.6 - 0.1 * 0.1, s = (0.2 * 0.6 - 0.1 * 0.1) / det,
           t = (-0.1 * 0.5 + 0.1 * 0.2) / det;
    assert_greatest(&dome, distance, 0.5 + (0.2 * s - 0.1 * t) / 2);
    psplat_region saddle = level_region(1, 0.5);
    saddle.hessian[0] = 0.4, saddle.hessian[2] = -0.9;
    assert_greatest(&saddle, distance, 0.2);
    psplat_region slope = level_region(2, 1);
    slope.slope[0] = 0.3, slope.slope[1] = 0.4;
    assert_greatest(&slope, distance, hypot(0.6, 0.4));
    /* A tilted flat one, too. */
    psplat_region tilted = level_region(2, 1);
    tilted.u[0] = 0.8, tilted.u[2] = 0.6, tilted.n[0] = -0.6, tilted.n[2] = 0.8;
    assert_greatest(&tilted, distance, 1.2);
    psplat_distance_destroy(distance);
}

/* A slope along u, cut at u = 1/2 or by parabolas through it, is highest where line and ellipse
 * meet, or at the line's vertex where that bulges out. */
static void test_ends_of_lines(void **state) {
    (void)state;
    psplat_distance *distance = grid_distance(1, 1, place_on_plane);
    /* u = 1/2 + v^2 / 4 meets the circle where u^2 + 4 u - 3 = 0. */
    const struct {
        double bend, highest;
    } cases[] = {{0, 0.5}, {0.5, sqrt(7) - 2}, {-0.5, 0.5}, {-4, 0.5}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (int curved = 0; curved < 2; ++curved) {
            psplat_region r = level_region(2, 1.5);
            const double line[3] = {-1, 0, 0.5};
            r.line_count = 1;
            memcpy(r.lines[0], line, sizeof line);
            r.bends[0] = cases[i].bend;
            /* Lifted so that the low end is nearer; curved along v, but by little. */
            r.center[2] = 2, r.slope[0] = 0.25, r.hessian[2] = curved ? -1e-4 : 0;
            double known = 2 + 0.5 * cases[i].highest, end = sqrt(1 - pow(cases[i].highest, 2));
            if (curved && cases[i].bend > 0) known -= 0.5e-4 * pow(1.5 * end, 2);
            assert_greatest(&r, distance, known);
            /* Without the line it is farther: the line does cut. */
            r.line_count = 0;
            assert_true(find(&r, distance, known, 1).nearness == PSPLAT_NEARNESS_EXCEEDS);
        }
    psplat_distance_destroy(distance);
}

/* ---- dense points --------------------------------------------------------------------------- */

/* A surface of waves, whose number and height a seed decides. */
static double waves[3];
static void place_on_waves(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2;
    p[2] = waves[0] * sin(waves[1] * p[0]) * cos(waves[2] * p[1]);
}

static psplat_region random_region(uint64_t *random) {
    psplat_region r = level_region(1, between(random, 0.2, 1));
    double turn = between(random, 0, 3), tilt = between(random, -0.2, 0.2);
    r.u[0] = cos(turn) * cos(tilt), r.u[1] = sin(turn) * cos(tilt), r.u[2] = sin(tilt);
    r.v[0] = -sin(turn), r.v[1] = cos(turn), r.v[2] = 0;
    cross3(r.n, r.u, r.v);
    for (int k = 0; k < 3; ++k) r.center[k] = between(random, -0.2, 0.2);
    double steep = psplat_random_unit(random) < 0.3 ? 0 : 1;
    for (int k = 0; k < 2; ++k) r.slope[k] = steep * between(random, -0.3, 0.3);
    for (int k = 0; k < 3; ++k) r.hessian[k] = steep * between(random, -0.8, 0.8);
    r.line_count = (uint32_t)(psplat_random_unit(random) * 5);
    for (uint32_t i = 0; i < r.line_count; ++i) {
        double angle = between(random, 0, 7), length = between(random, 0.5, 2);
        r.lines[i][0] = length * cos(angle), r.lines[i][1] = length * sin(angle);
        r.lines[i][2] = length * between(random, -0.2, 0.8);
        if (psplat_random_unit(random) < 0.6) r.bends[i] = between(random, -2, 2);
    }
    return r;
}

/* Returns the greatest distance of dense points, negative where the lines leave none of them. */
enum { DENSE = 40 };
static double dense_greatest(const psplat_region *region, const psplat_distance *distance) {
    double greatest = -1;
    for (int i = -DENSE; i <= DENSE; ++i)
        for (int k = -DENSE; k <= DENSE; ++k) {
            const double uv[2] = {(double)i / DENSE, (double)k / DENSE};
            double point[3];
            if (!psplat_region_contains(region, uv, 1, 0)) continue;
            psplat_region_point(region, uv, point);
            greatest = max2(greatest, distance_at(distance, point));
        }
    return greatest;
}

static void test_random_regions(void **state) {
    (void)state;
    uint64_t random = 77;
    int exceeding = 0, within = 0;
    for (int turn = 0; turn < 40; ++turn) {
        const double drawn[3] = {between(&random, 0, 0.15), between(&random, 1, 9),
                                 between(&random, 1, 9)};
        memcpy(waves, drawn, sizeof waves);
        uint32_t cells = 2 + (uint32_t)(psplat_random_unit(&random) * 40);
        psplat_distance *distance = grid_distance(cells, cells, place_on_waves);
        psplat_region region = random_region(&random);
        double dense = dense_greatest(&region, distance);
        if (dense > 0) {
            const double factors[] = {0.4, 0.8, 0.98, 1.1};
            for (size_t i = 0; i < sizeof factors / sizeof *factors; ++i) {
                psplat_splat_distance r = find(&region, distance, factors[i] * dense, 0);
                assert_true(r.bound >= dense * (1 - 1e-9));
                assert_true(r.bound <= max2(r.found * slack, factors[i] * dense));
                exceeding += r.nearness == PSPLAT_NEARNESS_EXCEEDS;
                within += r.nearness == PSPLAT_NEARNESS_WITHIN;
                /* Points a fortieth of a radius apart lie on slopes of less than 3. */
                if (factors[i] < 1) assert_int_equal(r.nearness, PSPLAT_NEARNESS_EXCEEDS);
            }
        }
        psplat_distance_destroy(distance);
    }
    assert_true(exceeding > 80 && within > 20);
}

/* ---- limits --------------------------------------------------------------------------------- */

static void test_nothing_left(void **state) {
    (void)state;
    psplat_distance *distance = grid_distance(1, 1, place_on_plane);
    psplat_region region = level_region(1, 1);
    const double line[3] = {1, 0, -1.5};
    region.center[2] = 5, region.line_count = 1;
    memcpy(region.lines[0], line, sizeof line);
    psplat_splat_distance r = find(&region, distance, 0.1, 0);
    assert_int_equal(r.nearness, PSPLAT_NEARNESS_WITHIN);
    assert_true(r.bound == 0 && r.found == 0);
    psplat_distance_destroy(distance);
}

/* A search that may look at a few cells only gives a bound that holds, and no proof. */
static void test_given_up(void **state) {
    (void)state;
    waves[0] = 0.1, waves[1] = 7, waves[2] = 8;
    psplat_distance *distance = grid_distance(40, 40, place_on_waves);
    psplat_region region = level_region(1, 1);
    double dense = dense_greatest(&region, distance);
    const psplat_splat_distance_desc desc = {.tolerance = 1.1 * dense, .most_cells = 3};
    psplat_splat_distance r;
    assert_int_equal(psplat_splat_distance_find(&region, distance, &desc, &r), PSPLAT_OK);
    assert_int_equal(r.nearness, PSPLAT_NEARNESS_UNDECIDED);
    assert_true(r.bound > 1.1 * dense && r.found <= dense * 1.1);
    assert_int_equal(find(&region, distance, 1.1 * dense, 0).nearness, PSPLAT_NEARNESS_WITHIN);
    psplat_distance_destroy(distance);
}

int test_splat_distance_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pit_between_points), cmocka_unit_test(test_heights_over_a_plane),
        cmocka_unit_test(test_ends_of_lines),      cmocka_unit_test(test_random_regions),
        cmocka_unit_test(test_nothing_left),       cmocka_unit_test(test_given_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
