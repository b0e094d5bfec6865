/* SPDX-License-Identifier: MIT
 * Journals are exact, and what is wrong with one is noticed in its line. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "rows.h"

#include <float.h>
#include <stdio.h>

static void assert_same(const psplat_journal *a, const psplat_journal *b) {
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; ++i) {
        const psplat_row *x = &a->rows[i], *y = &b->rows[i];
        assert_true(psplat_setting_is_same(&x->setting, &y->setting));
        assert_memory_equal(x->stamps, y->stamps, sizeof x->stamps);
        assert_true(x->content == y->content);
        for (int k = 0; k < PSPLAT_COLUMN_COUNT; ++k)
            if (isnan(x->values[k]))
                assert_true(isnan(y->values[k]));
            else
                assert_true(x->values[k] == y->values[k]); /* to the last bit */
    }
    assert_string_equal(a->source, b->source);
    assert_string_equal(a->graphics, b->graphics);
    assert_string_equal(a->gltfpack, b->gltfpack);
}

static psplat_text write(const psplat_journal *journal) {
    psplat_text text = {0};
    psplat_journal_write(journal, &text);
    assert_false(text.failed);
    return text;
}

static void test_round_trip(void **state) {
    (void)state;
    psplat_journal j = make_journal(1), back;
    const double hard[] = {
        0.1,      1.0 / 3,   DBL_MAX, DBL_MIN,     5e-324, -0.0, 1e22, 123456789012345678.0,
        INFINITY, -INFINITY, NAN,     DBL_EPSILON, -1e-7};
    for (size_t i = 0; i < sizeof hard / sizeof *hard; ++i) j.rows[1].values[i] = hard[i];
    uint64_t seed = 7; /* a linear congruential generator's bits as numbers of any size */
    for (size_t i = 2; i < j.count; ++i)
        for (size_t k = 0; k < PSPLAT_COLUMN_COUNT; ++k) {
            seed = seed * UINT64_C(6364136223846793005) + 1442695040888963407u;
            memcpy(&j.rows[i].values[k], &seed, sizeof seed);
        }
    j.options.seed = UINT64_MAX;
    j.options.crease_angle = 33.3;
    psplat_text text = write(&j);
    assert_int_equal(psplat_journal_read(text.data, text.size, &back, NULL), PSPLAT_OK);
    assert_same(&j, &back);
    assert_memory_equal(&j.options.tolerances.steps, &back.options.tolerances.steps,
                        5 * sizeof(double));
    assert_true(back.options.seed == UINT64_MAX);
    assert_true(back.options.crease_angle == 33.3);
    psplat_text again = write(&back);
    assert_int_equal(again.size, text.size);
    assert_memory_equal(again.data, text.data, text.size);
    free(text.data);
    free(again.data);
    psplat_journal_free(&j);
    psplat_journal_free(&back);
}

/* Names of files may hold anything; the journal stays one. */
static void test_strange_names(void **state) {
    (void)state;
    psplat_journal j = {.options = psplat_tradeoff_options_default()}, back;
    strcpy(j.source, "a,b \"c\"\n# d\r\x01.obj");
    psplat_text text = write(&j);
    assert_int_equal(psplat_journal_read(text.data, text.size, &back, NULL), PSPLAT_OK);
    assert_string_equal(back.source, "a,b \"c\"?# d??.obj");
    assert_int_equal(back.count, 0);
    free(text.data);
}

static void assert_refused(const char *data, size_t size, const char *expected) {
    psplat_journal back;
    psplat_error error = {0};
    assert_int_equal(psplat_journal_read(data, size, &back, &error), PSPLAT_ERROR_FORMAT);
    assert_null(back.rows);
    if (strncmp(error.text, expected, strlen(expected)))
        fail_msg("'%s' instead of '%s'", error.text, expected);
}

/* Cut off anywhere: whole lines that are gone are measured again, others are noticed. */
static void test_truncated(void **state) {
    (void)state;
    psplat_journal j = make_journal(0), back;
    j.count = 8;
    psplat_text text = write(&j);
    size_t lines = 0, rows_from = 7; /* six comments and the names */
    for (size_t size = 0; size < text.size; size += 1 + size % 13) {
        lines = 0;
        for (size_t i = 0; i < size; ++i) lines += text.data[i] == '\n';
        int is_whole = size && text.data[size - 1] == '\n';
        psplat_error error = {0};
        psplat_result result = psplat_journal_read(text.data, size, &back, &error);
        if (is_whole && lines >= rows_from) {
            assert_int_equal(result, PSPLAT_OK);
            assert_int_equal(back.count, lines - rows_from);
            psplat_journal_free(&back);
            continue;
        }
        char expected[32];
        snprintf(expected, sizeof expected, "line %zu: ", lines + 1);
        assert_int_equal(result, PSPLAT_ERROR_FORMAT);
        assert_memory_equal(error.text, expected, strlen(expected));
    }
    free(text.data);
    psplat_journal_free(&j);
}

/* Any byte changed to another, one at a time, is noticed, and in its line or, among the comments,
 * in the line of their check sum. */
static void test_changed_bytes(void **state) {
    (void)state;
    psplat_journal j = make_journal(0);
    j.count = 2;
    psplat_text text = write(&j);
    const char replacements[] = {'7', ',', '\n', '-', 0, (char)0xff, ' '};
    for (size_t at = 0; at < text.size; ++at)
        for (size_t k = 0; k < sizeof replacements; ++k) {
            char before = text.data[at];
            if (before == replacements[k]) continue;
            text.data[at] = replacements[k];
            assert_refused(text.data, text.size, "line ");
            text.data[at] = before;
        }
    free(text.data);
    psplat_journal_free(&j);
}

static void test_causes(void **state) {
    (void)state;
    psplat_journal j = make_journal(0);
    psplat_text text = write(&j);
    assert_refused("", 0, "line 1: the line is cut off");
    assert_refused("a,b\n1,2\n", 8, "line 1: this is no journal");
    assert_refused("# phongsplat tradeoff 2\n", 24, "line 1: this is no journal");
    char *row = strstr(text.data, "\nsplats,");
    assert_non_null(row);
    row[1] = 'S';
    assert_refused(text.data, text.size, "line 9: the row was changed by something else");
    row[1] = 's';
    char *comma = strchr(row, ',');
    *comma = ';';
    assert_refused(text.data, text.size, "line 9: the number of cells is wrong");
    *comma = ',';
    char *names = strstr(text.data, "\ncontender");
    names[1] = 'C';
    assert_refused(text.data, text.size, "line 7: the columns are not those of this version");
    names[1] = 'c';
    char *options = strstr(text.data, "size=512");
    options[5] = '6';
    assert_refused(text.data, text.size, "line 6: the lines above were changed");
    free(text.data);
    psplat_journal_free(&j);
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
    assert_int_equal(ladder.count, 3); /* as it was */
    assert_false(psplat_ladder_read("1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1", 0.1, 10, &ladder));

    /* What is given stays, the rest comes from before, and from the defaults what neither has. */
    psplat_tradeoff_options given = {.size = 64}, before = {.size = 128, .frames = 5};
    const psplat_tradeoff_options defaults = psplat_tradeoff_options_default();
    before.crease_angle = 40;
    given.no_creases = 1;
    psplat_tradeoff_options_inherit(&given, &before);
    psplat_tradeoff_options_inherit(&given, &defaults);
    assert_int_equal(given.size, 64);
    assert_int_equal(given.frames, 5);
    assert_int_equal(given.samples, 200000);
    assert_true(given.crease_angle == 0 && given.no_creases);
    assert_int_equal(given.tolerances.count, 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_strange_names),
        cmocka_unit_test(test_truncated),  cmocka_unit_test(test_changed_bytes),
        cmocka_unit_test(test_causes),     cmocka_unit_test(test_options),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
