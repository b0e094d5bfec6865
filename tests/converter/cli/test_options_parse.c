/* SPDX-License-Identifier: MIT
 *
 * test_options_parse.c - tests of the option tables: every way to write a value, and values at both
 * ends of their ranges.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>
#include "cli/command.h"
#include "cli/options.h"
#include "select/conversion.h"
#include "select/effort.h"

typedef struct values {
    const char *first, *second;
    double tolerance, angle;
    uint64_t seed;
    int size[2], mode, count, effort, wipe, quiet;
    float color[4];
    psplat_operands more;
    int takes_more;
} values;

static const char *const mode_names[] = {"a", "bb", NULL};

/* Parses a NULL-terminated list of arguments. */
static psplat_parse parse(values *v, const char *const *list) {
    const psplat_option options[] = {
        {'o', "output", PSPLAT_OPTION_TEXT, &v->second, "OUT", "", 0, 0, NULL},
        {'t', "tolerance", PSPLAT_OPTION_PERCENT, &v->tolerance, "P", "", 0.1, 50, NULL},
        {0, "angle", PSPLAT_OPTION_NUMBER, &v->angle, "A", "", -90, 90, NULL},
        {0, "seed", PSPLAT_OPTION_UNSIGNED, &v->seed, "N", "", 0, 0, NULL},
        {0, "size", PSPLAT_OPTION_SIZE, v->size, "WxH", "", 1, 100, NULL},
        {0, "mode", PSPLAT_OPTION_CHOICE, &v->mode, "a|bb", "", 0, 0, mode_names},
        {'n', "count", PSPLAT_OPTION_COUNT, &v->count, "N", "", 1, 8, NULL},
        {0, "effort", PSPLAT_OPTION_EFFORT, &v->effort, "N", "", 0, 9, NULL},
        {'c', "color", PSPLAT_OPTION_COLOR, v->color, "C", "", 0, 0, NULL},
        {'w', "wipe", PSPLAT_OPTION_FLAG, &v->wipe, NULL, "", 0, 0, NULL},
        {'q', "quiet", PSPLAT_OPTION_FLAG, &v->quiet, NULL, "", 0, 0, NULL},
    };
    const psplat_syntax syntax = {.command = "test",
                                  .operands = "FIRST SECOND",
                                  .summary = "",
                                  .options = options,
                                  .option_count = sizeof options / sizeof *options,
                                  .slots = {&v->first, &v->second},
                                  .more = v->takes_more ? &v->more : NULL};
    char name[] = "test", *arguments[16] = {name};
    int count = 1;
    for (; *list; ++list) arguments[count++] = (char *)(uintptr_t)*list;
    return psplat_options_parse(&syntax, count, arguments);
}

#define PARSE(v, ...) parse(v, (const char *const[]){__VA_ARGS__, NULL})

static void test_spellings_of_a_value(void **state) {
    (void)state;
    const char *const spellings[][3] = {
        {"--tolerance", "0.5%", NULL}, {"--tolerance=0.5", NULL, NULL}, {"-t", "0.5", NULL},
        {"-t0.5%", NULL, NULL},        {"-wt0.5", NULL, NULL},          {"-qwt", "5e-1%", NULL},
        {"--tol", "0.5", NULL},        {"--t=0.5", NULL, NULL}};
    for (size_t i = 0; i < sizeof spellings / sizeof *spellings; ++i) {
        values v = {0};
        assert_int_equal(PARSE(&v, "in", "out", spellings[i][0], spellings[i][1], spellings[i][2]),
                         PSPLAT_PARSE_OK);
        assert_true(v.tolerance == 0.5);
    }
}

static void test_operands_fill_what_options_left(void **state) {
    (void)state;
    values v = {0};
    assert_int_equal(PARSE(&v, "in", "-o", "out"), PSPLAT_PARSE_OK);
    assert_string_equal(v.first, "in");
    assert_string_equal(v.second, "out");
    v = (values){0};
    assert_int_equal(PARSE(&v, "--output=out", "in"), PSPLAT_PARSE_OK);
    assert_string_equal(v.first, "in");
    v = (values){0};
    assert_int_equal(PARSE(&v, "-w", "--", "-q", "--tolerance"), PSPLAT_PARSE_OK);
    assert_string_equal(v.first, "-q");
    assert_string_equal(v.second, "--tolerance");
    assert_int_equal(v.quiet, 0);
    v = (values){0};
    assert_int_equal(PARSE(&v, "-", "-"), PSPLAT_PARSE_OK);
    assert_string_equal(v.first, "-");
}

static void test_wrong_operands(void **state) {
    (void)state;
    values v = {0};
    assert_int_equal(PARSE(&v, "in"), PSPLAT_PARSE_ERROR);
    v = (values){0};
    assert_int_equal(PARSE(&v, "in", "out", "more"), PSPLAT_PARSE_ERROR);
    v = (values){0};
    assert_int_equal(PARSE(&v, "in", "more", "-o", "out"), PSPLAT_PARSE_ERROR);
    v = (values){0};
    assert_int_equal(PARSE(&v, "in", ""), PSPLAT_PARSE_ERROR);
}

static void test_negative_numbers_are_values(void **state) {
    (void)state;
    values v = {0};
    assert_int_equal(PARSE(&v, "--angle", "-90", "in", "out"), PSPLAT_PARSE_OK);
    assert_true(v.angle == -90);
}

static void test_ends_of_ranges(void **state) {
    (void)state;
    values v = {0};
    assert_int_equal(PARSE(&v, "in", "out", "--size", "1x100", "-n8", "--seed",
                           "18446744073709551615", "--angle=90"),
                     PSPLAT_PARSE_OK);
    assert_int_equal(v.size[0], 1);
    assert_int_equal(v.size[1], 100);
    assert_int_equal(v.count, 8);
    assert_true(v.seed == UINT64_MAX);
    const char *const wrong[] = {"--size=0x1",   "--size=1x101",
                                 "--size=1x",    "--size=x1",
                                 "--size=1x1x1", "--size=-1x1",
                                 "-n0",          "-n9",
                                 "-n+1",         "-n99999999999",
                                 "--angle=90.1", "--angle=nan",
                                 "--angle=1%",   "--angle=",
                                 "-t0",          "-t0.5%%",
                                 "--seed=-1",    "--seed=18446744073709551616",
                                 "--mode=b",     "--mode=",
                                 "--mode=abb",   "--wipe=1",
                                 "--s=1",        "--tolerancee=1",
                                 "-x",           "-wx"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        values ignored = {0};
        if (PARSE(&ignored, wrong[i], "in", "out") != PSPLAT_PARSE_ERROR) fail_msg("%s", wrong[i]);
    }
}

/* An effort that is not given is 4; 0 is a valid effort and different from none given. */
static void test_efforts_are_those_of_conversions(void **state) {
    (void)state;
    const char *const given[] = {"--quiet", "--effort=2", "--effort=0", "--effort=1", "--effort=9"};
    const int rounds[] = {4, 2, 0, 1, 25};
    for (size_t i = 0; i < sizeof rounds / sizeof *rounds; ++i) {
        values v = {0};
        assert_int_equal(PARSE(&v, given[i], "in", "out"), PSPLAT_PARSE_OK);
        const psplat_convert_desc desc = {.effort = v.effort};
        assert_int_equal(psplat_effort_of(&desc).search_rounds, rounds[i]);
    }
}

static void test_colors(void **state) {
    (void)state;
    const char *const right[] = {"336699", "#336699", "51,102,153"};
    for (size_t i = 0; i < 3; ++i) {
        values v = {0};
        assert_int_equal(PARSE(&v, "--color", right[i], "in", "out"), PSPLAT_PARSE_OK);
        assert_true(v.color[0] == 51 / 255.0f && v.color[1] == 102 / 255.0f);
        assert_true(v.color[2] == 153 / 255.0f && v.color[3] == 1.0f);
    }
    values v = {.color = {1, 1, 1, 1}};
    assert_int_equal(PARSE(&v, "-c", "transparent", "in", "out"), PSPLAT_PARSE_OK);
    for (int i = 0; i < 4; ++i) assert_true(v.color[i] == 0.0f);
    const char *const wrong[] = {"33669", "3366999", "33669g", "256,0,0",
                                 "1,2",   "1,2,3,4", "1,,2",   ""};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        if (PARSE(&v, "-c", wrong[i], "in", "out") != PSPLAT_PARSE_ERROR) fail_msg("%s", wrong[i]);
}

static void test_absent_options_keep_defaults(void **state) {
    (void)state;
    values v = {.tolerance = 7, .mode = 1, .count = 3};
    assert_int_equal(PARSE(&v, "in", "out"), PSPLAT_PARSE_OK);
    assert_true(v.tolerance == 7);
    assert_int_equal(v.mode, 1);
    assert_int_equal(v.count, 3);
    assert_int_equal(PARSE(&v, "--mode", "a"), PSPLAT_PARSE_OK);
    assert_int_equal(v.mode, 0);
}

static void test_every_result_has_an_exit_code(void **state) {
    (void)state;
    assert_int_equal(psplat_exit_code(PSPLAT_OK), 0);
    for (int i = 1; i < PSPLAT_RESULT_COUNT; ++i) {
        int code = psplat_exit_code((psplat_result)i);
        assert_in_range(code, 1, 8);
        char line[16];
        snprintf(line, sizeof line, "\n  %d  ", code);
        assert_non_null(strstr(psplat_exit_help, line));
    }
}

/* Operands that are too many stand between those of the slots, where a command takes them. */
static void test_more_operands(void **state) {
    (void)state;
    values v = {.takes_more = 1};
    assert_int_equal(PARSE(&v, "a", "b", "-q", "c", "d"), PSPLAT_PARSE_OK);
    assert_string_equal(v.first, "a");
    assert_string_equal(v.second, "d");
    assert_int_equal(v.more.count, 2);
    v = (values){.takes_more = 1};
    assert_int_equal(PARSE(&v, "-o", "out", "a", "b"), PSPLAT_PARSE_OK);
    assert_string_equal(v.second, "out");
    assert_int_equal(v.more.count, 1);
    v = (values){.takes_more = 1};
    assert_int_equal(PARSE(&v, "a", "b"), PSPLAT_PARSE_OK);
    assert_int_equal(v.more.count, 0);
    v = (values){.takes_more = 1, .first = "given"};
    assert_int_equal(PARSE(&v, "a", "b"), PSPLAT_PARSE_ERROR);
    v = (values){.takes_more = 0};
    assert_int_equal(PARSE(&v, "a", "b", "c"), PSPLAT_PARSE_ERROR);
}

int test_options_parse_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_more_operands),
        cmocka_unit_test(test_spellings_of_a_value),
        cmocka_unit_test(test_operands_fill_what_options_left),
        cmocka_unit_test(test_wrong_operands),
        cmocka_unit_test(test_negative_numbers_are_values),
        cmocka_unit_test(test_ends_of_ranges),
        cmocka_unit_test(test_efforts_are_those_of_conversions),
        cmocka_unit_test(test_colors),
        cmocka_unit_test(test_absent_options_keep_defaults),
        cmocka_unit_test(test_every_result_has_an_exit_code),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
