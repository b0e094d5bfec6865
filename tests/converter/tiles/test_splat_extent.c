/* SPDX-License-Identifier: MIT
 *
 * Tests of the bounds of what a splat shows, against many of its points.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "base/vector.h"
#include "tiles/splat_extent.h"

enum { REGIONS = 300, POINTS = 3000 };

static double between(uint64_t *random, double low, double high) {
    return low + psplat_random_unit(random) * (high - low);
}

/* Makes a curved region with some lines, half of them bent. */
static psplat_region random_region(uint64_t *random) {
    psplat_region r = {.radius = {between(random, 0.5, 2), between(random, 0.2, 0.5)}};
    for (int k = 0; k < 3; ++k) {
        r.center[k] = between(random, -1, 1);
        r.n[k] = between(random, -1, 1);
    }
    normalize3(r.n);
    perpendicular3(r.u, r.n);
    cross3(r.v, r.n, r.u);
    for (int k = 0; k < 3; ++k) r.hessian[k] = between(random, -1, 1);
    for (int k = 0; k < 2; ++k) r.slope[k] = between(random, -0.3, 0.3);
    r.line_count = (uint32_t)(psplat_random_next(random) % 3);
    for (uint32_t i = 0; i < r.line_count; ++i) {
        double angle = between(random, 0, 6.3);
        r.lines[i][0] = cos(angle), r.lines[i][1] = sin(angle);
        r.lines[i][2] = between(random, -0.2, 0.8);
        if (i % 2) r.bends[i] = between(random, -1, 1);
    }
    return r;
}

/* Stores points of a region that its lines keep. Returns how many. */
static size_t points_of(const psplat_region *region, uint64_t *random, double points[][3],
                        double normals[][3]) {
    size_t count = 0;
    for (int i = 0; i < POINTS; ++i) {
        const double uv[2] = {between(random, -1, 1), between(random, -1, 1)};
        if (!psplat_region_contains(region, uv, 1, 0)) continue;
        psplat_region_normal(region, uv, normals[count]);
        psplat_region_point(region, uv, points[count++]);
    }
    return count;
}

static void boxes_hold_all_points_and_little_more(void **state) {
    (void)state;
    static double points[POINTS][3], normals[POINTS][3];
    uint64_t random = 3;
    double excess = 0, whole = 0;
    for (int i = 0; i < REGIONS; ++i) {
        const psplat_region region = random_region(&random);
        double low[3], high[3], least[3] = {9, 9, 9}, most[3] = {-9, -9, -9};
        size_t count = points_of(&region, &random, points, normals);
        int has = psplat_splat_extent_box(&region, low, high);
        if (count) assert_true(has);
        for (size_t p = 0; p < count; ++p)
            for (int k = 0; k < 3; ++k) {
                assert_true(points[p][k] >= low[k] - 1e-12 && points[p][k] <= high[k] + 1e-12);
                least[k] = fmin(least[k], points[p][k]);
                most[k] = fmax(most[k], points[p][k]);
            }
        for (int k = 0; k < 3 && count > 500; ++k) {
            whole += most[k] - least[k];
            excess += (high[k] - low[k]) - (most[k] - least[k]);
        }
    }
    /* Boxes around circles of 16 sides are 2 % too wide; the rest is what lies between points. */
    assert_true(excess < 0.15 * whole);
}

static void no_box_that_a_splat_reaches_is_missed(void **state) {
    (void)state;
    static double points[POINTS][3], normals[POINTS][3];
    uint64_t random = 5;
    int reached = 0, claimed = 0;
    for (int i = 0; i < 2 * REGIONS; ++i) {
        const psplat_region region = random_region(&random);
        size_t count = points_of(&region, &random, points, normals);
        double low[3], high[3];
        for (int k = 0; k < 3; ++k) {
            low[k] = region.center[k] + between(&random, -1.2, 0.8);
            high[k] = low[k] + between(&random, 0.3, 0.8);
        }
        int reaches = 0, claims = psplat_splat_extent_meets(&region, low, high);
        for (size_t p = 0; p < count && !reaches; ++p) {
            reaches = 1;
            for (int k = 0; k < 3; ++k)
                reaches &= points[p][k] >= low[k] && points[p][k] <= high[k];
        }
        if (reaches) assert_true(claims);
        reached += reaches, claimed += claims;
    }
    assert_true(reached > 100);
    assert_in_range(claimed, reached, reached + reached / 4);
}

static void cones_hold_all_normals(void **state) {
    (void)state;
    static double points[POINTS][3], normals[POINTS][3];
    uint64_t random = 9;
    int cones = 0;
    for (int i = 0; i < REGIONS; ++i) {
        psplat_region regions[2] = {random_region(&random), random_region(&random)};
        const uint32_t both[2] = {0, 1};
        for (int k = 0; k < 3; ++k) regions[1].n[k] = regions[0].n[k] + 0.2 * regions[1].n[k];
        normalize3(regions[1].n);
        perpendicular3(regions[1].u, regions[1].n);
        cross3(regions[1].v, regions[1].n, regions[1].u);
        const psplat_normal_cone cone = psplat_splat_extent_cone(regions, both, 2);
        if (!(cone.cosine > 0)) continue;
        ++cones;
        for (int r = 0; r < 2; ++r) {
            size_t count = points_of(&regions[r], &random, points, normals);
            for (size_t p = 0; p < count; ++p)
                assert_true(dot3(normals[p], cone.axis) >= cone.cosine - 1e-9);
        }
    }
    assert_true(cones > 20);
}

int test_splat_extent_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_hold_all_points_and_little_more),
        cmocka_unit_test(no_box_that_a_splat_reaches_is_missed),
        cmocka_unit_test(cones_hold_all_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
