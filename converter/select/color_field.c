/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_field.c - the choice whether the colours of splats are constant or change linearly.
 *
 * A splat takes some 18 bytes with a linear colour instead of 13. Where paint has edges, as
 * textures do, that leaves much of the error of a constant one, and where all is of one colour
 * there is none. Where paint is smooth, as colours of vertices often are, it leaves little, and
 * splats become larger too where colours are what bounds them. So some splats are grown as a trial,
 * as large as linear colours let them be, and colours are fitted to them both ways. All splats of a
 * conversion have one or the other.
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

/* The greatest part of what constant colours err by that linear ones may leave (root mean squares)
 * where they are chosen, and the least part of the tolerance that the former err by. Smooth paint
 * leaves 0.1 to 0.55, textures 0.62 to 1.3; those of the Duck leave 0.6 of an error that is less
 * than a fifth of the tolerance. Chosen by hand. */
static const double most_left = 0.6, least_error = 0.2;

/* The numbers that a linear function has for each channel. */
enum { LINEAR_NUMBERS = 3 };

/* Returns the mean square of the differences of a candidate's colours from those of the samples
 * that it covers, over R, G and B of sRGB. As many numbers as fitted were fitted to each channel,
 * which is made up for, since they follow noise too. There must be more samples than that. */
static double mean_square(const psplat_samples *samples, const psplat_candidate *candidate,
                          size_t fitted) {
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
    return sum / (3 * (double)(candidate->covered_count - fitted));
}

/* Fits linear colours or constant ones to trials, and finds what they err by over all of them, as a
 * root mean square. Trials that cover too few samples to tell count as none. */
static psplat_result fit_trials(const psplat_samples *samples, int linear, psplat_selection *trials,
                                double *error) {
    psplat_result result = psplat_fit_colors(samples, linear, trials->candidates, trials->count);
    double sum = 0;
    for (size_t i = 0; i < trials->count && !result; ++i) {
        const psplat_candidate *candidate = &trials->candidates[i];
        if (candidate->covered_count > LINEAR_NUMBERS)
            sum += mean_square(samples, candidate, linear ? LINEAR_NUMBERS : 1);
    }
    *error = trials->count ? sqrt(sum / (double)trials->count) : 0;
    return result;
}

psplat_result psplat_color_field_choose(psplat_conversion *c) {
    psplat_limits *limits = &c->limits;
    psplat_selection trials = {0};
    double constant = 0, linear = 0;
    if (c->desc->color_field != PSPLAT_COLOR_FIELD_CHOSEN || !c->samples.colors ||
        !(limits->color_tolerance > 0) || !limits->constant_colors)
        return PSPLAT_OK;
    psplat_limits wide = *limits;
    wide.constant_colors = 0;
    psplat_fit_context context = psplat_conversion_context(c);
    context.limits = &wide;
    psplat_result result = psplat_selection_grow_trials(&context, &trials);
    for (size_t i = 0; i < trials.count; ++i) trials.candidates[i].taken = 1;
    if (!result) result = fit_trials(&c->samples, 0, &trials, &constant);
    if (!result) result = fit_trials(&c->samples, 1, &trials, &linear);
    psplat_selection_free(&trials);
    if (result) return result;
    if (constant > least_error * limits->color_tolerance && linear < most_left * constant)
        limits->constant_colors = 0;
    return PSPLAT_OK;
}
