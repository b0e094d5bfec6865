/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * grow_candidate.h - region growing of the largest splat around a sample.
 */
#ifndef PHONGSPLAT_FIT_GROW_CANDIDATE_H
#define PHONGSPLAT_FIT_GROW_CANDIDATE_H

#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <phongsplat/splat.h>

/* Grows the largest candidate around a sample that keeps the limits: first in a round metric, then
 * in the metric of the curvature found (Wu, Kobbelt 2004). A candidate always exists: in the worst
 * case it covers the seed alone. psplat_candidate_free frees it. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_candidate_grow(const psplat_fit_context *context, uint32_t seed,
                                    psplat_candidate *candidate);

/* Finds again the samples that a candidate covers, after samples were appended. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_candidate_cover(const psplat_fit_context *context,
                                     psplat_candidate *candidate);

#endif
