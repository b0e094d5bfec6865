/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * points.h - the steps from points to a mesh through them, in flow order:
 *
 *     points -> centred -> thinned -> neighbours -> front of triangles -> oriented -> mesh
 *
 * A point set needs no watertight mesh: splats ask only which points are neighbours on the surface,
 * and where it has creases and ends. So the front may leave out points in the noise of a scan, and
 * large sets are connected through a part of their points; the others belong to triangles nearby.
 */
#ifndef PHONGSPLAT_POINTS_H
#define PHONGSPLAT_POINTS_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PSPLAT_NO_POINT UINT32_MAX
#define PSPLAT_NEIGHBORS 8 /* a ring of neighbours on a surface has 6, or 8 in a grid */

/* ---- thin.c ------------------------------------------------------------------------------- */

/* Keeps points no two of which are closer than radius, in the order of their indices; points whose
 * normals (NULL: unknown) face away from each other do not crowd each other: they are the two sides
 * of a sheet. owners[i]: the kept point, as an index into kept, at point i. kept, owners: room for
 * count. Returns the number kept, 0 when out of memory. */
size_t psplat_points_thin(const double *positions, const float *normals, size_t count,
                          double radius, uint32_t *kept, uint32_t *owners);

/* ---- adapter_points.cpp ------------------------------------------------------------------- */

/* The nearest PSPLAT_NEIGHBORS of each point by distance, without itself (CGAL::
 * Orthogonal_k_neighbor_search); the last ones PSPLAT_NO_POINT where there are fewer. neighbors:
 * count x PSPLAT_NEIGHBORS. */
psplat_result psplat_points_neighbors(const double *positions, size_t count, uint32_t *neighbors);

/* Triangles through the points, no edge longer than the root of reach[a] * reach[b] or between
 * normals (NULL: they have no sides) that face away from each other, their corners in ascending
 * order (CGAL::advancing_front_surface_reconstruction; Cohen-Steiner, Da: A greedy
 * Delaunay- based surface reconstruction algorithm, 2004). Wants lengths of about 1 between
 * neighbours. *triangles: 3 x *triangle_count, malloc'ed. */
psplat_result psplat_points_front(const double *positions, const double *reach,
                                  const float *normals, size_t count, uint32_t **triangles,
                                  size_t *triangle_count);

/* A point set on its way. Positions are centred, and in units in which neighbours are about 1
 * apart. */
typedef struct psplat_cloud {
    const psplat_points *points;
    double origin[3], unit;  /* position = origin + unit * positions[] */
    double *positions;       /* count x 3 */
    float *normals;          /* count x 3, unit or, where the file has none, 0; or NULL */
    uint32_t *kept, *owners; /* see psplat_points_thin */
    size_t kept_count;       /* the points that are connected; what follows is of these */
    double *kept_positions;  /* x 3 */
    float *kept_normals;     /* x 3, or NULL */
    uint32_t *neighbors;     /* x PSPLAT_NEIGHBORS */
    double *spacings;        /* distance of the last of the neighbours */
    double noise;            /* how far half of them are off their neighbours, in spacings */
    uint32_t *triangles;     /* the front: indices into kept */
    size_t triangle_count;
    int closed; /* the front has no border */
} psplat_cloud;

/* ---- jet.c -------------------------------------------------------------------------------- */

/* Normals (kept_count x 3) of a cloud without, from quadrics through the points that the front
 * connects to each: the least-squares jets of Cazals, Pouget: Estimating differential quantities
 * using polynomial fitting of osculating jets, 2005. Neighbours by edges instead of by distance
 * keep the two sides of a thin sheet apart. 0 where there are too few. */
psplat_result psplat_points_jets(const psplat_cloud *cloud, float *normals);
/* Finds out how noisy the set is, and moves the kept positions of a very noisy one onto quadrics
 * through their neighbours. sides: neighbours whose normals face away are none. */
psplat_result psplat_points_smooth(psplat_cloud *cloud, int sides);

/* ---- attach.c ----------------------------------------------------------------------------- */

/* Makes the mesh of a cloud whose front is known: gives every point the triangle that it belongs
 * to, and points that the front passes at a distance a small disc of their own. */
psplat_result psplat_points_attach(const psplat_cloud *cloud, psplat_mesh *mesh,
                                   psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
