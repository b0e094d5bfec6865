/* SPDX-License-Identifier: MIT
 * Quartiles, turns, and how much of a sweep is said to be done. Durations themselves are not
 * tested. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <tradeoff.h>

#include <math.h>
#include <string.h>

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

enum { CONTESTANTS = 3, VIEWS = 2, FRAMES = 5 };

/* Who drew what, in order. */
typedef struct diary {
    struct {
        int contestant;
        double view;
    } entries[64];
    size_t count;
} diary;

typedef struct diarist {
    diary *diary;
    int number;
} diarist;

static psplat_result note(void *self, const psplat_view *view, psplat_error *error) {
    diarist *d = self;
    (void)error;
    assert_true(d->diary->count < 64);
    d->diary->entries[d->diary->count].contestant = d->number;
    d->diary->entries[d->diary->count++].view = view->view[0];
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
    diary d = {.count = 0};
    diarist diarists[CONTESTANTS];
    psplat_contestant contestants[CONTESTANTS];
    psplat_frame_times times[CONTESTANTS];
    for (int i = 0; i < CONTESTANTS; ++i) {
        diarists[i] = (diarist){&d, i};
        contestants[i] = (psplat_contestant){note, &diarists[i]};
    }
    const psplat_view views[VIEWS] = {{.view = {1}, .width = 16, .height = 16},
                                      {.view = {2}, .width = 16, .height = 16}};
    double done = 0;
    psplat_timing_desc desc = {.host = host,
                               .views = views,
                               .view_count = VIEWS,
                               .contestants = contestants,
                               .count = CONTESTANTS,
                               .frames = FRAMES};
    assert_int_equal(psplat_timing_run(&desc, times, &error), PSPLAT_OK);
    /* Rounds: each contestant once, all of them the same view, views in turn; two do not count. */
    assert_int_equal(d.count, CONTESTANTS * (FRAMES + 2));
    for (size_t i = 0; i < d.count; ++i) {
        assert_int_equal(d.entries[i].contestant, i % CONTESTANTS);
        assert_true(d.entries[i].view == 1 + (double)(i / CONTESTANTS % VIEWS));
    }
    for (int i = 0; i < CONTESTANTS; ++i) {
        assert_true(times[i].wall.median >= 0 && times[i].cpu.median >= 0);
        assert_true(times[i].wall.low <= times[i].wall.median);
        assert_true(times[i].wall.median <= times[i].wall.high);
        assert_true(isnan(times[i].gpu.median)); /* software has none */
    }
    desc.progress = stop_after_half;
    desc.user = &done;
    assert_int_equal(psplat_timing_run(&desc, times, &error), PSPLAT_ERROR_INTERRUPTED);
    assert_true(done > 0.5 && done < 1);
    psplat_host_destroy(host);
}

static void test_estimate(void **state) {
    (void)state;
    psplat_estimate e = {.planned = {[PSPLAT_TASK_CONVERT] = 10, [PSPLAT_TASK_PICTURE] = 20}};
    double last = 0;
    assert_true(psplat_estimate_done(&e, PSPLAT_TASK_CONVERT, 0) == 0);
    /* Conversions take ten seconds a share, pictures one: after the first of each that is known. */
    for (int i = 0; i < 10; ++i) {
        assert_true(psplat_estimate_done(&e, PSPLAT_TASK_CONVERT, 0.5) >= last);
        e.done[PSPLAT_TASK_CONVERT] += 1;
        e.seconds[PSPLAT_TASK_CONVERT] += 10;
        e.done[PSPLAT_TASK_PICTURE] += 2;
        e.seconds[PSPLAT_TASK_PICTURE] += 2;
        last = psplat_estimate_done(&e, PSPLAT_TASK_CONVERT, 0);
        assert_true(fabs(last - 0.1 * (i + 1)) < 1e-9); /* rounding */
    }
    /* A kind that nothing is known of goes as slowly as the others against the guess. */
    psplat_estimate slow = {.planned = {[PSPLAT_TASK_CONVERT] = 1, [PSPLAT_TASK_SHAPE] = 1},
                            .done = {[PSPLAT_TASK_CONVERT] = 1},
                            .seconds = {[PSPLAT_TASK_CONVERT] = 1000}};
    double half = psplat_estimate_done(&slow, PSPLAT_TASK_SHAPE, 0);
    assert_true(half > 0.3 && half < 0.7);
    const psplat_estimate nothing = {.planned = {0}};
    assert_true(psplat_estimate_done(&nothing, PSPLAT_TASK_TIME, 0) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quartiles),
        cmocka_unit_test(test_turns),
        cmocka_unit_test(test_estimate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
