/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_points.h - sample points on a mesh or on splats, uniform by area, with the corners added.
 */
#ifndef PHONGSPLAT_COMPARE_SURFACE_POINTS_H
#define PHONGSPLAT_COMPARE_SURFACE_POINTS_H

#include "base/region.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"

#include <phongsplat/splat.h>

typedef struct psplat_surface_points {
    double *points; /* count x 3 */
    float *normals; /* uniform x 3, of a mesh only */
    size_t count;
    size_t uniform; /* the first `uniform` points are distributed evenly over the area; the others
                       are corners, where the greatest distances are likely */
} psplat_surface_points;

/* Points of either kind are sorted so that those that follow each other are near each other. */

/* Samples count points of a mesh and adds up to count of its vertices, all moved by -shift. The
 * caller frees *cloud with psplat_surface_points_free. Errors: MEMORY. */
psplat_result psplat_surface_points_of_mesh(const psplat_source_mesh *mesh, const double shift[3],
                                            size_t count, uint64_t seed,
                                            psplat_surface_points *cloud, psplat_error *error);
/* Samples about count points of regions, and adds corners of their outlines: about count of them,
 * but at least eight of each region. Errors: MEMORY. */
psplat_result psplat_surface_points_of_regions(const psplat_region *regions, size_t region_count,
                                               size_t count, uint64_t seed,
                                               psplat_surface_points *cloud, psplat_error *error);
/* Accepts a zero-initialised struct. */
void psplat_surface_points_free(psplat_surface_points *cloud);

#endif
