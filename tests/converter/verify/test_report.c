/* SPDX-License-Identifier: MIT
 *
 * test_report.c - tests of the JSON writer for reports and for inspect: numbers, strings and
 * nesting.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/json_writer.h"
#include "verify/report.h"

static void assert_json(psplat_writer *json, const char *expected) {
    assert_true(psplat_writer_finish(json));
    assert_int_equal(json->size, strlen(expected));
    assert_memory_equal(json->text, expected, json->size);
    free(json->text);
}

static void test_layout(void **state) {
    (void)state;
    psplat_writer json = {0};
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_count(&json, "a", 1);
    psplat_writer_open(&json, "b", '[');
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_boolean(&json, "c", 1);
    psplat_writer_close(&json, '}');
    psplat_writer_close(&json, ']');
    psplat_writer_open(&json, "d", '[');
    psplat_writer_close(&json, ']');
    psplat_writer_close(&json, '}');
    assert_json(&json, "{\n  \"a\": 1,\n  \"b\": [\n    {\n      \"c\": true\n    }\n  ],\n"
                       "  \"d\": []\n}\n");
}

static void test_numbers_read_back_exactly(void **state) {
    (void)state;
    psplat_writer json = {0};
    const double numbers[] = {0.1, 1e300, -2.5, 1.0 / 3, 4};
    psplat_writer_numbers(&json, NULL, numbers, 5);
    assert_json(&json, "[0.1, 1e+300, -2.5, 0.3333333333333333, 4]\n");
    json = (psplat_writer){0};
    /* Integers are written without exponent as long as a double holds each of them. */
    const double integers[] = {0, 10, 60, -700, 123456789012, 1e15};
    psplat_writer_numbers(&json, NULL, integers, 6);
    assert_json(&json, "[0, 10, 60, -700, 123456789012, 1e+15]\n");
    json = (psplat_writer){0};
    const double none[] = {NAN, INFINITY, -INFINITY};
    psplat_writer_numbers(&json, NULL, none, 3);
    assert_json(&json, "[null, null, null]\n");
}

/* File names hold any bytes; JSON holds UTF-8. */
static void test_strings(void **state) {
    (void)state;
    psplat_writer json = {0};
    psplat_writer_string(&json, NULL, "a\"b\\c\n\xc3\xa9\xff\xe2\x82\xac\xed\xa0\x80\xc3");
    assert_json(&json, "\"a\\u0022b\\u005cc\\u000a\xc3\xa9\xef\xbf\xbd\xe2\x82\xac"
                       "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"\n");
}

static void test_report_names_every_field(void **state) {
    (void)state;
    const psplat_report report = {
        .splats = 15,
        .splats_by_clip_lines = {1, 2, 3, 4, 5},
        .bytes = 123456789012,
        .seconds = 0.25,
        .max_distance_percent = 0.5,
        .rms_normal_degrees = NAN,
        .uncovered_samples = 7,
        .promises[PSPLAT_PROMISE_COVERAGE] = {0.25, 0.5, 7},
        .places = {{PSPLAT_PROMISE_COVERAGE, {1, -2, 3e9}, 0.5, 0}},
        .place_count = 1,
    };
    char *text = NULL;
    size_t size = 0;
    assert_int_equal(psplat_report_json(&report, &text, &size, NULL), PSPLAT_OK);
    char *terminated = calloc(size + 1, 1);
    memcpy(terminated, text, size);
    const char *const members[] = {"\"splats\": 15,",
                                   "\"splats_by_clip_lines\": [1, 2, 3, 4, 5],",
                                   "\"bytes\": 123456789012,",
                                   "\"seconds\": 0.25,",
                                   "\"peak_memory_bytes\": 0,",
                                   "\"triangles\": 0,",
                                   "\"patches\": 0,",
                                   "\"crease_edges\": 0,",
                                   "\"border_edges\": 0,",
                                   "\"samples\": 0,",
                                   "\"verification_samples\": 0,",
                                   "\"diagonal\": 0,",
                                   "\"tolerance_percent\": 0,",
                                   "\"max_distance_percent\": 0.5,",
                                   "\"max_distance_surface_percent\": 0,",
                                   "\"max_distance_splats_percent\": 0,",
                                   "\"bound_distance_splats_percent\": 0,",
                                   "\"unproven_splats\": 0,",
                                   "\"unproven_surface_percent\": 0,",
                                   "\"rms_distance_percent\": 0,",
                                   "\"rms_normal_degrees\": null,",
                                   "\"p95_normal_degrees\": 0,",
                                   "\"rms_normal_constant_degrees\": 0,",
                                   "\"p95_normal_constant_degrees\": 0,",
                                   "\"max_normal_degrees\": 0,",
                                   "\"uncovered_samples\": 7,",
                                   "\"kept\": false,",
                                   "\"promises\": {\n    \"coverage\": {\n      \"given\": true,\n"
                                   "      \"kept\": false,\n      \"limit\": 0.25,\n"
                                   "      \"worst\": 0.5,\n      \"broken\": 7\n    },",
                                   "\"distance\": {",
                                   "\"normal\": {\n      \"given\": false,\n      \"kept\": true,",
                                   "\"crease\": {",
                                   "\"places\": [\n    {\n      \"promise\": \"coverage\",\n"
                                   "      \"position\": [1, -2, 3000000000],\n"
                                   "      \"value\": 0.5,\n      \"limit\": 0.25\n    }\n  ]\n}"};
    for (size_t i = 0; i < sizeof members / sizeof *members; ++i)
        if (!strstr(terminated, members[i])) fail_msg("no %s in %s", members[i], terminated);
    free(terminated);
    free(text);
}

int test_report_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layout),
        cmocka_unit_test(test_numbers_read_back_exactly),
        cmocka_unit_test(test_strings),
        cmocka_unit_test(test_report_names_every_field),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
