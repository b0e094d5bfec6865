/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * widen.c - an ellipse made as large as its limits allow.
 *
 * Growth finds plane and axes from samples; what is left of the tolerance beyond them is used up
 * here, and makes splats overlap where samples cannot ask for it.
 */
#include "trial.h"

/* How much larger what is taken becomes, and to what precision: some percent. */
static const double greatest_widening = 1.25;
enum { STEPS = 5 };

/* Part of what the ellipse gains that its region must: cut by lines, a larger one only costs. */
static const double least_gain = 0.25;

static double ellipse_area(const psplat_region *region) {
    return region->radius[0] * region->radius[1];
}

void psplat_trial_widen(psplat_seedling *s, psplat_candidate *candidate, double most, int steps) {
    for (int axes = 3; axes > 0; --axes) { /* both, then each */
        const psplat_region narrow = candidate->region;
        double area = psplat_region_area(&narrow), kept = 1, broken = most;
        for (int step = 0; step < steps && kept < most && !s->failed; ++step) {
            double factor = step ? (kept + broken) / 2 : most;
            psplat_region region = narrow;
            for (int k = 0; k < 2; ++k)
                if (axes & (1 << k)) region.radius[k] *= factor;
            double gain = ellipse_area(&region) / ellipse_area(&narrow) - 1;
            psplat_trial_order_axes(&region);
            if (psplat_trial_accept(s, &region, area * (1 + least_gain * gain), candidate))
                kept = factor;
            else
                broken = factor;
        }
    }
}

psplat_result psplat_candidate_widen(const psplat_surface *surface, const psplat_samples *samples,
                                     const psplat_limits *limits, psplat_growth *growth,
                                     psplat_candidate *candidate) {
    if (!candidate->covered_count) return PSPLAT_OK;
    psplat_seedling s =
        psplat_trial_at(surface, samples, limits, growth, &candidate->region, candidate->triangle);
    s.recorded = 1;
    psplat_trial_widen(&s, candidate, greatest_widening, STEPS);
    candidate->widened = 1;
    return s.failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
