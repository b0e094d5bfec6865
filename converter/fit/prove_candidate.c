/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * prove_candidate.c - the proof that all of a candidate is near the surface, and the repair of
 * those that are not.
 *
 * Drafts measure a region at some hundred points, between which it may leave the surface. That of a
 * candidate is bounded over all points.
 */
#include "fit/prove_candidate.h"

#include "base/region.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/nearness.h"

/* How often a candidate shrinks, and by which factor at first; each factor is that times the one
 * before, so that few steps go far. Most leave the surface by little. Chosen by hand. */
enum { SHRINKINGS = 9 };
static const double shrink_factor = 0.96;

/* Makes a sample the first of those that a candidate covers. Returns 0 where it is none of them. */
static int put_first(uint32_t sample, psplat_candidate *candidate) {
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        if (candidate->covered[i] != sample) continue;
        candidate->covered[i] = candidate->covered[0];
        candidate->covered[0] = sample;
        return 1;
    }
    return 0;
}

/* Shrinks a candidate around its centre until it is within the tolerance. It must still cover its
 * first sample, and record that: a greedy cover would grow around that sample again and again. */
static psplat_fit_status shrink(const psplat_fit_context *context, psplat_candidate *candidate) {
    psplat_site site = psplat_site_of(&candidate->region, candidate->triangle);
    site.seed = candidate->covered[0];
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    psplat_region tried = candidate->region;
    double factor = shrink_factor;
    for (int i = 0; i < SHRINKINGS && status && status != PSPLAT_FIT_MEMORY; ++i) {
        for (int k = 0; k < 2; ++k) tried.radius[k] *= factor;
        factor *= shrink_factor;
        candidate->covered_count = 1;
        status = psplat_candidate_replace(context, &site, &tried, 0, 0, candidate);
        if (status == PSPLAT_FIT_SAMPLES_LOST) break; /* A smaller one would lose it, too. */
    }
    return status;
}

psplat_result psplat_prove_candidate(const psplat_fit_context *context, uint32_t sample,
                                     psplat_candidate *candidate, int *proven) {
    const psplat_region wide = psplat_region_beyond_charts(&candidate->region);
    if (psplat_limits_region_near(context->limits, &wide, proven)) return PSPLAT_ERROR_MEMORY;
    if (*proven || !put_first(sample, candidate)) return PSPLAT_OK;
    psplat_fit_status status = shrink(context, candidate);
    *proven = !status;
    return status == PSPLAT_FIT_MEMORY ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
