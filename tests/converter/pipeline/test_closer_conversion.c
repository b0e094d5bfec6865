/* SPDX-License-Identifier: MIT
 *
 * test_closer_conversion.c - tests of conversions whose textures slide too far: they are made anew
 * for half of the tolerance and judged by the whole. The linker's --wrap puts a function in front
 * of psplat_verify that claims so, of a bumpy square whose textures do not slide.
 */
#include "appearance_fixture.h"

#include <math.h>
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/observations.h"
#include "verify/report.h"
#include "verify/verify.h"

enum { SIZE = 16, CELLS = 24, CLAIMED = 41, MOST_CALLS = 4 };

/* How many samples each call claims, from the first on, and the calls so far. */
static size_t claims[MOST_CALLS];
static int calls;

psplat_result __real_psplat_verify(const psplat_verification *verification, psplat_report *report,
                                   psplat_error *error);
psplat_result __wrap_psplat_verify(const psplat_verification *verification, psplat_report *report,
                                   psplat_error *error);

psplat_result __wrap_psplat_verify(const psplat_verification *verification, psplat_report *report,
                                   psplat_error *error) {
    psplat_result result = __real_psplat_verify(verification, report, error);
    assert_in_range(calls, 0, MOST_CALLS - 1);
    report->promises[PSPLAT_PROMISE_TEXTURE].broken += claims[calls++];
    return result;
}

static const psplat_convert_desc usual = {
    .tolerance_percent = 1, .precision = PSPLAT_USUAL_PRECISION, .effort = PSPLAT_EFFORT_NONE};

static void white(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    memset(rgba, 255, 4);
}

static int make(void **state) {
    static painted p;
    painted_make(&p, CELLS, SIZE, white);
    for (size_t i = 0; i < p.mesh.vertex_count; ++i) {
        double *at = p.mesh.positions + 3 * i;
        at[2] = 0.2 * sin(4 * at[0]) * sin(4 * at[1]);
    }
    *state = &p;
    return 0;
}

static int unmake(void **state) {
    painted_free(*state);
    return 0;
}

/* Converts, and returns the number of splats. */
static size_t convert(const painted *p, const psplat_convert_desc *desc, size_t first,
                      size_t second, psplat_report *report) {
    psplat_splats splats;
    psplat_observations seen = {0};
    psplat_error error;
    calls = 0;
    claims[0] = first, claims[1] = second;
    if (psplat_convert_observed(&p->mesh, desc, &splats, report, &seen, &error))
        fail_msg("%s", error.text);
    size_t count = splats.count;
    assert_int_equal(report->splats, count);
    psplat_observations_free(&seen);
    psplat_splats_free(&splats);
    return count;
}

/* What keeps more promises stays, and the larger splats of equals. */
static void test_better_stays(void **state) {
    psplat_convert_desc half = usual;
    psplat_report report;
    half.tolerance_percent = usual.tolerance_percent / 2;
    size_t whole_count = convert(*state, &usual, 0, 0, &report);
    assert_int_equal(calls, 1);
    double whole_distance = report.max_distance_percent;
    size_t half_count = convert(*state, &half, 0, 0, &report);
    assert_true(half_count > whole_count);
    assert_int_equal(convert(*state, &usual, CLAIMED, 0, &report), half_count);
    assert_int_equal(calls, 2);
    assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
    assert_true(report.max_distance_percent < whole_distance);
    assert_true(report.promises[PSPLAT_PROMISE_DISTANCE].limit == usual.tolerance_percent);
    assert_true(report.tolerance_percent == usual.tolerance_percent);
    assert_int_equal(convert(*state, &usual, CLAIMED, CLAIMED, &report), whole_count);
    assert_int_equal(calls, 2);
    assert_int_equal(report.promises[PSPLAT_PROMISE_TEXTURE].broken, CLAIMED);
    assert_true(report.max_distance_percent == whole_distance);
    assert_int_equal(convert(*state, &usual, CLAIMED, CLAIMED - 1, &report), half_count);
}

/* A tolerance in texels does not hang on that of distances. */
static void test_texels(void **state) {
    psplat_convert_desc texels = usual;
    psplat_report report;
    texels.texture_tolerance_texels = 4;
    convert(*state, &texels, CLAIMED, 0, &report);
    assert_int_equal(calls, 1);
    assert_int_equal(report.promises[PSPLAT_PROMISE_TEXTURE].broken, CLAIMED);
}

/* A draft gives what a conversion does. */
static void test_draft(void **state) {
    const painted *p = *state;
    psplat_report report, of_draft;
    psplat_splats splats;
    psplat_draft *draft;
    size_t count = convert(p, &usual, CLAIMED, 0, &report);
    assert_int_equal(psplat_draft_create(&p->mesh, &usual, &draft, NULL), PSPLAT_OK);
    calls = 0;
    assert_int_equal(psplat_draft_convert(draft, usual.precision, &splats, &of_draft, NULL),
                     PSPLAT_OK);
    assert_int_equal(calls, 2);
    assert_int_equal(splats.count, count);
    assert_true(of_draft.max_distance_percent == report.max_distance_percent);
    psplat_splats_free(&splats);
    psplat_draft_destroy(draft);
}

int test_closer_conversion_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_better_stays),
        cmocka_unit_test(test_texels),
        cmocka_unit_test(test_draft),
    };
    return cmocka_run_group_tests(tests, make, unmake);
}
