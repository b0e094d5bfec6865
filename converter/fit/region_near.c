/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_near.c - the check of the distance bound: whether all of a region lies within the
 * tolerance of the mesh.
 */
#include "fit/region_near.h"

#include "base/region.h"
#include "measure/splat_distance.h"
#include "mesh/distance.h"

psplat_result psplat_region_near(const psplat_region *region, const psplat_distance *distance,
                                 double tolerance, int *near) {
    const psplat_splat_distance_desc desc = {.tolerance = tolerance, .stop_at_first = 1};
    psplat_splat_distance measured;
    *near = 1;
    if (!distance) return PSPLAT_OK;
    psplat_result result = psplat_splat_distance_find(region, distance, &desc, &measured);
    *near = measured.nearness == PSPLAT_NEARNESS_WITHIN;
    return result;
}
