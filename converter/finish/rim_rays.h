/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rim_rays.h - rays past the rims of a selection's splats, which meet nothing where they see the
 * surface.
 */
#ifndef PHONGSPLAT_FINISH_RIM_RAYS_H
#define PHONGSPLAT_FINISH_RIM_RAYS_H

#include <phongsplat/splat.h>

#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "select/conversion.h"

/* Finds the rays past points of the rims, spacing_tolerances apart, and through so many random
 * points of the surface, that meet none of the taken candidates, nor walls that reach
 * wall_tolerances down. Where hiders is not NULL, those that none of these would hide are left out.
 * *measured gets the regions of the taken candidates, in their order, and a tree of these; the
 * caller frees both, also where this fails. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_rim_rays_find(const psplat_conversion *c, double spacing_tolerances,
                                   size_t points, double wall_tolerances,
                                   const psplat_measured_splats *hiders, uint64_t seed,
                                   psplat_measured_splats *measured, psplat_ray_holes *rays);

#endif
