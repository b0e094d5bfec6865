/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * enclose.h - a candidate whose ellipse encloses a given set of samples.
 */
#ifndef PHONGSPLAT_FIT_ENCLOSE_H
#define PHONGSPLAT_FIT_ENCLOSE_H

#include "base/covariance.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <phongsplat/splat.h>

/* Makes a candidate that encloses a set of count samples, in the plane fitted to them (relative to
 * origin), as large as the limits allow. It covers nothing where the limits allow no such
 * candidate. psplat_candidate_free frees it. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_candidate_enclose(const psplat_fit_context *context, const uint32_t *set,
                                       size_t count, const double origin[3],
                                       const psplat_plane *plane, psplat_candidate *candidate);

#endif
