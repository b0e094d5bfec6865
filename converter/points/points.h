/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * points.h - point sets, and surface reconstruction: a mesh through their points.
 */
#ifndef PHONGSPLAT_POINTS_POINTS_H
#define PHONGSPLAT_POINTS_POINTS_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A point set: points of a surface, with or without normals and colours. */
typedef struct psplat_points {
    double *positions; /* count x 3 */
    float *normals;    /* count x 3, of any length, 0 where unknown, on either side; or NULL */
    float *colors;     /* count x 4 linear RGBA, or NULL */
    size_t count;
} psplat_points;

/* Reconstructs the surface: connects points by triangles. Gaps of some four times the local spacing
 * stay gaps. The vertices are points as given or, if the set is noisier than 10 % of its spacing,
 * points moved onto quadrics through their neighbours. mesh->points are always as given. Normals
 * that agree about the outside define the front; other normals are used as lines without direction,
 * and missing ones are estimated. The result is deterministic. Of the material only double_sided is
 * set. Errors: PSPLAT_ERROR_NO_SPLATS (no points, or none that span a surface), PSPLAT_ERROR_RANGE
 * (too many, or not finite), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                      psplat_error *error);

/* Frees the arrays and makes the point set zero. */
void psplat_points_free(psplat_points *points);

#ifdef __cplusplus
}
#endif
#endif
