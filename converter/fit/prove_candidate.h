/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * prove_candidate.h - the proof that all of a candidate is near the surface.
 */
#ifndef PHONGSPLAT_FIT_PROVE_CANDIDATE_H
#define PHONGSPLAT_FIT_PROVE_CANDIDATE_H

#include <phongsplat/splat.h>

#include "fit/candidate.h"
#include "fit/fit_context.h"

/* Proves that all points of a candidate's region are within the tolerance of the mesh. Where that
 * fails, the candidate shrinks until it is proven; then it covers fewer samples, in the end one
 * alone. It must not lie on the grid yet. The context's limits are `proven`. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_prove_candidate(const psplat_fit_context *context,
                                     psplat_candidate *candidate);

#endif
