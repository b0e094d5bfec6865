/* SPDX-License-Identifier: MIT
 *
 * test_morton_tree.c - tests the tree of checks on meshes that degenerate: no triangle, one, all of
 * them at one point, on one line or the same, and beside them on triangles of all shapes, against
 * every triangle in turn by another way to find its nearest point.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "mesh/mesh.h"
#include "mesh/morton_tree.h"
#include "near.h"
#include "scene_asset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Some sums and products of numbers near 1 in double, with a margin. */
#define ROUNDING 1e-13

enum { MOST = 300 };

/* Triangles that share no vertices. */
typedef struct soup {
    double positions[9 * MOST];
    uint32_t triangles[3 * MOST];
    psplat_mesh mesh;
    psplat_morton_tree *tree;
} soup;

static void begin(soup *s, size_t count) {
    for (uint32_t i = 0; i < 3 * MOST; ++i) s->triangles[i] = i;
    s->mesh = (psplat_mesh){.positions = s->positions,
                            .vertex_count = 3 * count,
                            .triangles = s->triangles,
                            .triangle_count = count};
    s->tree = psplat_morton_tree_create(&s->mesh);
    assert_non_null(s->tree);
}

static double distance_to(const soup *s, double x, double y, double z, uint32_t *triangle) {
    double at[3] = {NAN, NAN, NAN}, point[3] = {x, y, z};
    double distance = psplat_morton_tree_nearest(s->tree, point, HUGE_VAL, at, triangle);
    if (*triangle == PSPLAT_NONE) return distance;
    assert_true(*triangle < s->mesh.triangle_count);
    assert_near(distance, sqrt(pow(at[0] - x, 2) + pow(at[1] - y, 2) + pow(at[2] - z, 2)),
                ROUNDING * (1 + distance));
    return distance;
}

static int meets(const soup *s, double z0, double z1, double x, double y) {
    const double from[3] = {x, y, z0}, to[3] = {x, y, z1};
    return psplat_morton_tree_meets(s->tree, from, to);
}

static int count_visit(void *user, uint32_t triangle) {
    uint8_t *seen = user;
    assert_int_equal(seen[triangle]++, 0);
    return 0;
}

/* Returns how many triangles are visited in a cube, each at most once. */
static size_t visited(const soup *s, double middle, double half) {
    uint8_t seen[MOST] = {0};
    size_t count = 0;
    const double low[3] = {middle - half, middle - half, middle - half};
    const double high[3] = {middle + half, middle + half, middle + half};
    psplat_morton_tree_visit_box(s->tree, low, high, count_visit, seen);
    for (size_t i = 0; i < MOST; ++i) count += seen[i];
    return count;
}

static void test_no_triangle(void **state) {
    (void)state;
    static soup s;
    uint32_t triangle;
    begin(&s, 0);
    assert_true(distance_to(&s, 0, 0, 0, &triangle) == HUGE_VAL);
    assert_int_equal(triangle, PSPLAT_NONE);
    assert_false(meets(&s, 1, -1, 0, 0));
    assert_int_equal(visited(&s, 0, 1e30), 0);
    psplat_morton_tree_destroy(s.tree);
}

static void test_one_triangle(void **state) {
    (void)state;
    static soup s = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0}};
    uint32_t triangle;
    begin(&s, 1);
    assert_near(distance_to(&s, 0.25, 0.25, 2, &triangle), 2, ROUNDING); /* its face */
    assert_near(distance_to(&s, 0.5, -3, 0, &triangle), 3, ROUNDING);    /* a side */
    assert_near(distance_to(&s, 4, 4, 0, &triangle), sqrt(24.5), 1e-12); /* the long side */
    assert_near(distance_to(&s, -3, -4, 12, &triangle), 13, 1e-12);      /* a corner */
    assert_near(distance_to(&s, 0.25, 0.25, 0, &triangle), 0, ROUNDING);
    assert_int_equal(triangle, 0);
    assert_true(meets(&s, 1, -1, 0.25, 0.25));
    assert_false(meets(&s, -1, 1, 0.25, 0.25)); /* from its back */
    assert_false(meets(&s, 1, 0.5, 0.25, 0.25));
    assert_false(meets(&s, 1, -1, 0.75, 0.75));
    assert_int_equal(visited(&s, 0, 0.1), 1);
    assert_int_equal(visited(&s, 2, 0.9), 0);
    /* Only what is nearer than a bound is found. */
    double at[3], point[3] = {0.25, 0.25, 2};
    assert_true(psplat_morton_tree_nearest(s.tree, point, 1.99, at, &triangle) == HUGE_VAL);
    assert_int_equal(triangle, PSPLAT_NONE);
    assert_near(psplat_morton_tree_nearest(s.tree, point, 2.01, at, &triangle), 2, ROUNDING);
    psplat_morton_tree_destroy(s.tree);
}

/* A triangle so thin that its barycentric coordinates lose their digits still has a face: 1e-6
 * under the point, while its sides are 30 times as far away. */
static void test_thin_triangle(void **state) {
    (void)state;
    static soup s = {.positions = {0, 0, 0, 1, 0, 0, 0.5, 1e-4, 0}};
    uint32_t triangle;
    begin(&s, 1);
    assert_near(distance_to(&s, 0.5, 3e-5, 1e-6, &triangle), 1e-6, 1e-12);
    assert_near(distance_to(&s, 0.5, -3e-5, 0, &triangle), 3e-5, 1e-12);
    psplat_morton_tree_destroy(s.tree);
}

/* All corners at one point: no box has a size, and no triangle a plane. */
static void test_one_point(void **state) {
    (void)state;
    static soup s;
    const size_t counts[] = {1, 4, 5, 17, MOST};
    for (int i = 0; i < 9 * MOST; ++i) s.positions[i] = 0.75;
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        uint32_t triangle;
        begin(&s, counts[i]);
        assert_near(distance_to(&s, 3.75, 4.75, 0.75, &triangle), 5, ROUNDING);
        assert_near(distance_to(&s, 0.75, 0.75, 0.75, &triangle), 0, 0);
        assert_false(meets(&s, 2, -2, 0.75, 0.75));
        assert_int_equal(visited(&s, 0.75, 0), counts[i]);
        assert_int_equal(visited(&s, 0, 0.7), 0);
        psplat_morton_tree_destroy(s.tree);
    }
}

/* Triangles whose corners lie on one line are their longest sides, which need not be the first. */
static void test_one_line(void **state) {
    (void)state;
    static soup s;
    for (int t = 0; t < MOST; ++t)
        for (int k = 0; k < 3; ++k) {
            double along = t + ((double[]){0, 0.25, 1})[(k + t) % 3] * 0.5;
            for (int i = 0; i < 3; ++i) s.positions[9 * t + 3 * k + i] = along * (i + 1);
        }
    begin(&s, MOST);
    const double length2 = 14; /* of (1, 2, 3) */
    for (int t = 0; t < MOST; t += 7) {
        uint32_t triangle;
        /* Beside the middle of a triangle, at right angles; and between two, nearer to the first.
         */
        double along = t + 0.25, beyond = t + 0.7;
        assert_near(distance_to(&s, along + 2, 2 * along - 1, 3 * along, &triangle), sqrt(5), 1e-9);
        assert_int_equal(triangle, t);
        assert_near(distance_to(&s, beyond, 2 * beyond, 3 * beyond, &triangle), 0.2 * sqrt(length2),
                    1e-9);
        assert_int_equal(triangle, t);
        assert_false(meets(&s, 3 * along + 1, 3 * along - 1, along, 2 * along));
    }
    assert_int_equal(visited(&s, 0, 0.1), 1);
    psplat_morton_tree_destroy(s.tree);
}

/* Equal triangles have equal codes and boxes; each is still visited, and one of them is found. */
static void test_equal_triangles(void **state) {
    (void)state;
    static soup s;
    const double corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t triangle;
    for (int t = 0; t < MOST; ++t) memcpy(s.positions + 9 * t, corners, sizeof corners);
    begin(&s, MOST);
    assert_near(distance_to(&s, 0.25, 0.25, -3, &triangle), 3, ROUNDING);
    assert_true(meets(&s, 1, -1, 0.25, 0.25));
    assert_int_equal(visited(&s, 0, 0.1), MOST);
    psplat_morton_tree_destroy(s.tree);
}

/* Readers refuse vertices that are no numbers. A point that is none has no nearest one. */
static void test_no_number(void **state) {
    (void)state;
    static soup s = {.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0}};
    uint32_t triangle;
    begin(&s, 1);
    assert_true(distance_to(&s, NAN, 0, 0, &triangle) == HUGE_VAL);
    assert_int_equal(triangle, PSPLAT_NONE);
    assert_false(meets(&s, NAN, -1, 0.25, 0.25));
    psplat_morton_tree_destroy(s.tree);
}

/* Returns the square of the least distance from a + u ab + v ac for v from 0 to 1 - u. */
static double distance2_at(const double *c, const double p[3], double u) {
    double along = 0, length2 = 0, distance2 = 0;
    for (int k = 0; k < 3; ++k) {
        double way = c[6 + k] - c[k];
        along += way * (p[k] - c[k] - u * (c[3 + k] - c[k]));
        length2 += way * way;
    }
    double v = length2 > 0 ? fmin(fmax(along / length2, 0), 1 - u) : 0;
    for (int k = 0; k < 3; ++k)
        distance2 += pow(p[k] - c[k] - u * (c[3 + k] - c[k]) - v * (c[6 + k] - c[k]), 2);
    return distance2;
}

/* Returns the least distance from a triangle by golden sections of u, in which it is convex. */
static double slow_distance(const double *c, const double p[3]) {
    double low = 0, high = 1, best = fmin(distance2_at(c, p, 0), distance2_at(c, p, 1));
    const double ratio = 0.6180339887498949;
    for (int step = 0; step < 80; ++step) {
        double first = high - ratio * (high - low), second = low + ratio * (high - low);
        double found[2] = {distance2_at(c, p, first), distance2_at(c, p, second)};
        best = fmin(best, fmin(found[0], found[1]));
        if (found[0] < found[1])
            high = second;
        else
            low = first;
    }
    return sqrt(best);
}

/* Triangles of all shapes, down to slivers and points, among which every one may be the nearest. */
static void test_all_shapes(void **state) {
    (void)state;
    static soup s;
    uint32_t random = 5;
    for (int t = 0; t < MOST; ++t) {
        double size = pow(10, -4 * (double)scene_random(&random)), middle[3];
        for (int k = 0; k < 3; ++k) middle[k] = (double)scene_random(&random);
        for (int i = 0; i < 9; ++i)
            s.positions[9 * t + i] =
                middle[i % 3] + size * ((double)scene_random(&random) - 0.5) *
                                    (i >= 6 ? pow(10, -6 * (double)scene_random(&random)) : 1);
    }
    begin(&s, MOST);
    for (int i = 0; i < 200; ++i) {
        double p[3], least = HUGE_VAL;
        uint32_t triangle;
        for (int k = 0; k < 3; ++k) p[k] = 1.5 * (double)scene_random(&random) - 0.25;
        for (int t = 0; t < MOST; ++t) least = fmin(least, slow_distance(s.positions + 9 * t, p));
        /* Sections halve until rounding decides: the root of 1e-16, of distances near 1. */
        assert_near(distance_to(&s, p[0], p[1], p[2], &triangle), least, 1e-7);
    }
    psplat_morton_tree_destroy(s.tree);
}

int test_morton_tree_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_triangle),   cmocka_unit_test(test_one_triangle),
        cmocka_unit_test(test_thin_triangle), cmocka_unit_test(test_one_point),
        cmocka_unit_test(test_one_line),      cmocka_unit_test(test_equal_triangles),
        cmocka_unit_test(test_no_number),     cmocka_unit_test(test_all_shapes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
