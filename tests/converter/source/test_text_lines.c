/* SPDX-License-Identifier: MIT
 *
 * test_text_lines.c - tests that numbers are read as the C library reads them, bit by bit, however
 * they are written.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/random.h"
#include "source/source_file.h"
#include "source/text_lines.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads text as a number. Returns whether it is one. */
static int read_number(const char *text, double *value) {
    char copy[64];
    strcpy(copy, text);
    psplat_source source = {.data = copy, .size = strlen(copy)};
    psplat_lines lines = psplat_lines_begin(&source);
    assert_true(psplat_lines_next(&lines));
    return psplat_lines_number(&lines, "it", value, NULL) == PSPLAT_OK;
}

static void check_number(const char *text) {
    double value, expected = strtod(text, NULL);
    if (!read_number(text, &value)) fail_msg("'%s' is no number", text);
    if (memcmp(&value, &expected, sizeof value) != 0)
        fail_msg("'%s' is %.17g instead of %.17g", text, value, expected);
}

static void test_written_by_hand(void **state) {
    (void)state;
    static const char *const texts[] = {"0",
                                        "-0",
                                        "+1",
                                        "1.",
                                        ".5",
                                        "-.5e1",
                                        "1e22",
                                        "9e-22",
                                        "1e23",
                                        "1e-23",
                                        "1E+05",
                                        "1e+0",
                                        "000000012.50",
                                        "0.1",
                                        "123456789012345",
                                        "9007199254740991",
                                        "9007199254740993",
                                        "9007199254740992.5",
                                        "0.000000000000001",
                                        "3.4028234e38",
                                        "1.17549435e-38",
                                        "4.9e-324",
                                        "0e99",
                                        "0e-99",
                                        "179769313486231570e1"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i) check_number(texts[i]);
}

static void test_refused(void **state) {
    (void)state;
    static const char *const texts[] = {
        "-",   "+",     ".",     "-.",    "e5",   "1e",   "1e+",
        "1ee", "1.2.3", "1e5.0", "1-",    "1e99", "4e38", "1e1000000000000",
        "0x1", "--1",   "+-1",   "1e+-2", "1,5"};
    double value;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        if (read_number(texts[i], &value)) fail_msg("'%s' is a number: %g", texts[i], value);
}

/* Numbers as programs write them, of all sizes that the reader has a way of its own for, and of
 * some that it has not. */
static void test_random(void **state) {
    (void)state;
    static const char *const formats[] = {"%.9g", "%.7g",  "%g",   "%.17g",
                                          "%f",   "%.12f", "%.3e", "%.15g"};
    uint64_t seed = 3;
    char text[64];
    for (int i = 0; i < 40000; ++i) {
        double size = 60 * psplat_random_unit(&seed) - 30;
        double value = (psplat_random_unit(&seed) - 0.5) * (i % 2 ? 4 : strtod("1e-3", NULL));
        if (i % 8 < 3) { /* the others are of the size of coordinates */
            snprintf(text, sizeof text, "%.17ge%d", value, (int)size);
            value = strtod(text, NULL);
        }
        int written = snprintf(text, sizeof text, formats[psplat_random_next(&seed) % 8], value);
        if (written < (int)sizeof text) check_number(text);
    }
}

int test_text_lines_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_written_by_hand),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_random),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
