/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_near.c - the check of the distance bound: whether all of a region lies within the
 * tolerance of the mesh.
 */
#include "fit/region_near.h"

#include "base/region.h"
#include "fit/walked_nearness.h"
#include "measure/splat_distance.h"
#include "mesh/distance.h"
#include "mesh/triangle_tree.h"

/* Returns whether a walk over the triangles is possible. */
static int can_walk(const psplat_distance *distance) {
    const psplat_triangle_tree *tree = psplat_distance_tree(distance);
    return tree && tree->neighbors;
}

psplat_result psplat_region_near(const psplat_region *region, const psplat_distance *distance,
                                 double tolerance, int *near) {
    const psplat_splat_distance_desc desc = {.tolerance = tolerance, .stop_at_first = 1};
    psplat_splat_distance measured;
    psplat_result result = PSPLAT_OK;
    int is_known = 0;
    *near = 1;
    if (!distance) return PSPLAT_OK;
    if (can_walk(distance))
        result = psplat_walked_nearness(region, distance, tolerance, &is_known, near);
    if (result || is_known) return result;
    result = psplat_splat_distance_find(region, distance, &desc, &measured);
    *near = measured.nearness == PSPLAT_NEARNESS_WITHIN;
    return result;
}
