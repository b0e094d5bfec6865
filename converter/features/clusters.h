/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clusters.h - small connected pieces of a surface, which floods walk instead of its triangles.
 */
#ifndef PHONGSPLAT_FEATURES_CLUSTERS_H
#define PHONGSPLAT_FEATURES_CLUSTERS_H

#include "features/surface.h"

#include <stddef.h>
#include <stdint.h>

/* A sphere around something. */
typedef struct psplat_sphere {
    double center[3], radius;
} psplat_sphere;

/* A partition of a surface's triangles into clusters: pieces that are connected over edges that are
 * no creases, and no larger than a length unless they are a single triangle. */
typedef struct psplat_clusters {
    uint32_t *of_triangles;   /* triangle_count: the cluster of each */
    psplat_sphere *spheres;   /* count: around the triangles of each */
    uint32_t *triangles;      /* count: that of a cluster of one, else PSPLAT_NONE */
    uint32_t *first_neighbor; /* count + 1: neighbors[first_neighbor[c] ... first_neighbor[c + 1])
                                 share an edge with c that is no crease */
    uint32_t *neighbors;
    uint32_t *first_crease; /* count + 1: creases (3 x triangle + side) of each cluster, likewise */
    uint32_t *creases;
    size_t count;
} psplat_clusters;

/* Builds clusters that lie within size (a length >= 0) of a corner of theirs. Returns 0 when out of
 * memory. */
int psplat_clusters_build(const psplat_surface *surface, double size, psplat_clusters *clusters);

/* Gives clusters new lists of neighbours and creases, by the creases of a surface with the same
 * triangles. They own those alone: of_triangles, spheres and triangles stay another's. Returns 0
 * when out of memory, and then owns no lists. */
int psplat_clusters_relink(const psplat_surface *surface, psplat_clusters *clusters);

/* Frees what psplat_clusters_relink has made. */
void psplat_clusters_unlink(psplat_clusters *clusters);

void psplat_clusters_free(psplat_clusters *clusters);

#endif
