/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * grow_ellipse.h - the growth of a candidate's ellipse up to the limits.
 */
#ifndef PHONGSPLAT_FIT_GROW_ELLIPSE_H
#define PHONGSPLAT_FIT_GROW_ELLIPSE_H

#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"

#include <phongsplat/splat.h>

/* Makes both axes of a candidate's ellipse longer by up to a quarter, then each axis once more, as
 * far as the limits allow. The samples that it is recorded to cover stay the same. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_grow_ellipse(const psplat_fit_context *context, psplat_candidate *candidate);

/* How far an ellipse may grow: by a factor of up to `most`, found to within
 * (most - 1) / 2^(steps - 1). */
typedef struct psplat_ellipse_growth {
    double most;
    int steps;
    int keep_record; /* 1: the samples that the candidate is recorded to cover stay the same */
} psplat_ellipse_growth;

/* Makes the ellipse of a candidate as large as the limits allow, along both axes and then along
 * each. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_grow_ellipse_at(const psplat_fit_context *context, psplat_site *site,
                                     const psplat_ellipse_growth *growth,
                                     psplat_candidate *candidate);

#endif
