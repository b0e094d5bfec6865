/* SPDX-License-Identifier: MIT
 *
 * test_vector.c - tests of squared distances of a point from a segment and from a triangle, in
 * every region around them, and where they have no length or area. Expected values are exact, or
 * those of many points of the triangle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/random.h"
#include "base/vector.h"

static void test_segment(void **state) {
    (void)state;
    const double a[3] = {1, 2, 3}, b[3] = {5, 2, 3};
    const struct {
        double p[3], distance2;
    } cases[] = {{{3, 2, 3}, 0},   {{3, 4, 3}, 4},   {{2, 3, 4}, 2},
                 {{1, 2, 3}, 0},   {{5, 2, 3}, 0},   {{-2, 2, 3}, 9},
                 {{-2, 6, 3}, 25}, {{8, 2, -1}, 25}, {{5, 2, 10}, 49}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        assert_near(point_segment_distance2(cases[i].p, a, b), cases[i].distance2, 1e-14);
        assert_near(point_segment_distance2(cases[i].p, b, a), cases[i].distance2, 1e-14);
    }
    const double p[3] = {1, 2, 5}; /* A segment without length is its end. */
    assert_near(point_segment_distance2(p, a, a), 4, 0);
    assert_near(point_segment_distance2(a, a, a), 0, 0);
}

/* The points lie around an obtuse triangle: inside, beyond each side, beyond each corner, and
 * where, next to a wide angle, a point is beyond the lines of two sides but nearest to one of them.
 */
static void test_regions(void **state) {
    (void)state;
    const double corners[3][3] = {{0, 0, 0}, {4, 0, 0}, {5, 1, 0}};
    const struct {
        double p[3], distance2;
    } cases[] = {
        {{4, 0.5, 0}, 0},
        {{4, 0.5, 2}, 4},
        {{4, 0.5, -3}, 9}, /* inside */
        {{2, -1, 0}, 1},
        {{2, -1, 1}, 2}, /* below side ab */
        {{5, 0, 0}, 0.5},
        {{5, 0, 1}, 1.5},        /* beside side bc */
        {{2, 3, 0}, 169.0 / 26}, /* above side ca */
        {{-3, -4, 0}, 25},
        {{-1, 0.1, 0}, 1.01}, /* at a */
        {{4.1, -1, 0}, 1.01}, /* at b */
        {{8, 5, 0}, 25},
        {{6, 1, 2}, 5}, /* at c */
        /* beyond two lines, nearest to a */
        {{-0.1, -1, 0}, 1.01},
        {{0, -1, 0}, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (int turn = 0; turn < 6; ++turn) { /* each corner first, in both orientations */
            const double *a = corners[turn % 3], *b = corners[(turn + 1) % 3];
            const double *c = corners[(turn + 2) % 3];
            double found = turn < 3 ? point_triangle_distance2(cases[i].p, a, b, c)
                                    : point_triangle_distance2(cases[i].p, a, c, b);
            assert_near(found, cases[i].distance2, 1e-14 * (1 + cases[i].distance2));
        }
}

/* The distance is that of the nearest of many points of the triangle. */
static void test_random(void **state) {
    (void)state;
    enum { STEPS = 60 };
    uint64_t random = 4;
    for (int trial = 0; trial < 100; ++trial) {
        double corners[3][3], p[3], least = HUGE_VAL, longest = 0;
        for (int k = 0; k < 3; ++k) {
            p[k] = 4 * psplat_random_unit(&random) - 1.5;
            for (int i = 0; i < 3; ++i) corners[i][k] = psplat_random_unit(&random);
        }
        for (int i = 0; i < 3; ++i)
            longest = max2(longest, sqrt(distance2_3(corners[i], corners[(i + 1) % 3])));
        for (int i = 0; i <= STEPS; ++i)
            for (int k = 0; k <= STEPS - i; ++k) {
                double q[3] = {0, 0, 0};
                mad3(q, (double)i / STEPS, corners[0]);
                mad3(q, (double)k / STEPS, corners[1]);
                mad3(q, (double)(STEPS - i - k) / STEPS, corners[2]);
                least = min2(least, sqrt(distance2_3(p, q)));
            }
        double found = sqrt(point_triangle_distance2(p, corners[0], corners[1], corners[2]));
        assert_true(found <= least + 1e-12);
        assert_true(found >= least - longest / STEPS);
    }
}

/* A triangle without area is its longest side; one without size is its corner. */
static void test_degenerate(void **state) {
    (void)state;
    const double a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {4, 0, 0};
    const struct {
        double p[3], distance2;
    } cases[] = {{{2, 0, 0}, 0}, {{2, 3, 0}, 9}, {{-3, 4, 0}, 25}, {{7, 0, 4}, 25}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const double *p = cases[i].p;
        assert_near(point_triangle_distance2(p, a, b, c), cases[i].distance2, 1e-14);
        assert_near(point_triangle_distance2(p, c, a, b), cases[i].distance2, 1e-14);
        assert_near(point_triangle_distance2(p, a, a, c), cases[i].distance2, 1e-14);
        assert_near(point_triangle_distance2(p, a, a, a), dot3(p, p), 0);
    }
}

int test_vector_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_segment),
        cmocka_unit_test(test_regions),
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_degenerate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
