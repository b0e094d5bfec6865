/* SPDX-License-Identifier: MIT
 *
 * test_surface_points.c - tests of sample points on curved splats with bent lines: they lie on the
 * surface, within the lines, and are spread evenly over its area.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "compare_fixture.h"
#include "base/region.h"
#include "base/vector.h"
#include "compare/surface_points.h"

enum { REGIONS = 4, POINTS = 40000 };

/* A plane disc with a hole bent into it, a steep trough, a bowl that lines of both bends cut, and a
 * slope. */
static void make_regions(psplat_region *regions) {
    for (int i = 0; i < REGIONS; ++i)
        regions[i] = (psplat_region){
            .center = {5 * i, 0, 0}, .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}};
    for (int i = 0; i < REGIONS; ++i) regions[i].radius[0] = 1, regions[i].radius[1] = 0.8;
    regions[0].line_count = 1;
    regions[0].lines[0][0] = 1, regions[0].lines[0][2] = -0.2, regions[0].bends[0] = 3;
    regions[1].hessian[0] = 3;
    regions[2].hessian[0] = regions[2].hessian[2] = 1.5;
    regions[2].line_count = 2;
    regions[2].lines[0][1] = 1, regions[2].lines[0][2] = 0.3, regions[2].bends[0] = -2;
    regions[2].lines[1][0] = -1, regions[2].lines[1][2] = 0.1, regions[2].bends[1] = 2;
    regions[3].slope[0] = 2;
}

/* Adds up the area of a surface over cells of (u, v), and of its part with u > v. */
static void add_area(const psplat_region *r, double *area, double *part) {
    enum { CELLS = 1000 };
    for (int i = 0; i < CELLS * CELLS; ++i) {
        const double uv[2] = {(2 * (i % CELLS) + 1.0) / CELLS - 1,
                              (2.0 * (i / CELLS) + 1) / CELLS - 1};
        double slope[2], cell = 4 * r->radius[0] * r->radius[1] / CELLS / CELLS;
        if (!psplat_region_contains(r, uv, 1, 0)) continue;
        psplat_region_slope(r, uv, slope);
        cell *= sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
        *area += cell;
        *part += uv[0] > uv[1] ? cell : 0;
    }
}

static void test_even(void **state) {
    (void)state;
    psplat_region regions[REGIONS];
    psplat_surface_points cloud;
    double areas[REGIONS] = {0}, parts[REGIONS] = {0}, whole = 0;
    size_t counts[REGIONS] = {0}, halves[REGIONS] = {0};
    make_regions(regions);
    for (int i = 0; i < REGIONS; ++i) {
        add_area(&regions[i], &areas[i], &parts[i]);
        whole += areas[i];
    }
    assert_int_equal(psplat_surface_points_of_regions(regions, REGIONS, POINTS, 5, &cloud, NULL),
                     PSPLAT_OK);
    assert_true(cloud.uniform > POINTS / 4 && cloud.uniform < cloud.count);
    for (size_t i = 0; i < cloud.count; ++i) {
        const double *p = cloud.points + 3 * i;
        double uvh[3];
        size_t at = (size_t)(p[0] / 5 + 0.5);
        assert_in_range(at, 0, REGIONS - 1);
        psplat_region_local(&regions[at], p, uvh);
        assert_near(uvh[2], 0, 1e-14);
        assert_true(psplat_region_contains(&regions[at], uvh, 1 + 1e-12, 1e-12));
        if (i >= cloud.uniform) continue;
        ++counts[at];
        halves[at] += uvh[0] > uvh[1];
    }
    for (int i = 0; i < REGIONS; ++i) {
        double share = areas[i] / whole, uniform = (double)cloud.uniform;
        double given = (double)counts[i];
        /* Four standard deviations of as many chances, and a cell's width of the areas. */
        assert_near(given / uniform, share, 4 * sqrt(share / uniform) + 2e-3);
        assert_near((double)halves[i] / given, parts[i] / areas[i], 2 / sqrt(given) + 2e-3);
    }
    psplat_surface_points_free(&cloud);
}

/* Many regions with four bent lines each get few points, and corners nevertheless. */
static void test_few(void **state) {
    (void)state;
    psplat_region regions[40];
    psplat_surface_points cloud;
    for (int i = 0; i < 40; ++i) {
        regions[i] = (psplat_region){
            .u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {1, 1}, .line_count = 4};
        for (int k = 0; k < 4; ++k) {
            regions[i].lines[k][k / 2] = k % 2 ? 1 : -1;
            regions[i].lines[k][2] = 0.5, regions[i].bends[k] = 0.2 * (i % 20 - 10);
        }
    }
    assert_int_equal(psplat_surface_points_of_regions(regions, 40, 10, 5, &cloud, NULL), PSPLAT_OK);
    assert_true(cloud.count - cloud.uniform >= 40 * 8);
    psplat_surface_points_free(&cloud);
}

/* Returns the mean distance between points that follow each other. */
static double mean_step(const double *points, size_t count) {
    double sum = 0;
    for (size_t i = 1; i < count; ++i) sum += sqrt(distance2_3(points + 3 * i, points + 3 * i - 3));
    return sum / (double)(count - 1);
}

/* Points that follow each other are near each other, so that the nearest triangle of one is a good
 * guess for the next. Random points of these regions, which are 2 wide, are 0.9 apart on average;
 * those that share a 64th of their box, which is 17 long, are 0.15 apart. */
static void test_order(void **state) {
    (void)state;
    psplat_region regions[REGIONS];
    psplat_surface_points cloud;
    make_regions(regions);
    assert_int_equal(psplat_surface_points_of_regions(regions, REGIONS, POINTS, 5, &cloud, NULL),
                     PSPLAT_OK);
    assert_true(mean_step(cloud.points, cloud.uniform) < 0.3);
    psplat_surface_points_free(&cloud);
}

/* Points of a mesh are sorted as well, and keep their normals: at a cube each lies on the face that
 * its normal says. */
static void test_mesh_order(void **state) {
    (void)state;
    static const double here[3] = {0, 0, 0};
    fixture f;
    psplat_surface_points cloud;
    fixture_model(&f, "cube.off");
    assert_int_equal(psplat_surface_points_of_mesh(f.source, here, POINTS, 5, &cloud, NULL),
                     PSPLAT_OK);
    for (size_t i = 0; i < cloud.uniform; ++i) {
        double along = 0;
        for (size_t k = 0; k < 3; ++k)
            along += cloud.points[3 * i + k] * (double)cloud.normals[3 * i + k];
        assert_near(along, 1, 1e-6); /* Normals are floats. */
    }
    /* Random points of a triangle of this cube, of side 2, are 1 apart on average. */
    assert_true(mean_step(cloud.points, cloud.uniform) < 0.1);
    psplat_surface_points_free(&cloud);
    fixture_free(&f);
}

int test_surface_points_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_even),
        cmocka_unit_test(test_few),
        cmocka_unit_test(test_order),
        cmocka_unit_test(test_mesh_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
