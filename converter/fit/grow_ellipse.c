/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * grow_ellipse.c - the growth of a candidate's ellipse up to the limits, by bisection.
 *
 * Samples give a candidate its plane and axes, but they leave some of the tolerance unused. A
 * larger ellipse uses it, and makes splats overlap between samples, where no sample requires it.
 */
#include "fit/grow_ellipse.h"

#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/nearness.h"

/* How the ellipse of a taken candidate grows: by at most a quarter, found to within some percent.
 * Chosen by hand. */
static const psplat_ellipse_growth growth_of_taken = {.most = 1.25, .steps = 5, .keep_record = 1};

/* The least share of the ellipse's gain in area that its region must gain too. A region that lines
 * cut gains little by a larger ellipse, which only costs drawing time. Chosen by hand. */
static const double least_gain_share = 0.25;

/* Turns the frame so that the larger radius comes first. */
static void order_axes(psplat_region *region) {
    if (region->radius[0] >= region->radius[1]) return;
    double radius = region->radius[0];
    region->radius[0] = region->radius[1], region->radius[1] = radius;
    for (int k = 0; k < 3; ++k) {
        double u = region->u[k];
        region->u[k] = region->v[k], region->v[k] = -u;
    }
    double slope = region->slope[0], along = region->hessian[0];
    region->slope[0] = region->slope[1], region->slope[1] = -slope;
    region->hessian[0] = region->hessian[2], region->hessian[2] = along;
    region->hessian[1] = -region->hessian[1];
}

/* Makes the chosen axes of a region longer by a factor. */
static psplat_region stretched(const psplat_region *narrow, int axes, double factor) {
    psplat_region region = *narrow;
    for (int k = 0; k < 2; ++k)
        if (axes & (1 << k)) region.radius[k] *= factor;
    order_axes(&region);
    return region;
}

psplat_result psplat_grow_ellipse_at(const psplat_fit_context *context, psplat_site *site,
                                     const psplat_ellipse_growth *growth,
                                     psplat_candidate *candidate) {
    for (int axes = 3; axes > 0; --axes) { /* both, then each */
        const psplat_region narrow = candidate->region;
        double area = psplat_region_area(&narrow), kept = 1, broken = growth->most;
        for (int step = 0; step < growth->steps && kept < growth->most; ++step) {
            double factor = step ? (kept + broken) / 2 : growth->most;
            psplat_region region = stretched(&narrow, axes, factor);
            double gain = psplat_region_ellipse(&region) / psplat_region_ellipse(&narrow) - 1;
            psplat_fit_status status = psplat_candidate_replace(
                context, site, &region, area * (1 + least_gain_share * gain), growth->keep_record,
                candidate);
            if (status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
            if (status == PSPLAT_FIT_KEPT)
                kept = factor;
            else
                broken = factor;
        }
    }
    return PSPLAT_OK;
}

/* Proves the ellipse that a candidate has grown to or, where that fails, one halfway to what it was
 * before; where that fails too, the candidate stays as it was. It covers the same samples. */
static psplat_result settle(const psplat_fit_context *context, psplat_site *site,
                            const psplat_candidate *before, psplat_candidate *candidate) {
    int near = 0;
    psplat_region middle = candidate->region;
    if (psplat_region_ellipse(&middle) == psplat_region_ellipse(&before->region)) return PSPLAT_OK;
    if (psplat_limits_region_near(context->limits, &middle, &near)) return PSPLAT_ERROR_MEMORY;
    if (near) return PSPLAT_OK;
    *candidate = *before;
    if (dot3(middle.u, before->region.u) < 0.5) return PSPLAT_OK; /* The axes changed places. */
    for (int k = 0; k < 2; ++k)
        middle.radius[k] = (middle.radius[k] + before->region.radius[k]) / 2;
    return psplat_candidate_replace(context, site, &middle, 0, 1, candidate) == PSPLAT_FIT_MEMORY
               ? PSPLAT_ERROR_MEMORY
               : PSPLAT_OK;
}

psplat_result psplat_grow_ellipse(const psplat_fit_context *context, psplat_candidate *candidate) {
    if (!candidate->covered_count) return PSPLAT_OK;
    psplat_site site = psplat_site_of(&candidate->region, candidate->triangle);
    candidate->ellipse_grown = 1;
    if (!context->limits->proven)
        return psplat_grow_ellipse_at(context, &site, &growth_of_taken, candidate);
    psplat_limits limits;
    const psplat_fit_context draft = psplat_fit_draft(context, &limits);
    const psplat_candidate before = *candidate;
    psplat_result result = psplat_grow_ellipse_at(&draft, &site, &growth_of_taken, candidate);
    return result ? result : settle(context, &site, &before, candidate);
}
