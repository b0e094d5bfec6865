/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * prove_candidate.h - the proof that all of a candidate is near the surface.
 */
#ifndef PHONGSPLAT_FIT_PROVE_CANDIDATE_H
#define PHONGSPLAT_FIT_PROVE_CANDIDATE_H

#include <phongsplat/splat.h>

#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <stdint.h>

/* Proves that all points of a candidate's region are within the tolerance of the mesh. Where that
 * fails, the candidate shrinks until it is proven, while it covers a sample that it covers now.
 * *proven becomes 0 where that fails too; then only that sample is meaningful in the candidate. The
 * candidate must not lie on the grid yet. The context's limits are `proven`. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_prove_candidate(const psplat_fit_context *context, uint32_t sample,
                                     psplat_candidate *candidate, int *proven);

#endif
