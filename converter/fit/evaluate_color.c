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

/* The square of r within which a splat has to be right at each sample of a range. Beyond, it weighs
 * little. Chosen by hand. */
static const double exact_part = 0.4;

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

/* Returns the range of looks around covered sample i, or NULL where it does not matter. */
static const float *range_at(const psplat_fit_context *context, size_t i) {
    const psplat_scratch *s = context->scratch;
    size_t sample = s->near.samples[s->covered[i]].index;
    if (sample >= context->limits->color_range_count) return NULL;
    const float *range = context->limits->color_ranges[sample];
    const double *uv = s->uv[i];
    if (uv[0] * uv[0] + uv[1] * uv[1] > exact_part) return NULL;
    return isnan(range[0]) ? NULL : range;
}

/* Returns the squared distance of a value from the range of value k of a look. */
static double squared_excess(const float *range, size_t k, double value) {
    double excess = max2(max2((double)range[k] - value, value - (double)range[8 + k]), 0);
    return excess * excess;
}

static psplat_fit_status evaluate_base_colors(const psplat_fit_context *context, size_t count) {
    const psplat_limits *limits = context->limits;
    psplat_moments moments;
    double fitted[3][3], squares = 0;
    double most = 3 * limits->color_tolerance * limits->color_tolerance;
    double limit = (double)count * most;
    psplat_moments_of((const double(*)[2])context->scratch->uv, count, !limits->constant_colors,
                      &moments);
    for (size_t k = 0; k < 3; ++k) fit_channel(context, count, k, &moments, fitted[k]);
    for (size_t i = 0; i < count && squares <= limit; ++i) {
        const double *uv = context->scratch->uv[i];
        const float *color = color_of(context, i), *range = range_at(context, i);
        double square = 0;
        for (size_t k = 0; k < 3; ++k) {
            double value = fitted[k][0] + uv[0] * fitted[k][1] + uv[1] * fitted[k][2];
            double shown = to_srgb(value), error = shown - to_srgb((double)color[k]);
            square += range ? squared_excess(range, k, shown) : error * error;
        }
        if (range && square > most) return PSPLAT_FIT_COLORS_DIFFER;
        squares += square;
    }
    return squares <= limit ? PSPLAT_FIT_KEPT : PSPLAT_FIT_COLORS_DIFFER;
}

/* Returns whether the mean of values, channels of them for each sample, is near enough to those of
 * the covered samples; as sRGB for light. first is the index of the values in a look. */
static int suits_mean(const psplat_fit_context *context, size_t count, const float *values,
                      size_t channels, size_t first) {
    const psplat_scratch *s = context->scratch;
    double tolerance = context->limits->color_tolerance;
    double most = (double)channels * tolerance * tolerance, mean[3] = {0}, squares = 0;
    int is_light = channels == 3;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < channels; ++k)
            mean[k] += (double)values[3 * (size_t)s->near.samples[s->covered[i]].index + k];
    for (size_t k = 0; k < channels; ++k) {
        mean[k] /= (double)count;
        if (is_light) mean[k] = to_srgb(mean[k]);
    }
    for (size_t i = 0; i < count; ++i) {
        const float *value = values + 3 * (size_t)s->near.samples[s->covered[i]].index;
        const float *range = range_at(context, i);
        double square = 0;
        for (size_t k = 0; k < channels; ++k) {
            double v = (double)value[k], d = mean[k] - (is_light ? to_srgb(v) : v);
            square += range ? squared_excess(range, first + k, mean[k]) : d * d;
        }
        if (range && square > most) return 0;
        squares += square;
    }
    return squares <= (double)count * most;
}

/* Checks emissive light, roughness and metallic, which are the same all over a splat. */
static psplat_fit_status evaluate_finishes(const psplat_fit_context *context, size_t count) {
    const psplat_samples *samples = context->samples;
    int suits = 1;
    if (samples->emissive) suits = suits_mean(context, count, samples->emissive, 3, 3);
    for (size_t k = 0; k < 2 && samples->finishes && suits; ++k)
        suits = suits_mean(context, count, samples->finishes + 1 + k, 1, 6 + k);
    return suits ? PSPLAT_FIT_KEPT : PSPLAT_FIT_COLORS_DIFFER;
}

psplat_fit_status psplat_evaluate_colors(const psplat_fit_context *context, size_t count) {
    if (!(context->limits->color_tolerance > 0)) return PSPLAT_FIT_KEPT;
    if (context->samples->colors && evaluate_base_colors(context, count))
        return PSPLAT_FIT_COLORS_DIFFER;
    return evaluate_finishes(context, count);
}
