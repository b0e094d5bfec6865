/* SPDX-License-Identifier: MIT
 *
 * test_pareto.c - tests of Pareto fronts and of their knees, with ties, missing values, zeros and
 * negative values. The rows are invented.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <math.h>
#include <cmocka.h>

#include "invented_table.h"
#include "tradeoff/pareto.h"
#include "table/row.h"
#include "table/setting.h"

static const psplat_column columns[] = {PSPLAT_COLUMN_BYTES, PSPLAT_COLUMN_DIFFERENCE};

/* Asserts which rows are on the front, as a word of 0 and 1. */
static void assert_front(const psplat_row *rows, size_t count, const char *expected) {
    uint8_t is_front[16];
    char found[17] = "";
    psplat_pareto_mark(rows, count, PSPLAT_COMPETITOR_SPLATS, columns, 2, is_front);
    for (size_t i = 0; i < count; ++i) found[i] = is_front[i] ? '1' : '0';
    found[count] = 0;
    assert_string_equal(found, expected);
}

static void test_front(void **state) {
    (void)state;
    const psplat_row rows[] = {plain_row(100, 5, 1), plain_row(200, 3, 1), plain_row(150, 6, 1),
                               plain_row(400, 3, 1), plain_row(300, 1, 1), plain_row(90, 9, 1)};
    assert_front(rows, 6, "110011");
    assert_front(rows, 1, "1");
    assert_front(rows, 0, "");
}

static void test_ties(void **state) {
    (void)state;
    /* Equal rows do not dominate each other; a row that is equal in one value and worse in the
     * other is dominated. */
    const psplat_row rows[] = {plain_row(100, 5, 1), plain_row(100, 5, 2), plain_row(100, 6, 1),
                               plain_row(101, 5, 1)};
    assert_front(rows, 4, "1100");
}

static void test_missing_values(void **state) {
    (void)state;
    psplat_row other = plain_row(1, 0.1, 1);
    other.setting.competitor = PSPLAT_COMPETITOR_GLTFPACK;
    const psplat_row rows[] = {
        plain_row(NAN, 0.1, 1),      plain_row(50, NAN, 1),      other,
        plain_row(100, 5, NAN),      plain_row(200, 0, 1),       plain_row(300, -1, 1),
        plain_row(400, INFINITY, 1), plain_row(INFINITY, -2, 1), plain_row(500, 0, 1)};
    assert_front(rows, 9, "000111010");
}

static void test_order(void **state) {
    (void)state;
    const psplat_row rows[] = {plain_row(300, 1, 1), plain_row(100, 5, 1), plain_row(200, 3, 1),
                               plain_row(100, 5, 2), plain_row(50, 99, 1)};
    const uint8_t is_front[] = {1, 1, 1, 1, 0};
    size_t order[5];
    assert_int_equal(psplat_pareto_sort(rows, 5, is_front, PSPLAT_COLUMN_BYTES, order), 3);
    assert_int_equal(order[0], 1); /* the first of two equal rows */
    assert_int_equal(order[1], 2);
    assert_int_equal(order[2], 0);
}

static size_t knee_of(const psplat_row *rows, size_t count) {
    const size_t order[] = {0, 1, 2, 3, 4};
    return psplat_pareto_knee(rows, order, count, columns[0], columns[1]);
}

static void test_knee(void **state) {
    (void)state;
    /* The first doubling of the bytes divides the error by ten, and the others by very little. */
    const psplat_row bent[] = {plain_row(100, 100, 1), plain_row(200, 10, 1), plain_row(400, 9, 1),
                               plain_row(800, 8, 1), plain_row(1600, 7, 1)};
    assert_int_equal(knee_of(bent, 5), 1);
    /* A straight line, and one that bulges outwards, have no knee: the best row is taken. */
    const psplat_row straight[] = {plain_row(1, 64, 1), plain_row(2, 32, 1), plain_row(4, 16, 1)};
    const psplat_row bulging[] = {plain_row(1, 64, 1), plain_row(2, 60, 1), plain_row(4, 1, 1)};
    assert_int_equal(knee_of(bulging, 3), 2);
    assert_true(knee_of(straight, 3) >= 1); /* rounding decides between the two finer ones */
    assert_int_equal(knee_of(straight, 2), 1);
    assert_int_equal(knee_of(bulging, 2), 0); /* twice the bytes for 60 instead of 64 */
    assert_int_equal(knee_of(straight, 1), 0);
    assert_int_equal(knee_of(straight, 0), 0);
    /* An error of 0 is the best value, and no failure. */
    const psplat_row exact[] = {plain_row(100, 5, 1), plain_row(200, 0, 1), plain_row(300, -1, 1)};
    assert_int_equal(knee_of(exact, 3), 1);
}

int test_pareto_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_front),          cmocka_unit_test(test_ties),
        cmocka_unit_test(test_missing_values), cmocka_unit_test(test_order),
        cmocka_unit_test(test_knee),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
