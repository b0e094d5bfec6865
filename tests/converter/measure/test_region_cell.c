/* SPDX-License-Identifier: MIT
 *
 * test_region_cell.c - tests which segments lie inside convex cells: whatever corners a cell has
 * twice but for rounding, as cuts leave them, it holds what its polygon holds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "measure/region_cell.h"

static const double slack = 1e-12;
static const double square[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};

static const struct segment {
    double a[2], b[2];
    int is_inside;
} segments[] = {
    {{-0.2, 0.1}, {0.3, -0.2}, 1},  /* all inside */
    {{-2, 0.1}, {2, 0.2}, 1},       /* across */
    {{0.3, 0.6}, {0.6, 0.3}, 1},    /* cuts a corner off */
    {{0.4, 0.8}, {0.8, 0.4}, 0},    /* passes that corner */
    {{0.5, -0.4}, {0.5, 0.4}, 0},   /* lies on a side */
    {{0.5, 0.1}, {0.9, 0.1}, 0},    /* one end is on a side */
    {{-0.9, -0.8}, {-0.6, 0.9}, 0}, /* beside */
};
enum { SEGMENTS = sizeof segments / sizeof *segments };

static void assert_holds(const psplat_cell *cell) {
    for (int i = 0; i < SEGMENTS; ++i) {
        const struct segment *s = &segments[i];
        assert_int_equal(psplat_cell_holds_segment(cell, s->a, s->b, slack), s->is_inside);
        assert_int_equal(psplat_cell_holds_segment(cell, s->b, s->a, slack), s->is_inside);
    }
}

static void test_square(void **state) {
    (void)state;
    psplat_cell cell = {.count = 4};
    memcpy(cell.corners, square, sizeof square);
    assert_holds(&cell);
}

/* Each corner twice, the second one a rounding off to any side. */
static void test_repeated_corners(void **state) {
    (void)state;
    for (size_t corner = 0; corner < 4; ++corner)
        for (int turn = 0; turn < 16; ++turn) {
            psplat_cell cell = {.count = 5};
            double angle = turn * 3.14159265358979 / 8;
            memcpy(cell.corners, square, (corner + 1) * sizeof *square);
            memcpy(cell.corners + corner + 1, square + corner, (4 - corner) * sizeof *square);
            cell.corners[corner + 1][0] += 0x1p-53 * cos(angle) * 2;
            cell.corners[corner + 1][1] += 0x1p-53 * sin(angle) * 2;
            assert_holds(&cell);
        }
}

int test_region_cell_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_square),
                                       cmocka_unit_test(test_repeated_corners)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
