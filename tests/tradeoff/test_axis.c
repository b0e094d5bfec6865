/* SPDX-License-Identifier: MIT
 * Ticks of logarithmic axes: enough of them, not too many, at numbers that are easy to read. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <tradeoff.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Digits that a label takes. */
static size_t digits(double value) {
    char text[40];
    snprintf(text, sizeof text, "%.6e", value);
    size_t count = strcspn(text, "e");
    while (count && (text[count - 1] == '0' || text[count - 1] == '.')) --count;
    return count > 1 ? count - 1 : count;
}

static void assert_axis(double low, double high) {
    const double values[] = {high, NAN, low, 0, -1, INFINITY};
    psplat_axis axis = psplat_axis_fit(values, 6);
    size_t labelled = 0;
    assert_true(axis.low > 0 && axis.low < low && axis.high > high);
    /* Room on either side, but not more than data. */
    double data = fmax(log(high) - log(low), log(1.5));
    assert_true(log(axis.high) - log(axis.low) < 1.15 * data);
    for (size_t i = 0; i < axis.tick_count; ++i) {
        assert_true(!i || axis.ticks[i] > axis.ticks[i - 1]);
        double place = psplat_axis_place(&axis, axis.ticks[i]);
        assert_true(place >= 0 && place <= 1);
        if (!axis.labelled[i]) continue;
        ++labelled;
        assert_true(digits(axis.ticks[i]) <= 3);
    }
    if (labelled < 3 || labelled > 13) fail_msg("%g ... %g: %zu labels", low, high, labelled);
}

static void test_ticks(void **state) {
    (void)state;
    for (double ratio = 1; ratio < 1e13; ratio *= 1.37)
        for (double low = 1.1e-9; low < 1e9; low *= 7.7) assert_axis(low, low * ratio);
    assert_axis(1000, 1000);
    assert_axis(0.999, 1.001);
    assert_axis(99, 101);
}

static void test_extremes(void **state) {
    (void)state;
    assert_axis(1e-200, 1e200);
    /* Nothing to show is an axis all the same. */
    const double nothing[] = {NAN, 0, -3, INFINITY};
    psplat_axis axis = psplat_axis_fit(nothing, 4);
    assert_true(axis.low < 1 && axis.high > 1 && axis.tick_count > 0);
    axis = psplat_axis_fit(nothing, 0);
    assert_true(axis.low < 1 && axis.high > 1);
}

static void test_places(void **state) {
    (void)state;
    const double values[] = {1, 100};
    psplat_axis axis = psplat_axis_fit(values, 2);
    assert_true(fabs(psplat_axis_place(&axis, 10) - 0.5) < 1e-12); /* rounding */
    assert_true(psplat_axis_place(&axis, axis.low) == 0);
    assert_true(psplat_axis_place(&axis, 0) == 0);
    assert_true(psplat_axis_place(&axis, -5) == 0);
    assert_true(psplat_axis_place(&axis, NAN) == 0);
    assert_true(psplat_axis_place(&axis, axis.low / 10) < 0);
    assert_true(psplat_axis_place(&axis, DBL_MAX) > 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ticks),
        cmocka_unit_test(test_extremes),
        cmocka_unit_test(test_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
