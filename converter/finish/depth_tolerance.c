/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * depth_tolerance.c - the depth tolerance of splats that are not flat.
 */
#include "finish/depth_tolerance.h"

#include "features/samples.h"
#include "fit/candidate.h"
#include "measure/hidden_samples.h"
#include "select/selection.h"

#include <math.h>

/* All of these were chosen by hand. */
/* The least tolerance of depth, in tolerances. */
static const double least_tolerances = 0.25;
/* The share of the samples with a layer beneath from which on half the depth is better. */
static const double layered_share = 0.02, layered_part = 0.5;
/* Every how many samples are asked. */
enum { SAMPLE_STEP = 4 };

/* Finds the share of the samples beneath which another layer lies within a depth. */
static psplat_result find_layered_share(const psplat_conversion *c, double depth, double *share) {
    size_t layered = 0, count = 0;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < c->samples.count && !result; i += SAMPLE_STEP) {
        int is_over;
        result = psplat_sample_hides(&c->surface, &c->samples, c->distance, depth, i, &is_over);
        layered += !result && is_over;
        ++count;
    }
    *share = (double)layered / fmax((double)count, 1);
    return result;
}

psplat_result psplat_depth_tolerance_choose(const psplat_conversion *c, float *depth) {
    double deviation = 0, share;
    for (size_t i = 0; i < c->selection.count; ++i)
        deviation = fmax(deviation, c->selection.candidates[i].deviation);
    psplat_result result = find_layered_share(c, 2 * deviation, &share);
    double part = !result && share >= layered_share ? layered_part : 1;
    *depth = (float)fmax(2 * deviation * part, least_tolerances * c->tolerance);
    return result;
}
