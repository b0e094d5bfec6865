/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * morton_tree.h - a small tree of boxes over the triangles of a mesh, with which splats are
 * checked.
 *
 * It shares nothing with the tree of fits (mesh/triangle_tree.h), whose faults it would hide else:
 * neither the order of triangles, nor the search, nor the distance of a triangle. What divides
 * splats, measure/splat_distance.c, is common to the check and to fits where their walk does not
 * reach. It takes about 12 bytes a triangle beside the mesh, and 28 while it is built.
 */
#ifndef PHONGSPLAT_MESH_MORTON_TREE_H
#define PHONGSPLAT_MESH_MORTON_TREE_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

#include <stdint.h>

/* The triangles of a mesh, by the Morton codes of their middles. All functions below may be called
 * by several threads at once. */
typedef struct psplat_morton_tree psplat_morton_tree;

/* Builds the tree. The mesh must outlive it. Returns NULL when out of memory. */
psplat_morton_tree *psplat_morton_tree_create(const psplat_mesh *mesh);

/* Finds the point of the mesh that is nearest to a point and nearer than `most` (HUGE_VAL: any),
 * and the triangle that it lies on; PSPLAT_NONE where there is none. Returns the distance, or
 * HUGE_VAL. */
double psplat_morton_tree_nearest(const psplat_morton_tree *tree, const double point[3],
                                  double most, double nearest[3], uint32_t *triangle);

/* Returns whether the segment between two points meets a triangle from its front. */
int psplat_morton_tree_meets(const psplat_morton_tree *tree, const double from[3],
                             const double to[3]);

/* Calls visit with each triangle whose box meets the box from low to high, until visit returns
 * other than 0. */
void psplat_morton_tree_visit_box(const psplat_morton_tree *tree, const double low[3],
                                  const double high[3], int (*visit)(void *user, uint32_t triangle),
                                  void *user);

/* Returns the mesh. */
const psplat_mesh *psplat_morton_tree_mesh(const psplat_morton_tree *tree);

void psplat_morton_tree_destroy(psplat_morton_tree *tree);

#endif
