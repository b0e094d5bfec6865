/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tested_surface.h - the tested surface of a comparison: splats, or another mesh. All points are in
 * the coordinates of the source mesh.
 */
#ifndef PHONGSPLAT_COMPARE_TESTED_SURFACE_H
#define PHONGSPLAT_COMPARE_TESTED_SURFACE_H

#include "compare/placed_splats.h"
#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "compare/surface_points.h"

#include <phongsplat/phongsplat.h>

typedef struct psplat_tested_surface {
    psplat_placed_splats placed;
    const psplat_source_mesh *mesh; /* the other mesh, or NULL if splats are tested */
    double shift[3];                /* from the source's coordinates to the mesh's */
    double reach;                   /* length of rays along normals, to either side */
} psplat_tested_surface;

/* Prepares splats, those of several assets together, or a mesh. percent is the reach in % of the
 * source's diagonal; 0 means the default of psplat_shape_desc. source and mesh must outlive
 * *target. Errors: MEMORY, RANGE. */
psplat_result psplat_tested_surface_splats(const psplat_source_mesh *source,
                                           const psplat_asset *asset, double percent,
                                           psplat_tested_surface *target, psplat_error *error);
psplat_result psplat_tested_surface_assets(const psplat_source_mesh *source,
                                           const psplat_asset *const *assets, size_t count,
                                           double percent, psplat_tested_surface *target,
                                           psplat_error *error);
void psplat_tested_surface_mesh(const psplat_source_mesh *source, const psplat_source_mesh *mesh,
                                double percent, psplat_tested_surface *target);
/* Accepts a zero-initialised struct. */
void psplat_tested_surface_free(psplat_tested_surface *target);

/* Returns the number of splats or triangles. */
size_t psplat_tested_surface_elements(const psplat_tested_surface *target);
/* Finds the distance to the nearest point, HUGE_VAL where there are no splats. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tested_surface_distance(const psplat_tested_surface *target,
                                             const double point[3], double *distance);
/* Finds the normal, of any length, of the tested surface at a point of the source: that of splats
 * blended on a ray against the point's unit normal, or of the nearest point of a mesh. It is 0 0 0
 * where nothing is within reach. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tested_surface_normal(const psplat_tested_surface *target,
                                           const double point[3], const double normal[3],
                                           double seen[3]);
/* Samples about count points of the target, and adds corners. Errors: MEMORY. */
psplat_result psplat_tested_surface_points(const psplat_tested_surface *target, size_t count,
                                           uint64_t seed, psplat_surface_points *cloud,
                                           psplat_error *error);

#endif
