/* SPDX-License-Identifier: MIT
 *
 * test_effort.c - a test of what efforts buy: more effort never buys less.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "select/conversion.h"
#include "select/effort.h"

/* The least effort asks for a round of rays alone, and each one for more rounds of search than the
 * one before, and for no fewer of rays. Where none is given it is the default. */
static void test_order(void **state) {
    (void)state;
    const psplat_convert_desc least = {.effort = PSPLAT_EFFORT_NONE}, usual = {0};
    psplat_effort before = psplat_effort_of(&least);
    assert_int_equal(before.search_rounds, 0);
    assert_int_equal(before.ray_rounds, 1);
    for (int i = 1; i <= PSPLAT_GREATEST_EFFORT; ++i) {
        const psplat_convert_desc desc = {.effort = i};
        psplat_effort now = psplat_effort_of(&desc);
        assert_true(now.search_rounds > before.search_rounds);
        assert_true(now.ray_rounds >= before.ray_rounds);
        if (i == PSPLAT_DEFAULT_EFFORT) {
            psplat_effort chosen = psplat_effort_of(&usual);
            assert_int_equal(chosen.search_rounds, now.search_rounds);
            assert_int_equal(chosen.ray_rounds, now.ray_rounds);
        }
        before = now;
    }
}

int test_effort_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_order)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
