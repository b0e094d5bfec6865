/* SPDX-License-Identifier: MIT
 *
 * test_region_distance.c - tests of the distance of a point to a region, flat or curved, with
 * straight and bent lines: against closed forms, and against a dense search over the surface and
 * its rim.
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
#include "base/curved_distance.h"
#include "base/polynomial.h"
#include "base/random.h"
#include "base/region.h"
#include "base/region_distance.h"
#include "base/region_tree.h"
#include "base/vector.h"

static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

/* Makes a region anywhere whose slopes are at most `steep` and whose lines are bent by at most
 * `bend`. */
static psplat_region random_region(uint64_t *random, double steep, double bend, uint32_t lines) {
    psplat_region r = {.line_count = lines};
    random_axes(random, r.u, r.v, r.n);
    for (int k = 0; k < 3; ++k) r.center[k] = between(random, -3, 3);
    r.radius[0] = between(random, 0.5, 2);
    r.radius[1] = r.radius[0] * between(random, 0.1, 1);
    for (int k = 0; k < 2; ++k) r.slope[k] = steep * between(random, -0.3, 0.3);
    double q = r.radius[1] / r.radius[0];
    for (int k = 0; k < 3; ++k)
        r.hessian[k] = steep * between(random, -0.4, 0.4) / r.radius[0] / (k == 2 ? q : 1);
    for (uint32_t i = 0; i < lines; ++i) {
        double angle = between(random, 0, 2 * fixture_pi), length = between(random, 0.7, 1.3);
        r.lines[i][0] = length * cos(angle), r.lines[i][1] = length * sin(angle);
        r.lines[i][2] = length * between(random, -0.2, 0.9);
        r.bends[i] = between(random, -bend, bend);
    }
    return r;
}

/* ---- the dense search ------------------------------------------------------------------------ */

static double distance_at(const psplat_region *r, const double p[3], double u, double v) {
    double point[3];
    const double uv[2] = {u, v};
    psplat_region_point(r, uv, point);
    return sqrt(distance2_3(point, p));
}

/* Stores the rim's point at a place: on the ellipse, or on line i. Returns whether it is kept. */
static int rim_at(const psplat_region *r, int i, double at, double uv[2]) {
    if (i < 0)
        uv[0] = cos(at), uv[1] = sin(at);
    else
        psplat_region_line_point(r, (uint32_t)i, at, uv);
    return psplat_region_contains(r, uv, 1 + 1e-9, 1e-9);
}

/* Returns the least distance on a curve of the rim: 3,000 places, and smaller and smaller steps
 * about the best of them. */
static double rim_distance(const psplat_region *r, const double p[3], int i) {
    double best = HUGE_VAL, where = 0, uv[2], step = 2 * fixture_pi / 3000;
    for (int k = -1500; k <= 1500; ++k) {
        if (!rim_at(r, i, k * step, uv) || distance_at(r, p, uv[0], uv[1]) >= best) continue;
        best = distance_at(r, p, uv[0], uv[1]);
        where = k * step;
    }
    for (; best < HUGE_VAL && step > 1e-10; step *= 0.5)
        for (int side = -1; side < 2; side += 2) {
            double at = where + side * step;
            if (!rim_at(r, i, at, uv) || distance_at(r, p, uv[0], uv[1]) >= best) continue;
            best = distance_at(r, p, uv[0], uv[1]);
            where = at;
        }
    return best;
}

/* Returns the least distance over a grid of the inside, refined about the best of its points. */
static double inner_distance(const psplat_region *r, const double p[3]) {
    double best = HUGE_VAL, at[2] = {0, 0}, step = 0.02;
    for (int i = -50; i <= 50; ++i)
        for (int k = -50; k <= 50; ++k) {
            const double uv[2] = {i * step, k * step};
            if (!psplat_region_contains(r, uv, 1, 0)) continue;
            double distance = distance_at(r, p, uv[0], uv[1]);
            if (distance < best) best = distance, at[0] = uv[0], at[1] = uv[1];
        }
    for (; best < HUGE_VAL && step > 1e-8; step *= 0.7)
        for (int i = 0; i < 8; ++i) {
            const double uv[2] = {at[0] + step * cos(i * fixture_pi / 4),
                                  at[1] + step * sin(i * fixture_pi / 4)};
            if (!psplat_region_contains(r, uv, 1, 0)) continue;
            double distance = distance_at(r, p, uv[0], uv[1]);
            if (distance < best) best = distance, at[0] = uv[0], at[1] = uv[1];
        }
    return best;
}

static double dense_distance(const psplat_region *r, const double p[3]) {
    double best = min2(inner_distance(r, p), rim_distance(r, p, -1));
    for (uint32_t i = 0; i < r->line_count; ++i) best = min2(best, rim_distance(r, p, (int)i));
    return best;
}

/* ---- tests ----------------------------------------------------------------------------------- */

/* Regions of all kinds, and points on both sides, near and far. The dense search is itself as exact
 * as a step of 1e-8, except where a corner of the rim lies between its places of 2e-3. */
static void test_dense(void **state) {
    (void)state;
    uint64_t random = 41;
    const double steeps[] = {0, 0.3, 1, 4}, reaches[] = {0.2, 1, 5, 300};
    int met = 0;
    for (int turn = 0; turn < 480; ++turn) {
        psplat_region r = random_region(&random, steeps[turn % 4], turn % 3 ? 4 : 0,
                                        (uint32_t)(turn / 4 % (PSPLAT_MAX_CLIP_LINES + 1)));
        double reach = reaches[turn / 16 % 4], p[3], dense;
        const double uv[2] = {between(&random, -1, 1), between(&random, -1, 1)};
        psplat_region_point(&r, uv, p);
        for (int k = 0; k < 3; ++k) p[k] += r.radius[0] * between(&random, -reach, reach);
        double distance = psplat_region_distance(&r, p);
        dense = dense_distance(&r, p);
        if (!(dense < HUGE_VAL)) continue;
        ++met;
        assert_true(distance <= dense + 1e-6 * r.radius[0]);
        assert_true(distance >= dense - 6e-3 * r.radius[0]);
        if (!r.line_count) assert_true(distance >= dense - 1e-6 * r.radius[0]);
    }
    assert_true(met > 350); /* In the others lines leave nothing. */
}

/* A bowl z = (x^2 + y^2) / 2 of radius 1: from points on its axis below the centre of curvature the
 * nearest point is the lowest, from higher ones it is a circle, and then the rim. */
static void test_bowl(void **state) {
    (void)state;
    psplat_region r = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}};
    r.hessian[0] = r.hessian[2] = 1;
    for (int i = -10; i < 40; ++i) {
        double z = 0.1 * i;
        const double p[3] = {0, 0, z};
        /* At height h of the circle the squared distance is 2 h + (z - h)^2, least at h = z - 1. */
        double h = min2(max2(z - 1, 0), 0.5);
        assert_near(psplat_region_distance(&r, p), sqrt(2 * h + (z - h) * (z - h)), 1e-6);
    }
    const double beside[3] = {3, 0, 0.5};
    assert_near(psplat_region_distance(&r, beside), 2, 1e-6);
}

/* From beyond the centres of curvature the whole quadric's nearest point may lie outside of the
 * region, and one that is nearest only among its neighbours inside. */
static void test_other_side(void **state) {
    (void)state;
    psplat_region r = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}};
    r.hessian[0] = 3;
    r.line_count = 2; /* u = -0.25 ... 1: the farther slope of a trough is left */
    r.lines[0][0] = 1, r.lines[0][2] = 0.25;
    r.lines[1][0] = -1, r.lines[1][2] = 0.6;
    for (int i = 0; i < 30; ++i) {
        const double p[3] = {-0.6 + 0.04 * i, 0.1, 0.9};
        assert_near(psplat_region_distance(&r, p), dense_distance(&r, p), 2e-6);
    }
}

/* A disc of which a bent line keeps a part; the nearest point is the line's vertex. */
static void test_bent_line(void **state) {
    (void)state;
    for (int bend = -3; bend <= 3; ++bend) {
        psplat_region r = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {2, 2}};
        r.line_count = 1; /* keeps x <= 2 * 0.5 at the vertex */
        r.lines[0][0] = -1, r.lines[0][2] = 0.5, r.bends[0] = bend;
        const double inside[3] = {0.9, 0, 0.3}, near[3] = {1.2, 0, 0};
        assert_near(psplat_region_distance(&r, inside), 0.3, 1e-12);
        /* Nearer to the vertex than its radius of curvature, which is 2 / bend. */
        assert_near(psplat_region_distance(&r, near), 0.2, 1e-6);
    }
}

/* The limit only ends the search earlier: of all regions the nearest is found as before. */
static void test_nearest(void **state) {
    (void)state;
    enum { REGIONS = 60 };
    psplat_region regions[REGIONS];
    uint64_t random = 43;
    for (uint32_t i = 0; i < REGIONS; ++i)
        regions[i] = random_region(&random, i % 3 ? 1.5 : 0, i % 2 ? 3 : 0, i % 3);
    psplat_region_tree *region_tree = psplat_region_tree_create(regions, REGIONS, 0);
    assert_non_null(region_tree);
    for (int i = 0; i < 200; ++i) {
        double p[3], least = HUGE_VAL;
        for (int k = 0; k < 3; ++k) p[k] = between(&random, -6, 6);
        for (int r = 0; r < REGIONS; ++r)
            least = min2(least, psplat_region_distance(&regions[r], p));
        double nearest = psplat_region_nearest_distance(regions, REGIONS, region_tree, 0.1, p);
        assert_near(nearest, least, 2e-6); /* of radii of at most 2 */
    }
    psplat_region_tree_destroy(region_tree);
}

/* Lines that leave nothing have no distance. */
static void test_nothing_left(void **state) {
    (void)state;
    psplat_region r = {.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}};
    const double p[3] = {0, 0, 1};
    r.line_count = 1;
    r.lines[0][0] = 1, r.lines[0][2] = -1.5;
    for (int curved = 0; curved < 2; ++curved) {
        r.hessian[0] = curved;
        assert_true(psplat_region_distance(&r, p) == HUGE_VAL);
    }
    r.bends[0] = 4; /* The line bends into the disc, but only beyond it. */
    assert_true(psplat_region_distance(&r, p) < HUGE_VAL);
}

/* Products of known factors, of all degrees. */
static void test_polynomial(void **state) {
    (void)state;
    uint64_t random = 44;
    for (int turn = 0; turn < 200; ++turn) {
        size_t degree = 1 + (size_t)turn % PSPLAT_MAX_DEGREE;
        double c[PSPLAT_MAX_DEGREE + 1] = {1}, known[PSPLAT_MAX_DEGREE], roots[PSPLAT_MAX_DEGREE];
        for (size_t k = 0; k < degree; ++k) { /* at least 0.1 from each other */
            known[k] = -1 + 0.4 * (double)k + between(&random, 0, 0.3);
            for (size_t i = k + 2; i-- > 0;)
                c[i] = (i ? c[i - 1] : 0) - known[k] * (i <= k ? c[i] : 0);
        }
        assert_int_equal(psplat_polynomial_roots(c, degree, -2, 2, roots), degree);
        for (size_t k = 0; k < degree; ++k) assert_near(roots[k], known[k], 1e-11);
        assert_near(psplat_polynomial_at(c, degree, known[0]), 0, 1e-14);
    }
    const double none[3] = {1, 0, 1}, constant[3] = {2, 0, 0};
    double roots[2];
    assert_int_equal(psplat_polynomial_roots(none, 2, -9, 9, roots), 0);
    assert_int_equal(psplat_polynomial_roots(constant, 2, -9, 9, roots), 0);
}

int test_region_distance_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dense),      cmocka_unit_test(test_bowl),
        cmocka_unit_test(test_other_side), cmocka_unit_test(test_bent_line),
        cmocka_unit_test(test_nearest),    cmocka_unit_test(test_nothing_left),
        cmocka_unit_test(test_polynomial),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
