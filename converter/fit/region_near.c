/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_near.c - the check of the distance bound: whether all of a region lies within the
 * tolerance of the mesh.
 */
#include "fit/region_near.h"

#include "base/region.h"
#include "mesh/distance.h"

psplat_result psplat_region_near(const psplat_region *region, const psplat_distance *distance,
                                 double tolerance, int *near) {
    double points[PSPLAT_REGION_POINTS][3];
    *near = 1;
    if (!distance) return PSPLAT_OK;
    size_t count = psplat_region_points(region, points);
    return psplat_distance_within(distance, &points[0][0], count, tolerance, near);
}
