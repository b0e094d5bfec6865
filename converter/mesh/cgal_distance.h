/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cgal_distance.h - point-to-mesh distances by an axis-aligned bounding box tree (CGAL AABB tree).
 *
 * The functions are those of mesh/distance.h, which calls them.
 */
#ifndef PHONGSPLAT_MESH_CGAL_DISTANCE_H
#define PHONGSPLAT_MESH_CGAL_DISTANCE_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The triangles of a mesh in a CGAL::AABB_tree. All functions below fail only with
 * PSPLAT_ERROR_MEMORY, and may be called by several threads at once. */
typedef struct psplat_cgal_distance psplat_cgal_distance;

/* Builds the tree. The mesh is copied. Returns NULL when out of memory. */
psplat_cgal_distance *psplat_cgal_distance_create(const psplat_mesh *mesh);

/* Stores the distances of count points (x 3) to the mesh in result. */
psplat_result psplat_cgal_distance_query(const psplat_cgal_distance *distance, const double *points,
                                         size_t count, double *result);

/* Stores the point of the mesh that is nearest to point, and the triangle that it lies on. */
psplat_result psplat_cgal_distance_nearest(const psplat_cgal_distance *distance,
                                           const double point[3], double nearest[3],
                                           uint32_t *triangle);

/* Stores in *meets whether the segment between two points meets a triangle from its front. */
psplat_result psplat_cgal_distance_meets(const psplat_cgal_distance *distance, const double from[3],
                                         const double to[3], int *meets);

/* Stores in *within whether all count points lie within tolerance of the mesh. This is faster than
 * computing their distances. */
psplat_result psplat_cgal_distance_within(const psplat_cgal_distance *distance,
                                          const double *points, size_t count, double tolerance,
                                          int *within);

/* Calls visit with the corners of each triangle that may meet the box from low to high, until visit
 * returns other than 0. It may also be called for triangles that only come near the box. */
psplat_result psplat_cgal_distance_visit_box(const psplat_cgal_distance *distance,
                                             const double low[3], const double high[3],
                                             int (*visit)(void *user, const double corners[9]),
                                             void *user);

/* Stores the corners of a triangle, which is one of those that psplat_cgal_distance_nearest
 * stores. */
void psplat_cgal_distance_triangle(const psplat_cgal_distance *distance, uint32_t triangle,
                                   double corners[9]);

void psplat_cgal_distance_destroy(psplat_cgal_distance *distance);

#ifdef __cplusplus
}
#endif
#endif
