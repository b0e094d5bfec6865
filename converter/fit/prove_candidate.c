/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * prove_candidate.c - the proof that all of a candidate is near the surface, and the repair of
 * those that are not.
 *
 * Evaluations measure a region at some hundred points, between which it may leave the surface. That
 * of a candidate that is taken is bounded over all points.
 */
#include "fit/prove_candidate.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/region_near.h"

#include <string.h>

/* How often a candidate shrinks, and by which factor. Most leave the surface by little. Chosen by
 * hand. */
enum { SHRINKINGS = 16 };
static const double shrink_factor = 0.96;

/* The radius of the disc that is left where shrinking does not help, in tolerances. */
static const double disc_tolerances = 0.5;

/* Shrinks a candidate around its centre until it is within the tolerance. It must still cover its
 * first sample or, where that fails, the sample in its middle. */
static psplat_fit_status shrink(const psplat_fit_context *context, psplat_candidate *candidate) {
    psplat_site site = psplat_site_of(&candidate->region, candidate->triangle);
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    const psplat_region old = candidate->region;
    size_t count = candidate->covered_count;
    for (int of_seed = 1; of_seed >= 0; --of_seed) {
        psplat_region tried = old;
        candidate->covered_count = count;
        if (!of_seed) psplat_candidate_put_nearest_first(context->samples, old.center, candidate);
        for (int i = 0; i < SHRINKINGS; ++i) {
            for (int k = 0; k < 2; ++k) tried.radius[k] *= shrink_factor;
            candidate->covered_count = 1;
            status = psplat_candidate_replace(context, &site, &tried, 0, 0, candidate);
            if (!status || status == PSPLAT_FIT_MEMORY) return status;
        }
    }
    return status;
}

/* Makes the candidate a flat disc around its first sample, which it covers alone. */
static psplat_result make_disc(const psplat_fit_context *context, psplat_candidate *candidate) {
    uint32_t sample = candidate->covered[0], triangle = context->samples->triangles[sample];
    double radius = disc_tolerances * context->limits->tolerance;
    psplat_region disc = {.radius = {radius, radius}};
    memcpy(disc.center, context->samples->positions + 3 * (size_t)sample, sizeof disc.center);
    memcpy(disc.n, context->surface->face_normals + 3 * (size_t)triangle, sizeof disc.n);
    perpendicular3(disc.u, disc.n);
    cross3(disc.v, disc.n, disc.u);
    psplat_site site = psplat_site_of(&disc, triangle);
    psplat_evaluation one =
        psplat_evaluate_single_sample(context, &site, &disc, disc.center, sample, 0);
    if (one.status) return PSPLAT_ERROR_MEMORY;
    return psplat_candidate_set(context, &site, &one, 1, candidate);
}

psplat_result psplat_prove_candidate(const psplat_fit_context *context,
                                     psplat_candidate *candidate) {
    const psplat_limits *limits = context->limits;
    int near;
    if (psplat_region_near(&candidate->region, limits->distance, limits->tolerance, &near))
        return PSPLAT_ERROR_MEMORY;
    candidate->proven = 1;
    if (near || !candidate->covered_count) return PSPLAT_OK;
    psplat_fit_status status = shrink(context, candidate);
    if (status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    return status ? make_disc(context, candidate) : PSPLAT_OK;
}
