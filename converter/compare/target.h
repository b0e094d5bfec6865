/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * target.h - what is compared with a source: splats, or another mesh. All points are in the
 * coordinates of the source's mesh.
 */
#ifndef PHONGSPLAT_TARGET_H
#define PHONGSPLAT_TARGET_H

#include "cloud.h"
#include "original.h"
#include "placed.h"

typedef struct psplat_target {
    psplat_placed placed;
    const psplat_original *mesh; /* instead of splats */
    double shift[3];             /* from the source's coordinates to the mesh's */
    double reach;                /* of looks along normals, a length */
} psplat_target;

/* percent: reach, of the source's diagonal; 0: the default of psplat_shape_desc. Errors: MEMORY,
 * RANGE. */
psplat_result psplat_target_splats(const psplat_original *source, const psplat_asset *asset,
                                   double percent, psplat_target *target, psplat_error *error);
void psplat_target_mesh(const psplat_original *source, const psplat_original *mesh, double percent,
                        psplat_target *target);
void psplat_target_free(psplat_target *target); /* accepts a zero-initialised struct */

size_t psplat_target_elements(const psplat_target *target);
/* Distance to the nearest point; HUGE_VAL: there is none. MEMORY is the only failure. */
psplat_result psplat_target_distance(const psplat_target *target, const double point[3],
                                     double *distance);
/* The normal, of any length, that is seen at a point of the source by one who looks along its unit
 * normal; 0 0 0 where nothing is within reach. MEMORY is the only failure. */
psplat_result psplat_target_normal(const psplat_target *target, const double point[3],
                                   const double normal[3], double seen[3]);
/* About count points all over the target, and corners. Errors: MEMORY. */
psplat_result psplat_target_points(const psplat_target *target, size_t count, uint64_t seed,
                                   psplat_cloud *cloud, psplat_error *error);

#endif
