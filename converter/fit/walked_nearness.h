/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * walked_nearness.h - the check of the distance bound by a walk over the triangles under a region.
 */
#ifndef PHONGSPLAT_FIT_WALKED_NEARNESS_H
#define PHONGSPLAT_FIT_WALKED_NEARNESS_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "mesh/distance.h"

/* Finds whether all points of a region lie within the tolerance, a length, of the mesh, whose tree
 * knows the triangles across edges. *is_known becomes 0 where the walk cannot tell, as the region
 * does not lie over the mesh like a lid; else *near becomes 1 where that is proven, and 0 where it
 * is not. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_walked_nearness(const psplat_region *region, const psplat_distance *distance,
                                     double tolerance, int *is_known, int *near);

#endif
