/* SPDX-License-Identifier: MIT
 *
 * test_region.c - tests of regions (ellipses cut by clip lines): which points they contain, their
 * outlines and areas, points spread over them, and whether they are near a mesh. Expected values
 * are exact areas and distances.
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
#include "fit/region_near.h"
#include "mesh/distance.h"

static psplat_region level_region(double x, double y, double z, double ru, double rv) {
    return (psplat_region){
        .center = {x, y, z}, .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {ru, rv}};
}

/* ---- outlines -------------------------------------------------------------------------------- */

static double area_of(double (*polygon)[2], size_t count) {
    double twice = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[(i + 1) % count];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return twice / 2;
}

static void test_polygon(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 2, 1);
    double polygon[68][2];
    for (int inscribed = 0; inscribed < 2; ++inscribed) {
        size_t count = psplat_region_polygon(&r, inscribed, polygon, 68);
        assert_int_equal(count, 64);
        double angle = fixture_pi / 64;
        double area = 64 * (inscribed ? sin(angle) * cos(angle) : tan(angle));
        assert_near(area_of(polygon, count), area, 1e-12);
    }
    r.line_count = 2; /* a quarter of the ellipse */
    r.lines[0][0] = 1, r.lines[1][1] = 1;
    size_t count = psplat_region_polygon(&r, 1, polygon, 68);
    assert_near(area_of(polygon, count), 8 * sin(fixture_pi / 32), 1e-12);
    r.lines[1][2] = -1.5; /* nothing is left */
    assert_int_equal(psplat_region_polygon(&r, 0, polygon, 68), 0);
}

/* Areas of a whole ellipse, a half, a quarter, a thin strip, a square cut by four lines, and
 * nothing. The outline has 64 sides, and the area of that polygon is exact. */
static void test_area(void **state) {
    (void)state;
    uint64_t random = 14;
    for (int turn = 0; turn < 20; ++turn) {
        psplat_region r = level_region(1e3, -2e3, 5e2, 3, 0.5); /* The place does not matter. */
        random_axes(&random, r.u, r.v, r.n);
        double whole = 32 * sin(fixture_pi / 32) * 3 * 0.5;
        assert_near(psplat_region_area(&r), whole, 1e-12);
        assert_near(psplat_region_area(&r), fixture_pi * 1.5, 0.002 * fixture_pi * 1.5);
        double angle = fixture_pi / 32 * turn; /* The line goes through corners of the outline. */
        r.line_count = 1;
        r.lines[0][0] = -sin(angle), r.lines[0][1] = cos(angle);
        assert_near(psplat_region_area(&r), whole / 2, 1e-12);
        r.line_count = 2;
        r.lines[1][0] = cos(angle), r.lines[1][1] = sin(angle);
        assert_near(psplat_region_area(&r), whole / 4, 1e-12);
        r.lines[1][0] = sin(angle), r.lines[1][1] = -cos(angle), r.lines[1][2] = 0.01;
        /* Between corners the chord at 0.01 is shorter than 2 by 0.01^2 and by the polygon's
         * distance from the ellipse. */
        assert_near(psplat_region_area(&r), 2 * 0.01 * 1.5, 2e-3 * 0.03);
        r.lines[1][2] = -0.01; /* No point is on the inner side of both lines. */
        assert_near(psplat_region_area(&r), 0, 1e-15);
        r.line_count = 4;
        for (int i = 0; i < 4; ++i) {
            double side = angle + fixture_pi / 2 * i;
            r.lines[i][0] = cos(side), r.lines[i][1] = sin(side), r.lines[i][2] = 0.7;
        }
        assert_near(psplat_region_area(&r), 1.4 * 1.4 * 1.5, 1e-12);
    }
}

/* ---- points ---------------------------------------------------------------------------------- */

/* Returns a region anywhere in space, cut by lines that keep its centre. */
static psplat_region random_region(uint64_t *random, uint32_t line_count) {
    psplat_region r = {.radius = {2, 0.5}, .line_count = line_count};
    random_axes(random, r.u, r.v, r.n);
    for (int k = 0; k < 3; ++k) r.center[k] = 10 * psplat_random_unit(random);
    for (uint32_t i = 0; i < line_count; ++i) {
        double angle = 2 * fixture_pi * psplat_random_unit(random);
        r.lines[i][0] = cos(angle), r.lines[i][1] = sin(angle);
        r.lines[i][2] = 0.1 + psplat_random_unit(random);
    }
    return r;
}

static void test_local(void **state) {
    (void)state;
    uint64_t random = 6;
    for (int i = 0; i < 20; ++i) {
        psplat_region r = random_region(&random, 0);
        double p[3], uvh[3], u = psplat_random_unit(&random), v = -psplat_random_unit(&random);
        region_point(&r, u, v, 0.3, p);
        psplat_region_local(&r, p, uvh);
        /* Rounding of coordinates of 10 over a radius of a half. */
        assert_near(uvh[0], u, 1e-14);
        assert_near(uvh[1], v, 2e-14);
        assert_near(uvh[2], 0.3, 1e-14);
    }
}

static void test_contains(void **state) {
    (void)state;
    psplat_region r = level_region(0, 0, 0, 2, 1);
    r.line_count = 1; /* keeps u <= 0.5 */
    r.lines[0][0] = -1, r.lines[0][2] = 0.5;
    const struct {
        double uv[2], scale, slack;
        int inside;
    } cases[] = {
        {{0, 0}, 1, 0, 1},       {{0.5, 0}, 1, 0, 1},      {{0.51, 0}, 1, 0, 0},
        {{0.51, 0}, 1, 0.02, 1}, {{0, 1}, 1, 0, 1},        {{0, 1.01}, 1, 0.02, 0},
        {{0, 1.01}, 1.02, 0, 1}, {{-0.8, -0.61}, 1, 0, 0}, {{0, 0.6}, 0.5, 0, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_int_equal(psplat_region_contains(&r, cases[i].uv, cases[i].scale, cases[i].slack) !=
                             0,
                         cases[i].inside);
}

/* Points lie in the region's plane and inside it. Some of them lie all along its outline, and one
 * is in the middle of what the lines leave, so that no gap is wider than half of the outline. */
static void test_points(void **state) {
    (void)state;
    uint64_t random = 12;
    for (uint32_t i = 0; i < 25; ++i) {
        psplat_region r = random_region(&random, i % (PSPLAT_MAX_CLIP_LINES + 1));
        double points[PSPLAT_REGION_POINTS][3], polygon[68][2];
        size_t count = psplat_region_points(&r, points);
        size_t corners = psplat_region_polygon(&r, 1, polygon, 68), met = 0;
        assert_true(count > corners && count <= PSPLAT_REGION_POINTS);
        for (size_t k = 0; k < count; ++k) {
            double uvh[3];
            psplat_region_local(&r, points[k], uvh);
            assert_near(uvh[2], 0, 1e-14); /* rounding of coordinates of 10 */
            assert_true(psplat_region_contains(&r, uvh, 1 + 1e-12, 1e-12));
            for (size_t c = 0; c < corners; ++c)
                met += hypot(uvh[0] - polygon[c][0], uvh[1] - polygon[c][1]) < 1e-12;
        }
        assert_true(met >= corners);
        double middle[3], uvh[3], mean[2] = {0, 0};
        memcpy(middle, points[count - 1], sizeof middle);
        psplat_region_local(&r, middle, uvh);
        for (size_t c = 0; c < corners; ++c)
            for (int k = 0; k < 2; ++k) mean[k] += polygon[c][k] / (double)corners;
        assert_near(hypot(uvh[0] - mean[0], uvh[1] - mean[1]), 0, 1e-12);
    }
    psplat_region r = level_region(0, 0, 0, 1, 1); /* Nothing is left of this region. */
    double points[PSPLAT_REGION_POINTS][3];
    r.line_count = 1;
    r.lines[0][0] = 1, r.lines[0][2] = -1.5;
    assert_int_equal(psplat_region_points(&r, points), 0);
}

/* Whether points are within a distance must agree with their distances, near the mesh and far from
 * it, and also at the distance itself up to rounding. */
static void place_bump(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0.3 * sin(5 * s) * cos(7 * t);
}

static int within(const psplat_distance *distance, const double *points, size_t count, double far) {
    int result = -1;
    assert_int_equal(psplat_distance_within(distance, points, count, far, &result), PSPLAT_OK);
    assert_in_range(result, 0, 1);
    return result;
}

static void test_within(void **state) {
    (void)state;
    enum { POINTS = 500 };
    fixture f;
    uint64_t random = 77;
    double points[3 * POINTS], far[POINTS], farthest = 0;
    fixture_grid(&f, 12, 12, place_bump);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    for (int i = 0; i < 3 * POINTS; ++i) points[i] = 5 * psplat_random_unit(&random) - 2.5;
    for (int i = 0; i < POINTS; ++i) points[3 * i + 2] *= i % 2 ? 0.2 : 1;
    assert_int_equal(psplat_distance_query(distance, points, POINTS, far), PSPLAT_OK);
    for (int i = 0; i < POINTS; ++i) {
        const double *p = points + 3 * i;
        farthest = max2(farthest, far[i]);
        for (int k = 0; k < 10; ++k) {
            double asked = 3 * psplat_random_unit(&random);
            assert_int_equal(within(distance, p, 1, asked), far[i] <= asked);
        }
        /* Nearest points are rounded by about 1e-16 of coordinates of 2. */
        assert_int_equal(within(distance, p, 1, far[i] + 1e-14), 1);
        assert_int_equal(within(distance, p, 1, far[i] - 1e-14), 0);
    }
    assert_int_equal(within(distance, points, POINTS, farthest + 1e-14), 1);
    assert_int_equal(within(distance, points, POINTS, farthest - 1e-14), 0);
    /* An empty set is within any distance. */
    assert_int_equal(within(distance, points, 0, 1e-3), 1);
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

static void place_square(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

/* A disc over a square is near while its height is at most the tolerance and its rim passes the
 * square's side by no more, unless a line cuts off what passes. */
static void test_near(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 3, 3, place_square);
    psplat_distance *distance = psplat_distance_create(&f.mesh);
    assert_non_null(distance);
    const struct {
        double x, height;
        int cut, near;
    } cases[] = {{0, 0.09, 0, 1}, {0, 0.11, 0, 0}, {1.09, 0, 0, 1},
                 {1.11, 0, 0, 0}, {1.5, 0, 0, 0},  {1.5, 0, 1, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_region r = level_region(cases[i].x, 0, cases[i].height, 1, 1);
        int near = -1;
        r.line_count = (uint32_t)cases[i].cut;
        r.lines[0][0] = -1, r.lines[0][2] = 0.5;
        assert_int_equal(psplat_region_near(&r, distance, 0.1, &near), PSPLAT_OK);
        assert_int_equal(near, cases[i].near);
        assert_int_equal(psplat_region_near(&r, NULL, 0.1, &near), PSPLAT_OK);
        assert_int_equal(near, 1);
    }
    psplat_distance_destroy(distance);
    fixture_free(&f);
}

int test_region_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_local),   cmocka_unit_test(test_contains),
        cmocka_unit_test(test_polygon), cmocka_unit_test(test_points),
        cmocka_unit_test(test_near),    cmocka_unit_test(test_area),
        cmocka_unit_test(test_within),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
