/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * estimate.c - how much of a sweep is done: shares of each kind of task, at the rate at which those
 * of its kind went, or, before the first, at a guess in proportion to the others.
 */
#include "tradeoff.h"

#include <math.h>

/* Of one share of each kind, on a model of middle size. */
static const double guessed_seconds[PSPLAT_TASK_COUNT] = {
    [PSPLAT_TASK_CONVERT] = 2, [PSPLAT_TASK_SIMPLIFY] = 0.7, [PSPLAT_TASK_SHAPE] = 2,
    [PSPLAT_TASK_PICTURE] = 2, [PSPLAT_TASK_TIME] = 0.02,
};

/* Conversions take longer the more splats they place, and something in any case. */
double psplat_estimate_conversion(double tolerance_percent) {
    return 1 + 0.5 / tolerance_percent;
}

/* How much slower than guessed everything went that is done; 1 before anything is. */
static double slowness(const psplat_estimate *e) {
    double taken = 0, guessed = 0;
    for (int i = 0; i < PSPLAT_TASK_COUNT; ++i) {
        taken += e->seconds[i];
        guessed += e->done[i] * guessed_seconds[i];
    }
    return taken > 0 && guessed > 0 ? taken / guessed : 1;
}

static double rate(const psplat_estimate *e, int task) {
    if (e->done[task] > 0 && e->seconds[task] > 0) return e->seconds[task] / e->done[task];
    return guessed_seconds[task] * slowness(e);
}

double psplat_estimate_done(const psplat_estimate *estimate, psplat_task task, double shares) {
    double all = 0, done = 0;
    for (int i = 0; i < PSPLAT_TASK_COUNT; ++i) {
        double also = i == (int)task ? shares : 0;
        all += rate(estimate, i) * fmax(estimate->planned[i], estimate->done[i] + also);
        done += rate(estimate, i) * (estimate->done[i] + also);
    }
    return all > 0 ? fmin(done / all, 1) : 0;
}
