/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_distance.h - distance of a point to a splat region, and to the nearest of many.
 */
#ifndef PHONGSPLAT_BASE_REGION_DISTANCE_H
#define PHONGSPLAT_BASE_REGION_DISTANCE_H

#include "base/region.h"
#include "base/region_tree.h"

/* Returns the distance of a point to the surface of a region, or HUGE_VAL if its clip lines leave
 * nothing. It is exact up to rounding for flat regions with straight lines, and never less than the
 * distance nor more than a millionth of the first radius greater for others. */
double psplat_region_distance(const psplat_region *region, const double point[3]);

/* Returns the distance of a point to the nearest of count regions, which are those of the tree, or
 * HUGE_VAL if there is none. expected > 0 is a guess of the distance; it changes the time that the
 * search takes, not its result. */
double psplat_region_nearest_distance(const psplat_region *regions, size_t count,
                                      const psplat_region_tree *region_tree, double expected,
                                      const double point[3]);

#endif
