/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_field.c - the choice whether the colours of splats are constant or change linearly.
 *
 * A linear colour takes some five bytes more of a splat's 13. Where paint has edges, as textures
 * do, it leaves much of the error of a constant one, and where all is of one colour there is none.
 * Where paint is smooth, as colours of vertices often are, it leaves little, and splats become
 * larger too where colours are what bounds them. So some splats are grown as a trial, and
 * their colours are fitted both ways.
 */
#include "select/color_field.h"

#include "base/region.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/color_fit.h"
#include "fit/fit_context.h"
#include "material/mipmap.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* The greatest part of what constant colours err by that linear ones may leave (root mean squares)
 * where they are chosen, and the least part of the tolerance that the former err by. Smooth paint
 * leaves 0.1 to 0.7, textures 0.87 to 0.96; those of the Duck leave 0.7 of an error that is an
 * eighth of the tolerance. Chosen by hand. */
static const double most_left = 0.8, least_error = 0.2;
/* The number of splats that are grown as a trial. */
enum { TRIAL_SPLATS = 128 };

/* Returns the mean square of what a candidate's colours differ from those of the samples that it
 * covers, over R, G and B of sRGB. */
static double mean_square(const psplat_samples *samples, const psplat_candidate *candidate) {
    const psplat_finish *finish = &candidate->finish;
    double sum = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        size_t sample = candidate->covered[i];
        double uvh[3];
        psplat_region_local(&candidate->region, samples->positions + 3 * sample, uvh);
        for (size_t k = 0; k < 3; ++k) {
            double shown = (double)candidate->color[k] + uvh[0] * (double)finish->color_u[k] +
                           uvh[1] * (double)finish->color_v[k];
            double error = (double)psplat_srgb_of_linear((float)shown) -
                           (double)psplat_srgb_of_linear(samples->colors[4 * sample + k]);
            sum += error * error;
        }
    }
    return sum / (3 * (double)candidate->covered_count);
}

/* Returns the mean of those over trials, which are drawn by area, with linear colours or without.
 */
static psplat_result fit_trials(const psplat_samples *samples, int linear, psplat_selection *trials,
                                double *square) {
    psplat_result result = psplat_fit_colors(samples, linear, trials->candidates, trials->count);
    *square = 0;
    for (size_t i = 0; i < trials->count && !result; ++i)
        if (trials->candidates[i].covered_count)
            *square += mean_square(samples, &trials->candidates[i]) / (double)trials->count;
    return result;
}

psplat_result psplat_color_field_choose(psplat_conversion *c) {
    psplat_limits *limits = &c->limits;
    psplat_selection trials = {0};
    uint32_t seeds[TRIAL_SPLATS];
    double constant = 0, linear = 0;
    if (c->desc->color_field != PSPLAT_COLOR_FIELD_CHOSEN || !c->samples.colors ||
        !(limits->color_tolerance > 0) || !limits->constant_colors)
        return PSPLAT_OK;
    const psplat_fit_context context = psplat_conversion_context(c);
    size_t count = c->samples.count < TRIAL_SPLATS ? c->samples.count : TRIAL_SPLATS;
    for (size_t i = 0; i < count; ++i) seeds[i] = (uint32_t)(i * c->samples.count / count);
    psplat_result result = psplat_selection_grow(&context, seeds, count, &trials);
    for (size_t i = 0; i < trials.count; ++i) trials.candidates[i].taken = 1;
    if (!result) result = fit_trials(&c->samples, 0, &trials, &constant);
    if (!result) result = fit_trials(&c->samples, 1, &trials, &linear);
    psplat_selection_free(&trials);
    if (result) return result;
    if (sqrt(constant) > least_error * limits->color_tolerance &&
        sqrt(linear) < most_left * sqrt(constant))
        limits->constant_colors = 0;
    return PSPLAT_OK;
}
