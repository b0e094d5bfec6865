/* SPDX-License-Identifier: MIT
 *
 * test_frame_timing.c - tests of quartiles, of their precision, of the order in which frames are
 * timed, and of the progress of a sweep. Durations themselves are not tested.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>
#include "benchmark/frame_timing.h"
#include "table/setting.h"
#include "benchmark/sweep_progress.h"

static void assert_quartiles(const double *values, size_t count, double low, double median,
                             double high) {
    double copy[16];
    memcpy(copy, values, count * sizeof *copy);
    psplat_quartiles q = psplat_timing_quartiles(copy, count);
    assert_true(fabs(q.low - low) < 1e-12); /* rounding of an interpolation */
    assert_true(fabs(q.median - median) < 1e-12);
    assert_true(fabs(q.high - high) < 1e-12);
}

static void test_quartiles(void **state) {
    (void)state;
    assert_quartiles((double[]){5, 1, 4, 2, 3}, 5, 2, 3, 4);
    assert_quartiles((double[]){4, 1, 3, 2}, 4, 1.75, 2.5, 3.25);
    assert_quartiles((double[]){7}, 1, 7, 7, 7);
    assert_quartiles((double[]){1, 2}, 2, 1.25, 1.5, 1.75);
    assert_true(isnan(psplat_timing_quartiles(NULL, 0).median));
    double missing[] = {NAN, NAN};
    assert_true(isnan(psplat_timing_quartiles(missing, 2).high));
}

/* The middle half of normally distributed values is 1.349 standard deviations wide, and the
 * standard error of the median of n of them is 1.253 standard deviations over the root of n. */
static void test_precise(void **state) {
    (void)state;
    const psplat_quartiles q = {.median = 10, .low = 10 - 1.349 / 2, .high = 10 + 1.349 / 2};
    const psplat_quartiles none = {NAN, NAN, NAN}, exact = {.median = 3, .low = 3, .high = 3};
    assert_true(psplat_timing_is_precise(&q, 16, 1.01 * 0.1253 / 4));
    assert_false(psplat_timing_is_precise(&q, 16, 0.99 * 0.1253 / 4));
    assert_true(psplat_timing_is_precise(&q, 25, 1.01 * 0.1253 / 5));
    assert_true(psplat_timing_is_precise(&exact, 1, 0.001));
    assert_false(psplat_timing_is_precise(&none, 16, 0.05));
}

enum { TIMED = 3, VIEWS = 2, FRAMES = 5 };

/* The frames drawn, in order. */
typedef struct frame_log {
    struct {
        int frame;
        double view;
    } entries[64];
    size_t count;
} frame_log;

typedef struct frame_logger {
    frame_log *log;
    int number;
} frame_logger;

static psplat_result note(void *self, const psplat_view *view, psplat_error *error) {
    frame_logger *d = self;
    (void)error;
    assert_true(d->log->count < 64);
    d->log->entries[d->log->count].frame = d->number;
    d->log->entries[d->log->count++].view = view->view[0];
    return PSPLAT_OK;
}

static int stop_after_half(void *user, double fraction) {
    *(double *)user = fraction;
    return fraction > 0.5;
}

static void test_turns(void **state) {
    (void)state;
    psplat_host *host = NULL;
    psplat_error error;
    assert_int_equal(psplat_host_create(PSPLAT_API_GL, 1, &host, &error), PSPLAT_OK);
    frame_log d = {.count = 0};
    frame_logger loggers[TIMED];
    psplat_timed_frame timed[TIMED];
    psplat_frame_times times[TIMED];
    for (int i = 0; i < TIMED; ++i) {
        loggers[i] = (frame_logger){&d, i};
        timed[i] = (psplat_timed_frame){note, &loggers[i]};
    }
    const psplat_view views[VIEWS] = {{.view = {1}, .width = 16, .height = 16},
                                      {.view = {2}, .width = 16, .height = 16}};
    double done = 0;
    psplat_timing_desc desc = {.host = host,
                               .views = views,
                               .view_count = VIEWS,
                               .timed = timed,
                               .count = TIMED,
                               .rounds = FRAMES};
    assert_int_equal(psplat_timing_run(&desc, times, &error), PSPLAT_OK);
    /* In each round every frame is drawn once, all of the same view; views alternate. Two rounds
     * are not timed. */
    assert_int_equal(d.count, TIMED * (FRAMES + 2));
    for (size_t i = 0; i < d.count; ++i) {
        assert_int_equal(d.entries[i].frame, i % TIMED);
        assert_true(d.entries[i].view == 1 + (double)(i / TIMED % VIEWS));
    }
    for (int i = 0; i < TIMED; ++i) {
        assert_true(times[i].wall.median >= 0 && times[i].cpu.median >= 0);
        assert_true(times[i].wall.low <= times[i].wall.median);
        assert_true(times[i].wall.median <= times[i].wall.high);
        assert_true(isnan(times[i].gpu.median)); /* a software driver has no GPU time */
    }
    for (int i = 0; i < TIMED; ++i) assert_int_equal(times[i].frames, FRAMES);
    /* Any error suffices: one turn of the views is drawn. None does: all rounds are. */
    desc.precision = 1e9;
    d.count = 0;
    assert_int_equal(psplat_timing_run(&desc, times, &error), PSPLAT_OK);
    assert_int_equal(d.count, TIMED * (VIEWS + 2));
    for (int i = 0; i < TIMED; ++i) assert_int_equal(times[i].frames, VIEWS);
    desc.precision = 1e-12;
    d.count = 0;
    assert_int_equal(psplat_timing_run(&desc, times, &error), PSPLAT_OK);
    assert_int_equal(d.count, TIMED * (FRAMES + 2));
    assert_int_equal(times[TIMED - 1].frames, FRAMES);
    desc.precision = 0;
    desc.progress = stop_after_half;
    desc.user = &done;
    d.count = 0;
    assert_int_equal(psplat_timing_run(&desc, times, &error), PSPLAT_ERROR_INTERRUPTED);
    assert_true(done > 0.5 && done < 1);
    psplat_host_destroy(host);
}

static int note_progress(void *user, const char *what, double fraction) {
    double *last = user;
    assert_true(what[0] && fraction >= *last && fraction <= 1);
    *last = fraction;
    return 0;
}

static int stop(void *user, const char *what, double fraction) {
    (void)user, (void)what, (void)fraction;
    return 1;
}

/* Work is planned as it will run, and ends at 1; finer conversions take a larger share. */
static void test_progress(void **state) {
    (void)state;
    double last = 0, coarse = 0;
    psplat_sweep_progress p = {.report = note_progress, .user = &last};
    const psplat_setting settings[] = {{.competitor = PSPLAT_COMPETITOR_SPLATS, .tolerance = 2},
                                       {.competitor = PSPLAT_COMPETITOR_SPLATS, .tolerance = 0.1}};
    for (int i = 0; i < 2; ++i)
        for (int task = PSPLAT_TASK_MAKE; task <= PSPLAT_TASK_TIME; ++task)
            psplat_sweep_progress_plan(&p, (psplat_task)task, &settings[i]);
    for (int i = 0; i < 2; ++i)
        for (int task = PSPLAT_TASK_MAKE; task <= PSPLAT_TASK_PICTURE; ++task) {
            double before = last;
            assert_int_equal(psplat_sweep_progress_begin(&p, (psplat_task)task, &settings[i], NULL),
                             PSPLAT_OK);
            psplat_sweep_progress_show(&p, 0.5);
            psplat_sweep_progress_show(&p, 1);
            if (task != PSPLAT_TASK_MAKE) continue;
            assert_string_equal(p.what, i ? "converting 0.1 %" : "converting 2 %");
            if (i)
                assert_true(last - before > 2 * coarse);
            else
                coarse = last - before;
        }
    assert_true(last < 1);
    assert_int_equal(psplat_sweep_progress_begin(&p, PSPLAT_TASK_TIME, settings, NULL), PSPLAT_OK);
    psplat_sweep_progress_show(&p, 1);
    assert_true(last > 1 - 1e-12); /* rounding */
    p.report = stop;
    assert_int_equal(psplat_sweep_progress_begin(&p, PSPLAT_TASK_TIME, settings, NULL),
                     PSPLAT_ERROR_INTERRUPTED);
}

int test_frame_timing_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quartiles),
        cmocka_unit_test(test_precise),
        cmocka_unit_test(test_turns),
        cmocka_unit_test(test_progress),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
