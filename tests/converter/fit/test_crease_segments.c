/* SPDX-License-Identifier: MIT
 *
 * test_crease_segments.c - the crease edges inside regions: those that a search by the boxes of a
 * neighbourhood finds against those that a search without boxes finds.
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
#include "features/neighborhood.h"
#include "fit/crease_segments.h"

static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

/* Makes a region near a sample, some of them steep, elongated, curved or cut. */
static psplat_region make_region(const fixture *f, size_t sample, uint64_t *random) {
    psplat_region r = {.line_count = sample % 3 == 0};
    double size = f->surface.diagonal * 0.2 * pow(between(random, 0.1, 1), 2);
    for (int k = 0; k < 3; ++k)
        r.n[k] = (double)f->samples.normals[3 * sample + (size_t)k] + between(random, -0.5, 0.5);
    normalize3(r.n);
    perpendicular3(r.u, r.n);
    cross3(r.v, r.n, r.u);
    for (int k = 0; k < 3; ++k)
        r.center[k] = f->samples.positions[3 * sample + (size_t)k] + size * between(random, -1, 1);
    r.radius[0] = size, r.radius[1] = size * between(random, 0.05, 1);
    for (int k = 0; k < 2 && sample % 2; ++k) r.slope[k] = between(random, -2, 2);
    for (int k = 0; k < 3 && sample % 2; ++k) r.hessian[k] = between(random, -2, 2) / size;
    r.lines[0][0] = 1, r.lines[0][2] = between(random, -0.5, 1);
    r.bends[0] = sample % 6 == 0 ? between(random, -1, 1) : 0;
    return r;
}

/* Asserts that a neighbourhood has the segments of all its creases. Returns how many. */
static size_t compare(const fixture *f, const psplat_neighborhood *near,
                      const psplat_region *region, double height) {
    size_t count = near->crease_count;
    psplat_segment *all = calloc(count + 1, sizeof *all), *some = calloc(count + 1, sizeof *some);
    assert_true(all && some);
    size_t expected = psplat_segments_find(&f->surface, near->creases, count, region, height, all);
    size_t found = psplat_segments_find_near(&f->surface, near, region, height, some);
    assert_int_equal(found, expected);
    for (size_t i = 0; i < found; ++i) {
        assert_memory_equal(some[i].vertex, all[i].vertex, sizeof all[i].vertex);
        assert_memory_equal(some[i].a, all[i].a, sizeof all[i].a);
        assert_memory_equal(some[i].b, all[i].b, sizeof all[i].b);
        assert_int_equal(some[i].across, all[i].across);
        assert_int_equal(some[i].is_smooth, all[i].is_smooth);
        assert_int_equal(some[i].is_chart, all[i].is_chart);
        assert_int_equal(some[i].is_tangent, all[i].is_tangent);
    }
    free(all);
    free(some);
    return found;
}

static void test_near(void **state) {
    (void)state;
    const psplat_metric whole = {.rows = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    fixture f;
    psplat_neighborhood near = {0};
    uint64_t random = 11;
    size_t found = 0, met = 0, trials = 0;
    fixture_model(&f, "part.obj");
    fixture_sample(&f, 0.01);
    for (size_t i = 0; i < f.samples.count; i += 7, ++trials) {
        psplat_region region = make_region(&f, i, &random);
        psplat_metric metric = whole;
        memcpy(metric.center, f.samples.positions + 3 * i, sizeof metric.center);
        assert_int_equal(psplat_neighborhood_gather(&near, &f.surface, &f.samples, &metric,
                                                    f.samples.triangles[i],
                                                    0.3 * f.surface.diagonal, 1),
                         1);
        size_t count = compare(&f, &near, &region, between(&random, 0, 0.2) * region.radius[0]);
        found += count, met += count > 0;
    }
    print_message("%zu regions, %zu with creases, %zu segments\n", trials, met, found);
    assert_true(met > 200 && found > 3 * met);
    psplat_neighborhood_free(&near);
    fixture_free(&f);
}

/* Creases whose boxes are elsewhere are left out. */
static void test_elsewhere(void **state) {
    (void)state;
    const psplat_metric whole = {.rows = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    fixture f;
    psplat_neighborhood near = {0};
    fixture_model(&f, "cube.off");
    fixture_sample(&f, 0.1);
    psplat_region region = {.radius = {f.surface.diagonal, f.surface.diagonal}};
    const double *face = f.surface.face_normals + 3 * (size_t)f.samples.triangles[0];
    memcpy(region.center, f.samples.positions, sizeof region.center);
    memcpy(region.n, face, sizeof region.n);
    perpendicular3(region.u, region.n);
    cross3(region.v, region.n, region.u);
    psplat_metric metric = whole;
    memcpy(metric.center, region.center, sizeof metric.center);
    assert_int_equal(psplat_neighborhood_gather(&near, &f.surface, &f.samples, &metric,
                                                f.samples.triangles[0], f.surface.diagonal, 1),
                     1);
    assert_true(compare(&f, &near, &region, 0.01) >= 4);
    for (size_t i = 0; i < near.crease_count; i += PSPLAT_CREASE_BLOCK)
        for (int k = 0; k < 3; ++k) near.crease_boxes[i / PSPLAT_CREASE_BLOCK].low[k] = 1e9;
    psplat_segment *segments = calloc(near.crease_count + 1, sizeof *segments);
    assert_non_null(segments);
    assert_int_equal(psplat_segments_find_near(&f.surface, &near, &region, 0.01, segments), 0);
    free(segments);
    psplat_neighborhood_free(&near);
    fixture_free(&f);
}

static void place_square(double s, double t, double p[3]) {
    p[0] = s, p[1] = t, p[2] = 0;
}

/* Small regions far beneath the border of a square, of which one is steep and the other becomes so
 * towards its rim: their surfaces are nearer to the border than their planes, and so near that it
 * counts. */
static void test_steep(void **state) {
    (void)state;
    const double height = 0.1, depth = 0.2, size = 0.01;
    const psplat_metric whole = {.center = {0.25, 0, 0}, .rows = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    fixture f;
    psplat_neighborhood near = {0};
    fixture_grid(&f, 3, 3, place_square);
    fixture_build(&f);
    fixture_sample(&f, 0.05);
    psplat_region region = {.center = {0.25, 0, -depth},
                            .u = {1, 0, 0},
                            .v = {0, 1, 0},
                            .n = {0, 0, 1},
                            .radius = {size, size},
                            .slope = {2, 0}};
    assert_int_equal(psplat_neighborhood_gather(&near, &f.surface, &f.samples, &whole, 0, 1, 1), 1);
    assert_int_equal(compare(&f, &near, &region, height), 1);
    region.center[1] = -0.95 * size;
    region.slope[0] = 0, region.hessian[2] = 2 / size;
    assert_int_equal(compare(&f, &near, &region, height), 1);
    region.center[2] = -2 * depth;
    assert_int_equal(compare(&f, &near, &region, height), 0);
    psplat_neighborhood_free(&near);
    fixture_free(&f);
}

int test_crease_segments_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_near),
                                       cmocka_unit_test(test_elsewhere),
                                       cmocka_unit_test(test_steep)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
