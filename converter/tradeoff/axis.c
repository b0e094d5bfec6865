/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * axis.c - logarithmic axes: a range, and ticks at numbers that people read easily.
 */
#include "tradeoff.h"

#include <float.h>
#include <math.h>

/* Of the axis' length, kept free on either side of the data. */
static const double margin = 0.06;
/* An axis is never shorter, however alike the values are. */
static const double least_ratio = 1.5;

static void add_tick(psplat_axis *axis, double value, int is_labelled) {
    const double slack = 1 + 1e-9;
    if (axis->tick_count == PSPLAT_MOST_TICKS) return;
    if (value < axis->low / slack || value > axis->high * slack) return;
    axis->ticks[axis->tick_count] = value;
    axis->labelled[axis->tick_count++] = is_labelled;
}

static size_t count_labelled(const psplat_axis *axis) {
    size_t count = 0;
    for (size_t i = 0; i < axis->tick_count; ++i) count += axis->labelled[i] != 0;
    return count;
}

/* Ticks at mantissas 1 ... 9 of each decade, labels where the digit's bit is set. */
static void tick_decades(psplat_axis *axis, unsigned labelled, int step) {
    int first = (int)floor(log10(axis->low)), last = (int)ceil(log10(axis->high));
    axis->tick_count = 0;
    for (int decade = first; decade <= last; ++decade)
        for (int digit = 1; digit < 10; ++digit) {
            int is_labelled = (labelled >> digit & 1) && decade % step == 0;
            if (digit == 1 || last - first <= 6)
                add_tick(axis, digit * pow(10, decade), is_labelled);
        }
}

/* Within a decade: steps of 1, 2 or 5 times a power of ten, between 3 and 7 of them. */
static void tick_evenly(psplat_axis *axis) {
    double raw = (axis->high - axis->low) / 4, unit = pow(10, floor(log10(raw)));
    double step = raw >= 5 * unit ? 5 * unit : raw >= 2 * unit ? 2 * unit : unit;
    axis->tick_count = 0;
    for (double i = ceil(axis->low / step); i * step <= axis->high; ++i)
        add_tick(axis, i * step, 1);
}

static void set_ticks(psplat_axis *axis) {
    static const unsigned labelled[] = {1u << 1, 1u << 1 | 1u << 3, 1u << 1 | 1u << 2 | 1u << 5};
    double decades = log10(axis->high) - log10(axis->low);
    int step = decades > 8 ? (int)ceil(decades / 8) : 1;
    for (int i = 0; i < 3; ++i) {
        tick_decades(axis, labelled[i], step);
        if (count_labelled(axis) >= 4) return;
    }
    if (count_labelled(axis) < 3) tick_evenly(axis);
}

psplat_axis psplat_axis_fit(const double *values, size_t count) {
    double low = INFINITY, high = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!(values[i] > 0) || isinf(values[i])) continue;
        low = fmin(low, values[i]);
        high = fmax(high, values[i]);
    }
    if (isinf(low)) low = high = 1;
    double middle = 0.5 * (log(low) + log(high));
    double half = fmax(log(high) - log(low), log(least_ratio)) * (0.5 + margin);
    psplat_axis axis = {.low = fmax(exp(middle - half), DBL_MIN),
                        .high = fmin(exp(middle + half), DBL_MAX)};
    set_ticks(&axis);
    return axis;
}

double psplat_axis_place(const psplat_axis *axis, double value) {
    if (!(value > 0)) return 0;
    return (log(value) - log(axis->low)) / (log(axis->high) - log(axis->low));
}
