/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_crossings.h - creases and borders that lie too deep inside a splat of their own patch.
 */
#ifndef PHONGSPLAT_MEASURE_CREASE_CROSSINGS_H
#define PHONGSPLAT_MEASURE_CREASE_CROSSINGS_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "features/surface.h"
#include "measure/crease_spill.h"
#include "measure/measured_splats.h"

#include <stddef.h>

/* Finds the crossings deeper than limit, a length, and stores them in *crossings (*count, malloc'ed
 * and owned by the caller) in the order of splats and then edges. *greatest becomes the greatest
 * depth of the crossings stored or, where there are none, of those up to limit. Two sorts of
 * crossings are left out: of creases that do not bound a sheet of the splat's own, and of those
 * beyond which nothing is seen to be wrong (crease_spill.h). Of the sheets of its material, that of
 * which the splat covers most samples is its own, and any other of which it covers more than
 * least_share, 0 to 1, times as many, less the root of that number: with 1 there is no other, and
 * with less all are where the splat covers few samples. So is that of the triangle which it
 * grew from, where measured tells. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_crease_crossings_find(const psplat_surface *surface,
                                           const psplat_samples *samples,
                                           const psplat_measured_splats *measured, double limit,
                                           double least_share, psplat_crease_crossing **crossings,
                                           size_t *count, double *greatest);

#endif
