/* SPDX-License-Identifier: MIT
 * Regions: what they hold, their outlines, points all over them, and how near those are to a mesh.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <cmocka.h>

#include "stage_fixture.h"

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
    r.line_count = 2; /* a quarter */
    r.lines[0][0] = 1, r.lines[1][1] = 1;
    size_t count = psplat_region_polygon(&r, 1, polygon, 68);
    assert_near(area_of(polygon, count), 8 * sin(fixture_pi / 32), 1e-12);
    r.lines[1][2] = -1.5; /* nothing */
    assert_int_equal(psplat_region_polygon(&r, 0, polygon, 68), 0);
}

/* ---- points ---------------------------------------------------------------------------------- */

/* A region anywhere in space, cut by lines that leave its centre. */
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

/* Points lie in the region's plane and inside it; some on its outline all around; and the middle of
 * what lines leave is among them, so that no gap is wider than half of the outline. */
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
    psplat_region r = level_region(0, 0, 0, 1, 1); /* nothing left of it */
    double points[PSPLAT_REGION_POINTS][3];
    r.line_count = 1;
    r.lines[0][0] = 1, r.lines[0][2] = -1.5;
    assert_int_equal(psplat_region_points(&r, points), 0);
}

static void place_square(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

/* A disc over a square: near as long as it is as low as the tolerance, and until its rim passes the
 * square's side by more, unless a line cuts that off. */
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_local),   cmocka_unit_test(test_contains),
        cmocka_unit_test(test_polygon), cmocka_unit_test(test_points),
        cmocka_unit_test(test_near),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
