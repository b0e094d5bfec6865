/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * distance.h - point-to-mesh distances, by one of three trees: that of mesh/triangle_tree.h, with
 * which splats are fitted; that of mesh/morton_tree.h, with which conversions are checked; or
 * CGAL's, by which comparisons measure. The checks share no fault of the fit's.
 */
#ifndef PHONGSPLAT_MESH_DISTANCE_H
#define PHONGSPLAT_MESH_DISTANCE_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "mesh/triangle_tree.h"

#include <stdint.h>

/* The triangles of a mesh in a tree. All functions below fail only with PSPLAT_ERROR_MEMORY, and
 * may be called by several threads at once. */
typedef struct psplat_distance psplat_distance;

/* Builds a tree for fits. The mesh is copied; see mesh/triangle_tree.h for the memory. Returns NULL
 * when out of memory. */
psplat_distance *psplat_distance_create(const psplat_mesh *mesh);

/* Builds the same of a mesh whose triangles across edges are known, as in psplat_surface
 * (triangle_count x 3). They are copied; with them, proofs of nearness are faster. */
psplat_distance *psplat_distance_create_connected(const psplat_mesh *mesh,
                                                  const uint32_t *neighbors);

/* Builds CGAL's tree, which takes 224 bytes a triangle and more time in every query. The mesh
 * is copied. Returns NULL when out of memory. */
psplat_distance *psplat_distance_create_cgal(const psplat_mesh *mesh);

/* Builds a tree for checks, which takes 12 bytes a triangle. The mesh must outlive it. Returns NULL
 * when out of memory. */
psplat_distance *psplat_distance_create_check(const psplat_mesh *mesh);

/* Returns the tree for fits; NULL where it is another one. */
const psplat_triangle_tree *psplat_distance_tree(const psplat_distance *distance);

/* Stores the distances of count points (x 3) to the mesh in result. */
psplat_result psplat_distance_query(const psplat_distance *distance, const double *points,
                                    size_t count, double *result);

/* Stores the point of the mesh that is nearest to point, and the triangle that it lies on. *guess
 * is PSPLAT_NONE or, to save time, what an earlier query of the same tree stored there for a point
 * nearby; it changes nothing of what is found. */
psplat_result psplat_distance_nearest(const psplat_distance *distance, const double point[3],
                                      uint32_t *guess, double nearest[3], uint32_t *triangle);

/* The same, but stores the corners of that triangle. */
psplat_result psplat_distance_nearest_corners(const psplat_distance *distance,
                                              const double point[3], uint32_t *guess,
                                              double nearest[3], double corners[9]);

/* Stores in *meets whether the segment between two points meets a triangle from its front. */
psplat_result psplat_distance_meets(const psplat_distance *distance, const double from[3],
                                    const double to[3], int *meets);

/* Stores in *within whether all count points lie within tolerance of the mesh. This is faster than
 * computing their distances. */
psplat_result psplat_distance_within(const psplat_distance *distance, const double *points,
                                     size_t count, double tolerance, int *within);

/* The same of one point. *guess is PSPLAT_NONE at first; handed on from point to point on the same
 * distance, it makes neighbouring points faster and changes no result. */
psplat_result psplat_distance_is_within(const psplat_distance *distance, const double point[3],
                                        double tolerance, uint32_t *guess, int *within);

/* Calls visit with the corners of each triangle that may meet the box from low to high, until visit
 * returns other than 0. It may also be called for triangles that only come near the box. */
psplat_result psplat_distance_visit_box(const psplat_distance *distance, const double low[3],
                                        const double high[3],
                                        int (*visit)(void *user, const double corners[9]),
                                        void *user);

void psplat_distance_destroy(psplat_distance *distance);

#endif
