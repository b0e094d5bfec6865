/* SPDX-License-Identifier: MIT
 *
 * test_block_boxes.c - tests of boxes around blocks of a list: searches meet all that is near, in
 * the order of the list, and skip most of the rest.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <cmocka.h>

#include "base/block_boxes.h"
#include "base/random.h"

enum { MOST = 5000 };

static int is_near(const double a[3], const double b[3], double reach) {
    for (int k = 0; k < 3; ++k)
        if (!(fabs(a[k] - b[k]) <= reach)) return 0;
    return 1;
}

/* Makes points of a walk, whose neighbours are neighbours in space. */
static void walk(double points[][3], size_t count, uint64_t seed) {
    double at[3] = {0, 0, 0};
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) points[i][k] = at[k] += psplat_random_unit(&seed) - 0.5;
}

/* Of lists whose last block is full, or not, or of one item, every item near a point is met, and in
 * order. Of a long walk most others are not. */
static void test_near(void **state) {
    (void)state;
    static const size_t counts[] = {
        0, 1, PSPLAT_BLOCK_ITEMS - 1, PSPLAT_BLOCK_ITEMS, PSPLAT_BLOCK_ITEMS + 1, MOST};
    static double points[MOST][3];
    uint64_t random = 3;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        size_t count = counts[c], met = 0, near = 0;
        psplat_block_boxes boxes;
        walk(points, count, c);
        assert_int_equal(psplat_block_boxes_create(count, &boxes), PSPLAT_OK);
        for (size_t i = 0; i < count; ++i) psplat_block_boxes_add(&boxes, i, points[i]);
        for (int trial = 0; trial < 100; ++trial) {
            size_t next = 0;
            double origin[3] = {0, 0, 0}, reach = 3 * psplat_random_unit(&random);
            const double *center = count ? points[psplat_random_next(&random) % count] : origin;
            for (size_t i = psplat_block_boxes_next(&boxes, 0, center, reach); i < count;
                 i = psplat_block_boxes_next(&boxes, i + 1, center, reach), ++met) {
                assert_true(i >= next);
                for (; next < i; ++next) assert_false(is_near(points[next], center, reach));
                near += (size_t)is_near(points[i], center, reach);
                next = i + 1;
            }
            for (; next < count; ++next) assert_false(is_near(points[next], center, reach));
        }
        if (count) assert_true(near >= 100);
        if (count == MOST) assert_true(met < 100 * count / 4);
        psplat_block_boxes_free(&boxes);
    }
}

int test_block_boxes_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_near)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
