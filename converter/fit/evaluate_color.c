/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate_color.c - the check whether one colour that may change linearly over a region is near
 * enough to those of the samples in it.
 *
 * The error is the root mean square over the samples and over red, green and blue, in sRGB.
 */
#include "base/vector.h"
#include "fit/color_fit.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"

#include <math.h>

/* Approximates sRGB to within 0.001 by square roots. These are faster than pow, which would be
 * called for each sample of each evaluation. */
static double to_srgb(double linear) {
    if (!(linear > 0.0031308)) return linear > 0 ? 12.92 * linear : 0;
    double a = sqrt(min2(linear, 1)), b = sqrt(a), c = sqrt(b);
    return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * min2(linear, 1);
}

/* Returns the colour of covered sample i, linear R G B A. */
static const float *color_of(const psplat_fit_context *context, size_t i) {
    const psplat_scratch *s = context->scratch;
    return context->samples->colors + 4 * (size_t)s->near.samples[s->covered[i]].index;
}

/* Fits value(u, v) = fitted[0] + u fitted[1] + v fitted[2] to a channel of covered samples, whose
 * parameters have these moments. */
static void fit_channel(const psplat_fit_context *context, size_t count, size_t channel,
                        const psplat_moments *moments, double fitted[3]) {
    double sum = 0, along[2] = {0, 0};
    for (size_t i = 0; i < count; ++i) {
        double value = (double)color_of(context, i)[channel];
        sum += value;
        for (int j = 0; j < 2; ++j)
            along[j] += value * (context->scratch->uv[i][j] - moments->mean[j]);
    }
    psplat_moments_solve(moments, sum / (double)count, along, fitted);
}

psplat_fit_status psplat_evaluate_colors(const psplat_fit_context *context, size_t count) {
    const psplat_limits *limits = context->limits;
    if (!context->samples->colors || !(limits->color_tolerance > 0)) return PSPLAT_FIT_KEPT;
    psplat_moments moments;
    double fitted[3][3], squares = 0;
    double limit = 3 * (double)count * limits->color_tolerance * limits->color_tolerance;
    psplat_moments_of((const double(*)[2])context->scratch->uv, count, !limits->constant_colors,
                      &moments);
    for (size_t k = 0; k < 3; ++k) fit_channel(context, count, k, &moments, fitted[k]);
    for (size_t i = 0; i < count && squares <= limit; ++i) {
        const double *uv = context->scratch->uv[i];
        const float *color = color_of(context, i);
        for (int k = 0; k < 3; ++k) {
            double value = fitted[k][0] + uv[0] * fitted[k][1] + uv[1] * fitted[k][2];
            double error = to_srgb(value) - to_srgb((double)color[k]);
            squares += error * error;
        }
    }
    return squares <= limit ? PSPLAT_FIT_KEPT : PSPLAT_FIT_COLORS_DIFFER;
}
