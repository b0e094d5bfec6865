/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_tree.h - a tree of boxes over the triangles of a mesh, for the queries of a fit.
 *
 * Triangles lie in the order of the leaves, four in each, and so do their vertices. Every node
 * holds the boxes of its four parts in single precision, rounded outwards; which parts these are
 * follows from the node's place, as in a heap. A triangle takes about 36 bytes, and 12 more if its
 * neighbours are known. Distances are computed in double precision.
 */
#ifndef PHONGSPLAT_MESH_TRIANGLE_TREE_H
#define PHONGSPLAT_MESH_TRIANGLE_TREE_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

#include <stddef.h>
#include <stdint.h>

/* The triangles of a leaf, the parts of a node, and levels of nodes for all meshes that there are.
 */
enum { PSPLAT_TREE_LEAF = 4, PSPLAT_TREE_PARTS = 4, PSPLAT_TREE_LEVELS = 16 };

/* The boxes of the parts of a node, in the tree's own units. Those of parts that do not exist hold
 * nothing. */
typedef struct psplat_tree_node {
    float low[3][PSPLAT_TREE_PARTS], high[3][PSPLAT_TREE_PARTS];
} psplat_tree_node;

/* A tree. `place` below is the index of a triangle in the order of the leaves. Part k of node i
 * of level l > 0 is node 4 i + k of the level below; that of level 0 is the leaf whose first
 * triangle is at place 4 (4 i + k). */
typedef struct psplat_triangle_tree {
    double origin[3], scale; /* (position - origin) scale is within [-1, 1] */
    size_t triangle_count, vertex_count;
    double *positions;   /* vertex_count x 3, as in the mesh */
    uint32_t *corners;   /* triangle_count x 3, indices of positions */
    uint32_t *triangles; /* the mesh's index of each */
    uint32_t *neighbors; /* triangle_count x 3: the place across the edge from corner k to the next
                            one, or PSPLAT_NONE; NULL if they are not known */
    psplat_tree_node *nodes;
    size_t first[PSPLAT_TREE_LEVELS]; /* the first node of each level */
    int level_count;                  /* the last level has one node; 0 without triangles */
} psplat_triangle_tree;

/* Builds the tree of a mesh, which is copied. neighbors are triangle_count x 3 indices of the
 * triangles across edges as in psplat_surface, or NULL. Returns NULL when out of memory. */
psplat_triangle_tree *psplat_triangle_tree_create(const psplat_mesh *mesh,
                                                  const uint32_t *neighbors);

/* What a search for the nearest triangle knows and finds. */
typedef struct psplat_tree_nearest {
    double distance2; /* in: triangles farther away do not count, HUGE_VAL for no limit; out: the
                         squared distance of the nearest */
    uint32_t place;   /* in: a triangle that is likely near, or PSPLAT_NONE; out: the nearest, or
                         PSPLAT_NONE if none counts */
    double point[3];  /* out: its nearest point */
} psplat_tree_nearest;

/* Finds the triangle nearest to a point; of several, that with the mesh's least index. What is
 * likely near changes the time only. */
void psplat_triangle_tree_nearest(const psplat_triangle_tree *tree, const double point[3],
                                  psplat_tree_nearest *nearest);

/* Returns whether a point lies within a distance, at least 0, of some triangle. *place is one that
 * is likely near, or PSPLAT_NONE, and becomes one that is within. */
int psplat_triangle_tree_is_within(const psplat_triangle_tree *tree, const double point[3],
                                   double distance, uint32_t *place);

/* Returns whether the segment between two points meets a triangle from its front: it starts in
 * front of the triangle's plane or on it and ends behind it or on it. A segment through an edge of
 * two triangles that face it alike meets one of them. */
int psplat_triangle_tree_meets(const psplat_triangle_tree *tree, const double from[3],
                               const double to[3]);

/* Calls visit with the place of each triangle whose box meets the box from low to high, until visit
 * returns other than 0. It may also be called for triangles that only come near the box. */
void psplat_triangle_tree_visit_box(const psplat_triangle_tree *tree, const double low[3],
                                    const double high[3], int (*visit)(void *user, uint32_t place),
                                    void *user);

/* Returns the position of a corner of the triangle at a place. */
static inline const double *psplat_tree_corner(const psplat_triangle_tree *tree, uint32_t place,
                                               int corner) {
    return tree->positions + 3 * (size_t)tree->corners[3 * (size_t)place + (size_t)corner];
}

void psplat_triangle_tree_destroy(psplat_triangle_tree *tree);

#endif
