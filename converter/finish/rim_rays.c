/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rim_rays.c - rays past the rims of a selection's splats.
 */
#include "finish/rim_rays.h"

#include "base/region_tree.h"
#include "fit/candidate.h"
#include "select/selection.h"

#include <stdlib.h>

psplat_result psplat_rim_rays_find(const psplat_conversion *c, double spacing_tolerances,
                                   size_t points, double wall_tolerances,
                                   const psplat_measured_splats *hiders, uint64_t seed,
                                   psplat_measured_splats *measured, psplat_ray_holes *rays) {
    const psplat_selection *selection = &c->selection;
    *rays = (psplat_ray_holes){0};
    *measured = (psplat_measured_splats){.tolerance = c->limits.tolerance,
                                         .wall = wall_tolerances * c->limits.tolerance};
    measured->regions = malloc((selection->count + 1) * sizeof *measured->regions);
    if (!measured->regions) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < selection->count; ++i)
        if (selection->candidates[i].taken)
            measured->regions[measured->count++] = selection->candidates[i].region;
    measured->region_tree = psplat_region_tree_create(measured->regions, measured->count, 0);
    if (!measured->region_tree) return PSPLAT_ERROR_MEMORY;
    const psplat_ray_search search = {.surface = &c->surface,
                                      .measured = measured,
                                      .distance = c->distance,
                                      .hiders = hiders,
                                      .points = points,
                                      .rim_spacing = spacing_tolerances * c->limits.tolerance,
                                      .seed = seed};
    return psplat_ray_holes_find(&search, rays);
}
