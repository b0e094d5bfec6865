/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * depth_tolerance.h - the depth tolerance of splats that are not flat (spec 3.8).
 */
#ifndef PHONGSPLAT_FINISH_DEPTH_TOLERANCE_H
#define PHONGSPLAT_FINISH_DEPTH_TOLERANCE_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Stores the depth tolerance, a length, of the taken candidates: the greatest distance between two
 * of them that overlap on one surface, along their normal, but at least a quarter of the tolerance.
 * Where much of the surface has another layer that close beneath it, which would show through, half
 * of that: neighbours on one surface are mostly closer. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_depth_tolerance_choose(const psplat_conversion *c, float *depth);

#endif
