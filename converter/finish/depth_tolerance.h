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
 * that: neighbours on one surface are mostly closer. That of flat ones is a fifth of the tolerance.
 * A plane splat that is off its surface by no more than rounding to the grid makes of it is flat
 * where it is hardly off, where only such splats lie beside it, or where it hides another layer
 * that is nearer than the depth tolerance of the others along some ray. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_depth_tolerances_choose(psplat_conversion *c, float *depth, float *flat_depth);

#endif
