/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_near.h - the check of the distance bound: whether all of a region lies within the
 * tolerance of the mesh.
 */
#ifndef PHONGSPLAT_FIT_REGION_NEAR_H
#define PHONGSPLAT_FIT_REGION_NEAR_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "mesh/distance.h"

/* Finds whether all points of a region lie within the tolerance, a length, of the mesh. *near
 * becomes 1 where that is proven, or where distance is NULL. Fails only with PSPLAT_ERROR_MEMORY.
 */
psplat_result psplat_region_near(const psplat_region *region, const psplat_distance *distance,
                                 double tolerance, int *near);

#endif
