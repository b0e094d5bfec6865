/* SPDX-License-Identifier: MIT
 *
 * test_sort_values.c - tests of the sorting of numbers, of few and of many, against comparisons.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <float.h>
#include <math.h>
#include <cmocka.h>

#include "base/random.h"
#include "base/sort_values.h"

enum { MOST = 20000 };

static int ascending(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return a < b ? -1 : a > b;
}

/* Fills the values with numbers of all magnitudes, some of them equal, 0 or extreme. */
static void fill(double *values, size_t count, uint64_t seed) {
    static const double special[] = {0, -0.0, DBL_MIN / 8, DBL_MAX, INFINITY, 1, 1};
    for (size_t i = 0; i < count; ++i) {
        double exponent = 80 * psplat_random_unit(&seed) - 40;
        values[i] = i % 16 ? exp(exponent) : special[i / 16 % (sizeof special / sizeof *special)];
    }
}

static void test_sorted(void **state) {
    (void)state;
    static const size_t counts[] = {0, 1, 2, 17, 999, 1000, MOST};
    static double values[MOST], expected[MOST];
    for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
        fill(values, counts[k], k);
        memcpy(expected, values, counts[k] * sizeof *values);
        qsort(expected, counts[k], sizeof *expected, ascending);
        psplat_sort_values(values, counts[k]);
        for (size_t i = 0; i < counts[k]; ++i) assert_true(values[i] == expected[i]);
    }
}

/* Values that differ in one digit alone, or not at all. */
static void test_alike(void **state) {
    (void)state;
    static double values[MOST];
    for (size_t i = 0; i < MOST; ++i) values[i] = 2;
    psplat_sort_values(values, MOST);
    for (size_t i = 0; i < MOST; ++i) assert_true(values[i] == 2);
    for (size_t i = 0; i < MOST; ++i) values[i] = 1 + (double)(MOST - i) * DBL_EPSILON;
    psplat_sort_values(values, MOST);
    for (size_t i = 0; i < MOST; ++i) assert_true(values[i] == 1 + (double)(i + 1) * DBL_EPSILON);
}

int test_sort_values_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sorted),
        cmocka_unit_test(test_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
