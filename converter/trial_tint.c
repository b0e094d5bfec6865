/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * trial_tint.c - whether one colour, changing linearly over a region, is near enough to those of
 * the samples in it.
 */
#include "trial.h"

#include "vector.h"

/* sRGB to within 0.001 by square roots, since it is asked of each sample of each trial. */
static double screen(double linear) {
    if (!(linear > 0.0031308)) return linear > 0 ? 12.92 * linear : 0;
    double a = sqrt(min2(linear, 1)), b = sqrt(a), c = sqrt(b);
    return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * min2(linear, 1);
}

static const float *color_of(const psplat_seedling *s, size_t i) {
    const psplat_growth *g = s->growth;
    return s->samples->colors + 4 * (size_t)g->near.samples[g->chosen[i]].index;
}

/* Fits value(u, v) = fit[0] + u fit[1] + v fit[2] to channel k of growth->chosen; mean and spread
 * are those of their parameters. */
static void fit_channel(const psplat_seedling *s, size_t count, size_t k,
                        const psplat_moments *moments, double fitted[3]) {
    double sum = 0, along[2] = {0, 0};
    for (size_t i = 0; i < count; ++i) {
        double value = (double)color_of(s, i)[k];
        sum += value;
        for (int j = 0; j < 2; ++j) along[j] += value * (s->growth->local[i][j] - moments->mean[j]);
    }
    psplat_moments_solve(moments, sum / (double)count, along, fitted);
}

int psplat_trial_tint(const psplat_seedling *s, size_t count) {
    if (!s->samples->colors || !(s->limits->color_tolerance > 0)) return 1;
    psplat_moments moments;
    double fitted[3][3], squares = 0;
    double limit = 3 * (double)count * s->limits->color_tolerance * s->limits->color_tolerance;
    psplat_moments_of((const double(*)[2])s->growth->local, count, !s->limits->constant_colors,
                      &moments);
    for (size_t k = 0; k < 3; ++k) fit_channel(s, count, k, &moments, fitted[k]);
    for (size_t i = 0; i < count && squares <= limit; ++i) {
        const double *uv = s->growth->local[i];
        const float *color = color_of(s, i);
        for (int k = 0; k < 3; ++k) {
            double value = fitted[k][0] + uv[0] * fitted[k][1] + uv[1] * fitted[k][2];
            double error = screen(value) - screen((double)color[k]);
            squares += error * error;
        }
    }
    return squares <= limit;
}
