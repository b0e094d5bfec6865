/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease.h - crease detection, and the smooth patches between creases.
 */
#ifndef PHONGSPLAT_FEATURES_CREASE_H
#define PHONGSPLAT_FEATURES_CREASE_H

#include <phongsplat/splat.h>

#include "appearance/appearance.h"
#include "features/surface.h"

#include <math.h>
#include <stdint.h>

/* The crease angle with which only edges without a neighbour bound patches. */
#define PSPLAT_NO_CREASES HUGE_VAL

/* What bounds patches besides borders. */
typedef struct psplat_patch_bounds {
    double crease_angle; /* from which an edge is a crease, radians */
    /* Of the mesh; must live as long; or NULL. Where it keeps textures, the borders of their charts
     * bound patches too, whatever the crease angle is. */
    const psplat_appearance *appearance;
    /* The greatest distance of splats from the surface, a length: tangent edges over which they
     * would reach bound patches too (tangent_edges.h). 0: none do. */
    double tolerance;
    /* The greatest distance of splats from the surface, a length: edges of facets that stand out by
     * a part of it bound patches too (facet_edges.h). 0: none do. */
    double facet_tolerance;
    /* The altitude, a length, below which slivers face as the surface beside them (slivers.h). 0:
     * all triangles face their own way. */
    double sliver_height;
} psplat_patch_bounds;

/* Fills in creases, patches, patch_count, crease_edges and roughness of a surface whose neighbours
 * are known. authored comes from psplat_authored_read. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_crease_find(psplat_surface *surface, const psplat_patch_bounds *bounds,
                                 const uint8_t *authored);

#endif
