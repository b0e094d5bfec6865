/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * open_charts.c - a surface and its samples as they are where borders of charts bound nothing.
 *
 * Clusters of triangles stay what they are: none of them lies on both sides of a border. Those on
 * both sides become neighbours.
 */
#include "features/open_charts.h"

#include "features/clusters.h"
#include "features/samples.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

int psplat_open_charts_create(const psplat_surface *surface, const psplat_samples *samples,
                              psplat_open_charts *open) {
    size_t edges = 3 * surface->mesh->triangle_count;
    *open = (psplat_open_charts){.surface = *surface, .samples = *samples};
    open->samples.clusters.first_neighbor = open->samples.clusters.neighbors = NULL;
    open->samples.clusters.first_crease = open->samples.clusters.creases = NULL;
    open->surface.creases = malloc(edges);
    if (!open->surface.creases) return 0;
    for (size_t e = 0; e < edges; ++e)
        open->surface.creases[e] = (uint8_t)(surface->creases[e] & ~PSPLAT_BOUND_CHART);
    return psplat_clusters_relink(&open->surface, &open->samples.clusters);
}

void psplat_open_charts_free(psplat_open_charts *open) {
    psplat_clusters_unlink(&open->samples.clusters);
    free(open->surface.creases);
    *open = (psplat_open_charts){0};
}
