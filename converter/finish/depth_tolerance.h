/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * depth_tolerance.h - how near layers have to be to be blended: the depth tolerances of splats
 * (spec 3.8).
 */
#ifndef PHONGSPLAT_FINISH_DEPTH_TOLERANCE_H
#define PHONGSPLAT_FINISH_DEPTH_TOLERANCE_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Chooses which of the candidates, which are all taken, are flat, and stores the depth tolerances
 * of those and of the others, lengths. That of the others is the greatest distance between two that
 * overlap on one surface, along their normal, but at least a quarter of the tolerance. Where much
 * of the surface has another layer that close beneath it, which would show through, it is half of
 * that: neighbours on one surface are mostly closer. Flat ones are plane and lie on plane faces but
 * for the rounding to the grid. They need next to nothing, and have it where they are hardly off
 * their face, have only such splats beside them, or hide another layer that is near along some ray.
 * Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_depth_tolerances_choose(psplat_conversion *c, float *depth, float *flat_depth);

#endif
