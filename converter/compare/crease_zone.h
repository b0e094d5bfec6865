/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_zone.h - the crease zone: the part of space near the creases of a surface, where normal
 * errors are reported apart.
 */
#ifndef PHONGSPLAT_COMPARE_CREASE_ZONE_H
#define PHONGSPLAT_COMPARE_CREASE_ZONE_H

#include "base/region_tree.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <phongsplat/splat.h>

/* The edges across which normals jump: creases, and edges where more than two triangles meet or two
 * are oriented inconsistently. Borders are left out. */
typedef struct psplat_crease_zone {
    const psplat_mesh *mesh;
    uint32_t *edges; /* 3 * triangle + k */
    size_t count;
    psplat_region_tree *region_tree; /* of the edges */
    double width;                    /* a length */
} psplat_crease_zone;

/* Collects the edges. surface must outlive the zone, which the caller frees with
 * psplat_crease_zone_free. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_crease_zone_create(const psplat_surface *surface, double width,
                                        psplat_crease_zone *zone);
/* Returns whether a point lies within the width of an edge. */
int psplat_crease_zone_near(const psplat_crease_zone *zone, const double point[3]);
void psplat_crease_zone_free(psplat_crease_zone *zone);

#endif
