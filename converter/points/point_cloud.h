/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * point_cloud.h - the point set during surface reconstruction, and what CGAL computes for it.
 */
#ifndef PHONGSPLAT_POINTS_POINT_CLOUD_H
#define PHONGSPLAT_POINTS_POINT_CLOUD_H

#include <phongsplat/splat.h>

#include "points/points.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The index of no point. */
#define PSPLAT_NO_POINT UINT32_MAX

/* How many neighbours each point has. On a surface the ring around it has 6, or 8 in a grid. */
#define PSPLAT_NEIGHBORS 8

/* Stores the nearest neighbours of each point in the order of their distance, without the point
 * itself (CGAL::Orthogonal_k_neighbor_search). The last ones are PSPLAT_NO_POINT if there are
 * fewer. neighbors: count x PSPLAT_NEIGHBORS. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_points_neighbors(const double *positions, size_t count, uint32_t *neighbors);

/* Computes the front: triangles through the points, by the advancing front of CGAL
 * (advancing_front_surface_reconstruction; Cohen-Steiner, Da: A greedy Delaunay-based surface
 * reconstruction algorithm, 2004). No edge is longer than the square root of reach[a] * reach[b],
 * or connects points whose normals face away from each other; normals is NULL if they have no
 * sides. The corners of each triangle are in ascending order. Neighbours must be about 1 apart.
 * *triangles (3 x *triangle_count) is malloc'ed and belongs to the caller. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_points_front(const double *positions, const double *reach,
                                  const float *normals, size_t count, uint32_t **triangles,
                                  size_t *triangle_count);

/* A point set during reconstruction. Only the kept points, which are not too dense, are connected.
 * Positions are centred, at first with a diagonal of 1, and then scaled so that the median spacing
 * is 1. */
typedef struct psplat_point_cloud {
    const psplat_points *points;
    double origin[3], unit;  /* position = origin + unit * positions[] */
    double *positions;       /* count x 3 */
    float *normals;          /* count x 3, unit, or 0 where the file has none; or NULL */
    uint32_t *kept, *owners; /* see psplat_poisson_thin */
    size_t kept_count;       /* the sizes of the following arrays are in kept points */
    double *kept_positions;  /* x 3 */
    float *kept_normals;     /* x 3, or NULL */
    uint32_t *neighbors;     /* x PSPLAT_NEIGHBORS */
    double *spacings;        /* distance of the farthest of the neighbours */
    double noise;        /* median distance from a quadric through the neighbours, in spacings */
    uint32_t *triangles; /* the front: indices into kept */
    size_t triangle_count;
    int closed; /* the front has no border */
} psplat_point_cloud;

/* Sorts values and returns their median. count must be positive. */
double psplat_points_median(double *values, size_t count);

#ifdef __cplusplus
}
#endif
#endif
