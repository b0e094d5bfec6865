/* SPDX-License-Identifier: MIT
 *
 * test_sweep_table.c - tests of the table of a sweep: values come back bit by bit, rows are
 * recognised by their keys, and errors name the line. The tables are invented.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "invented_table.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "table/sweep_options.h"
#include "table/sweep_table.h"
#include "table/text.h"

static psplat_text write(const psplat_sweep_table *table) {
    psplat_text text = {0};
    psplat_sweep_table_write(table, &text);
    assert_false(text.failed);
    return text;
}

/* Returns the same table with no row measured. */
static psplat_sweep_table blank(const psplat_sweep_table *table) {
    psplat_sweep_table copy = *table;
    assert_int_equal(psplat_sweep_table_plan(&copy, NULL), PSPLAT_OK);
    return copy;
}

/* Returns how many rows of a blank table a text fills. */
static size_t recalled(psplat_sweep_table *table, const char *text, size_t size) {
    size_t count = 0;
    psplat_error error = {0};
    if (psplat_sweep_table_recall(table, text, size, &error)) fail_msg("%s", error.text);
    for (size_t i = 0; i < table->count; ++i) count += table->rows[i].is_measured != 0;
    return count;
}

static void test_round_trip(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(1), back = blank(&t);
    const double hard[] = {
        0.1,      1.0 / 3,   DBL_MAX, DBL_MIN,     5e-324, -0.0, 1e22, 123456789012345678.0,
        INFINITY, -INFINITY, NAN,     DBL_EPSILON, -1e-7};
    for (size_t i = 0; i < sizeof hard / sizeof *hard; ++i) t.rows[1].values[i] = hard[i];
    uint64_t seed = 7; /* the bits of a linear congruential generator, as numbers of any size */
    for (size_t i = 2; i < t.count; ++i)
        for (size_t k = 0; k < PSPLAT_COLUMN_COUNT; ++k) {
            seed = seed * UINT64_C(6364136223846793005) + 1442695040888963407u;
            memcpy(&t.rows[i].values[k], &seed, sizeof seed);
        }
    t.rows[5].is_measured = 0; /* this row is not written */
    psplat_text text = write(&t);
    assert_int_equal(recalled(&back, text.data, text.size), t.count - 1);
    for (size_t i = 0; i < t.count; ++i)
        for (int k = 0; k < PSPLAT_COLUMN_COUNT; ++k) {
            double x = t.rows[i].values[k], y = back.rows[i].values[k];
            if (isnan(x) || i == 5)
                assert_true(isnan(y));
            else
                assert_true(x == y); /* equal to the last bit */
        }
    psplat_text again = write(&back);
    assert_string_equal(again.data, text.data);
    free(text.data);
    free(again.data);
    psplat_sweep_table_free(&t);
    psplat_sweep_table_free(&back);
}

/* File names may contain any characters, and the table is still read back. */
static void test_strange_names(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(0);
    psplat_sweep_table_free(&t);
    t.source = "a,b \"c\"\n# d\r\x01.obj";
    psplat_sweep_table first = blank(&t), second = blank(&t);
    first.rows[3].is_measured = 1;
    psplat_text text = write(&first);
    assert_non_null(strstr(text.data, "\"a,b \"\"c\"\"?# d??.obj\""));
    assert_int_equal(recalled(&second, text.data, text.size), 1);
    assert_true(second.rows[3].is_measured);
    free(text.data);
    psplat_sweep_table_free(&first);
    psplat_sweep_table_free(&second);
}

/* A change of anything on which a row depends makes it another row; other changes do not. */
static void test_keys(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(1);
    psplat_text text = write(&t);
    for (int change = 0; change < 12; ++change) {
        psplat_sweep_table other = t;
        psplat_sweep_options *o = &other.options;
        size_t expected = 0;
        if (change == 0) other.source = "models/q.obj";
        if (change == 1) other.source_hash = 7;
        if (change == 2) strcpy(other.graphics, "Another GPU");
        if (change == 3) o->size = 256;
        if (change == 4) o->samples = 100;
        if (change == 5) o->crease_angle = 40;
        if (change == 6) o->no_creases = 1;
        if (change == 7) o->seed = UINT64_MAX, expected = 7; /* splats only */
        if (change == 8) o->effort = 1, expected = 7;
        if (change == 9) strcpy(other.gltfpack, "gltfpack 2"), expected = 26;
        if (change == 10) o->tolerances.count = 2, expected = 1 + 10 + 6;
        if (change == 11) o->frames = 5, expected = 32;
        psplat_sweep_table made = blank(&other);
        size_t found = recalled(&made, text.data, text.size);
        if (found != expected) fail_msg("change %d: %zu rows", change, found);
        psplat_sweep_table_free(&made);
    }
    free(text.data);
    psplat_sweep_table_free(&t);
}

static void assert_refused(psplat_sweep_table *table, const char *data, size_t size,
                           const char *expected) {
    psplat_error error = {0};
    assert_int_equal(psplat_sweep_table_recall(table, data, size, &error), PSPLAT_ERROR_FORMAT);
    if (strncmp(error.text, expected, strlen(expected)))
        fail_msg("'%s' instead of '%s'", error.text, expected);
}

/* A table may be cut off anywhere: rows of missing lines are measured again, and a partial line is
 * an error. */
static void test_truncated(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(0);
    psplat_text text = write(&t);
    for (size_t size = 0; size < 5000; size += 1 + size % 13) {
        psplat_sweep_table back = blank(&t);
        size_t lines = 0;
        for (size_t i = 0; i < size; ++i) lines += text.data[i] == '\n';
        char expected[32];
        snprintf(expected, sizeof expected, "line %zu: ", lines + 1);
        if (!size || text.data[size - 1] == '\n')
            assert_int_equal(recalled(&back, text.data, size), lines ? lines - 1 : 0);
        else
            assert_refused(&back, text.data, size, expected);
        psplat_sweep_table_free(&back);
    }
    free(text.data);
    psplat_sweep_table_free(&t);
}

static void test_causes(void **state) {
    (void)state;
    psplat_sweep_table t = make_table(0);
    psplat_text text = write(&t);
    assert_refused(&t, "a,b\n1,2\n", 8, "line 1: these are not the columns of a sweep");
    assert_refused(&t, "a,b", 3, "line 1: the line is cut off");
    char *end = strstr(strstr(text.data, "\nsplats,"), "\n") + 1;
    end = strchr(end, '\n'); /* the end of line 3 */
    end[-1] = 'x';
    assert_refused(&t, text.data, text.size, "line 3: a cell is not a number");
    end[-1] = '"';
    assert_refused(&t, text.data, text.size, "line 3: a cell is not a number");
    for (char *at = end; at[-1] != '\n'; --at)
        if (at[-1] == ',') at[-1] = ';';
    assert_refused(&t, text.data, text.size, "line 3: there are too few cells");
    free(text.data);
    psplat_sweep_table_free(&t);
}

static void test_options(void **state) {
    (void)state;
    psplat_ladder ladder;
    assert_true(psplat_ladder_read("0.5%,2,1,0.5", 0.1, 10, &ladder));
    assert_int_equal(ladder.count, 3);
    assert_true(ladder.steps[0] == 2 && ladder.steps[1] == 1 && ladder.steps[2] == 0.5);
    const char *const refused[] = {"",    ",",   "1,",   ",1",    "1,,2", "1 2", "nan",
                                   "0x1", "-1",  "11",   "0.05",  "1%%",  " 1",  "1e400",
                                   "inf", "1;2", "1,2 ", "1,2,x", "%",    "1e",  "+1"};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; ++i)
        if (psplat_ladder_read(refused[i], 0.1, 10, &ladder)) fail_msg("accepts '%s'", refused[i]);
    assert_int_equal(ladder.count, 3); /* unchanged */
    assert_false(psplat_ladder_read("1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1", 0.1, 10, &ladder));

    /* Given options stay, and the others get their defaults. */
    psplat_sweep_options given = {.size = 64, .no_creases = 1};
    psplat_sweep_options_complete(&given);
    assert_int_equal(given.size, 64);
    assert_int_equal(given.frames, 24);
    assert_int_equal(given.samples, 200000);
    assert_true(given.crease_angle == 0 && given.no_creases);
    assert_int_equal(given.tolerances.count, 5);
}

int test_sweep_table_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_strange_names),
        cmocka_unit_test(test_keys),       cmocka_unit_test(test_truncated),
        cmocka_unit_test(test_causes),     cmocka_unit_test(test_options),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
