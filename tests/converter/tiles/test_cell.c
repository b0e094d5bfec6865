/* SPDX-License-Identifier: MIT
 *
 * Tests of the cells of tiles: they nest, divide the root without gaps or overlaps, and notice each
 * triangle that meets them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "tiles/cell.h"

static const double root_low[3] = {-1, 2, -3}, root_high[3] = {3, 4.5, 1};

static psplat_tile_cell root_cell(void) {
    return psplat_tile_cell_root(root_low, root_high);
}

static void a_cell_is_halved_at_the_middle_of_its_longest_side(void **state) {
    (void)state;
    const psplat_tile_cell root = root_cell();
    /* x and z are 4 long: x is the first of both. */
    assert_int_equal(psplat_tile_cell_axis(&root), 0);
    const psplat_tile_cell lower = psplat_tile_cell_half(&root, 0),
                           upper = psplat_tile_cell_half(&root, 1);
    assert_true(lower.high[0] == 1 && upper.low[0] == 1);
    assert_true(lower.low[0] == -1 && upper.high[0] == 3);
    assert_string_equal(lower.path, "0");
    assert_string_equal(upper.path, "1");
    assert_false(lower.holds_high[0]);
    assert_true(upper.holds_high[0] && lower.holds_high[1] && lower.holds_high[2]);
    assert_int_equal(psplat_tile_cell_axis(&lower), 2);
    const psplat_tile_cell next = psplat_tile_cell_half(&lower, 1);
    assert_int_equal(psplat_tile_cell_axis(&next), 1);
    assert_string_equal(next.path, "01");
}

static void paths_name_cells(void **state) {
    (void)state;
    const psplat_tile_cell root = root_cell();
    psplat_tile_cell cell, way = root;
    char path[PSPLAT_CELL_PATH + 1];
    assert_true(psplat_tile_cell_find(&root, "", &cell));
    assert_memory_equal(&cell, &root, sizeof cell);
    for (const char *half = "0110"; *half; ++half) way = psplat_tile_cell_half(&way, *half == '1');
    assert_true(psplat_tile_cell_find(&root, "0110", &cell));
    assert_memory_equal(cell.low, way.low, sizeof cell.low);
    assert_memory_equal(cell.high, way.high, sizeof cell.high);
    assert_false(psplat_tile_cell_find(&root, "012", &cell));
    memset(path, '1', PSPLAT_CELL_PATH);
    path[PSPLAT_CELL_PATH] = 0;
    assert_false(psplat_tile_cell_find(&root, path, &cell));
    path[PSPLAT_MOST_CELL_DEPTH] = 0;
    assert_true(psplat_tile_cell_find(&root, path, &cell));
    assert_true(psplat_tile_path_is_in("0110", "01"));
    assert_true(psplat_tile_path_is_in("01", "01"));
    assert_false(psplat_tile_path_is_in("0", "01"));
    assert_false(psplat_tile_path_is_in("001", "01"));
}

/* Counts the cells of a random cut below a cell that hold a point, and those whose boxes lie in
 * their parents'. */
static int count_holders(const psplat_tile_cell *cell, const double point[3], uint64_t *random) {
    int goes_down = cell->depth < 3 || (cell->depth < 12 && psplat_random_unit(random) < 0.6);
    int count = 0;
    if (!goes_down) return psplat_tile_cell_holds(cell, point);
    for (int i = 0; i < 2; ++i) {
        const psplat_tile_cell half = psplat_tile_cell_half(cell, i);
        for (int k = 0; k < 3; ++k)
            assert_true(half.low[k] >= cell->low[k] && half.high[k] <= cell->high[k]);
        count += count_holders(&half, point, random);
    }
    return count;
}

/* Returns a random point of the root; half of its coordinates lie on sides of cells. */
static void random_point(uint64_t *random, double point[3]) {
    for (int k = 0; k < 3; ++k) {
        double at = psplat_random_unit(random);
        if (psplat_random_next(random) & 1) at = floor(16 * at + 0.5) / 16;
        point[k] = root_low[k] + at * (root_high[k] - root_low[k]);
    }
}

static void every_point_lies_in_one_cell_of_a_cut(void **state) {
    (void)state;
    const psplat_tile_cell root = root_cell();
    uint64_t random = 7;
    for (uint64_t i = 0; i < 2000; ++i) {
        double point[3];
        random_point(&random, point);
        uint64_t of_cut = i / 20;
        assert_int_equal(count_holders(&root, point, &of_cut), 1);
    }
    const double outside[3] = {3.0001, 3, 0};
    assert_false(psplat_tile_cell_holds(&root, outside));
}

/* Returns whether one of many points of a triangle lies in a cell, by more than rounding. */
static int has_point_in(const psplat_tile_cell *whole, const double corners[9]) {
    enum { STEPS = 24 };
    psplat_tile_cell inner = *whole, *cell = &inner;
    for (int k = 0; k < 3; ++k) inner.low[k] += 1e-9, inner.high[k] -= 1e-9;
    for (int i = 0; i <= STEPS; ++i)
        for (int j = 0; i + j <= STEPS; ++j) {
            double point[3], a = (double)i / STEPS, b = (double)j / STEPS;
            for (int k = 0; k < 3; ++k)
                point[k] = a * corners[k] + b * corners[k + 3] + (1 - a - b) * corners[k + 6];
            if (psplat_tile_cell_holds(cell, point)) return 1;
        }
    return 0;
}

static void no_triangle_that_meets_a_cell_is_missed(void **state) {
    (void)state;
    const psplat_tile_cell root = root_cell();
    uint64_t random = 11;
    int met = 0, claimed = 0;
    for (int i = 0; i < 3000; ++i) {
        psplat_tile_cell cell = root;
        double corners[9];
        for (int depth = 0; depth < 5; ++depth)
            cell = psplat_tile_cell_half(&cell, (int)(psplat_random_next(&random) & 1));
        for (int k = 0; k < 3; ++k) random_point(&random, corners + 3 * k);
        int has = has_point_in(&cell, corners);
        int claims = psplat_tile_cell_meets_triangle(&cell, corners);
        if (has) assert_true(claims);
        met += has, claimed += claims;
    }
    assert_true(met > 200);
    /* The points are a triangle's size / 24 apart, so that some meetings of corners and edges of
     * cells have none of them. Without the separating axes 1400 of the triangles seem to meet. */
    assert_in_range(claimed, met, met + met / 4);
}

static void a_triangle_on_a_side_meets_the_upper_cell(void **state) {
    (void)state;
    const psplat_tile_cell root = root_cell();
    const psplat_tile_cell lower = psplat_tile_cell_half(&root, 0),
                           upper = psplat_tile_cell_half(&root, 1);
    const double between[9] = {1, 2.5, -2, 1, 4, -2, 1, 3, 0},
                 last[9] = {3, 2.5, -2, 3, 4, -2, 3, 3, 0},
                 touching[9] = {1, 2.5, -2, 0, 4, -2, 0.5, 3, 0};
    assert_false(psplat_tile_cell_meets_triangle(&lower, between));
    assert_true(psplat_tile_cell_meets_triangle(&upper, between));
    assert_true(psplat_tile_cell_meets_triangle(&upper, last));
    assert_true(psplat_tile_cell_meets_triangle(&lower, touching));
    assert_true(psplat_tile_cell_meets_triangle(&upper, touching));
}

int test_cell_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cell_is_halved_at_the_middle_of_its_longest_side),
        cmocka_unit_test(paths_name_cells),
        cmocka_unit_test(every_point_lies_in_one_cell_of_a_cut),
        cmocka_unit_test(no_triangle_that_meets_a_cell_is_missed),
        cmocka_unit_test(a_triangle_on_a_side_meets_the_upper_cell),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
