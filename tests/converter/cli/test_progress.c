/* SPDX-License-Identifier: MIT
 *
 * test_progress.c - tests of the text of the progress line, for a clock that the test sets.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "cli/progress.h"
#include "pipeline/schedule.h"

static psplat_progress begin(void) {
    return (psplat_progress){.enabled = 1, .start = 1000, .left = -1};
}

/* Returns the number before a word of the line. */
static double number_before(const char *line, const char *word) {
    const char *end = strstr(line, word);
    if (!end) fail_msg("no '%s' in '%s'", word, line);
    while (end > line && strchr("0123456789 ", end[-1])) --end;
    double number = -1;
    assert_int_equal(sscanf(end, "%lf", &number), 1);
    return number;
}

/* Returns the time left after half of the work has taken so many seconds, which is the same again.
 */
static double left_at_half(double seconds, const char *unit) {
    static const char *const stages[] = {"selecting splats", "improving", "closing holes"};
    psplat_progress p = begin();
    for (int i = 0; i < 3000; ++i) {
        double fraction = i % 1000 / 1000.0;
        if (psplat_schedule_done(stages[i / 1000], fraction) < 0.5) continue;
        psplat_progress_update(&p, 1000 + seconds, stages[i / 1000], fraction);
        return number_before(p.shown, unit);
    }
    fail_msg("no stage is half of all");
    return -1;
}

static void test_estimate(void **state) {
    (void)state;
    assert_true(fabs(left_at_half(4, " s left") - 4) <= 1);   /* whole seconds */
    assert_true(fabs(left_at_half(42, " s left") - 45) <= 5); /* multiples of five */
    assert_true(fabs(left_at_half(600, " min left") - 10) <= 1);
}

static void test_silence_at_first(void **state) {
    (void)state;
    psplat_progress p = begin();
    assert_true(psplat_progress_update(&p, 1000, "reading", 0));
    assert_string_equal(p.shown, "0 %, reading");
    psplat_progress_update(&p, 1001.9, "selecting splats", 0.5);
    assert_null(strstr(p.shown, "left"));
    psplat_progress_update(&p, 1002.1, "selecting splats", 0.5);
    assert_non_null(strstr(p.shown, "left"));
    /* No estimate is given before any work is done. */
    p = begin();
    psplat_progress_update(&p, 1100, "reading", 0.1);
    assert_null(strstr(p.shown, "left"));
}

/* Stages that repeat, and unknown ones, do not lower the progress. */
static void test_never_falls(void **state) {
    (void)state;
    const char *const stages[] = {"sampling", "closing holes", "selecting splats", "unheard of",
                                  "writing"};
    psplat_progress p = begin();
    double before = -1;
    for (int i = 0; i < 50; ++i) {
        psplat_progress_update(&p, 1000 + i, stages[i / 10], i % 10 / 10.0);
        double percent = number_before(p.shown, " %");
        assert_true(percent >= before && percent <= 100);
        assert_non_null(strstr(p.shown, stages[i / 10]));
        before = percent;
    }
}

/* Where work proceeds evenly, the seconds left fall with the clock. */
static void test_even_pace(void **state) {
    (void)state;
    psplat_progress p = begin();
    for (int i = 0; i <= 1000; ++i) {
        double now = i * 0.1, part = i / 1000.0;
        psplat_progress_update(&p, 1000 + now, "searching", part);
        double done = psplat_schedule_done("searching", part);
        if (now > 20) assert_true(fabs(p.left - now * (1 - done) / done) < 0.25 * now);
    }
}

static void test_unchanged(void **state) {
    (void)state;
    psplat_progress p = begin();
    assert_true(psplat_progress_update(&p, 1000, "sampling", 0.5));
    assert_false(psplat_progress_update(&p, 1000.1, "sampling", 0.5));
    assert_true(psplat_progress_update(&p, 1000.2, "selecting splats", 0.5));
    /* a name longer than the line */
    char name[400];
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = 0;
    psplat_progress_update(&p, 1e9, name, 0.5);
    assert_true(strlen(p.shown) < sizeof p.shown && strstr(p.shown, "left"));
}

int test_progress_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_estimate),    cmocka_unit_test(test_silence_at_first),
        cmocka_unit_test(test_never_falls), cmocka_unit_test(test_even_pace),
        cmocka_unit_test(test_unchanged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
