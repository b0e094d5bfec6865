/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * curved_distance.h - distance of a point to a region with a curved surface or bent lines.
 */
#ifndef PHONGSPLAT_BASE_CURVED_DISTANCE_H
#define PHONGSPLAT_BASE_CURVED_DISTANCE_H

#include "base/region.h"

/* Returns the distance of a point to the surface of a region, within a millionth of its first
 * radius; or limit, where it is not less than that; or HUGE_VAL if its clip lines leave nothing. */
double psplat_curved_distance(const psplat_region *region, const double point[3], double limit);

#endif
