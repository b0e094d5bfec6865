/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * neighborhood.h - the samples connected with a seed on the surface, nearest first.
 */
#ifndef PHONGSPLAT_FEATURES_NEIGHBORHOOD_H
#define PHONGSPLAT_FEATURES_NEIGHBORHOOD_H

#include "base/covariance.h"
#include "features/metric.h"
#include "features/samples.h"
#include "features/surface.h"

#include <stdint.h>

/* A sample and a key that sorts as its squared distance does. */
typedef struct psplat_ranked {
    uint32_t key;
    uint32_t index;
} psplat_ranked;

typedef struct psplat_near_sample {
    double p[3], n[3]; /* the position relative to the origin; the unit normal */
    uint32_t index;
} psplat_near_sample;

/* A box around so many creases that follow each other in their list; around fewer at its end. */
enum { PSPLAT_CREASE_BLOCK = 8 };
typedef struct psplat_crease_box {
    double low[3], high[3];
} psplat_crease_box;

/* The samples and creases that were gathered last: memory of one thread for one surface, which
 * grows on demand. Zero-initialise it. */
typedef struct psplat_neighborhood {
    psplat_near_sample *samples; /* nearest first */
    double *along[3];            /* their positions once more, by axis */
    size_t count;
    uint32_t *creases; /* edges (3 x triangle + side) that stopped the flood, and others near it */
    size_t crease_count;
    psplat_crease_box *crease_boxes; /* of each PSPLAT_CREASE_BLOCK creases */
    int whole;        /* 1: the samples are all of the patch that is connected with the seed */
    double origin[3]; /* the metric's centre */
    psplat_ranked *order, *sorted; /* count; sorted is scratch memory */
    psplat_covariance *blocks;     /* sums over the nearest 0, 16, 32 ... samples */
    size_t block_count;            /* how many of them are known */
    uint32_t *stamps;              /* per cluster: the flood that met it last */
    size_t stamp_count;            /* clusters */
    uint32_t stamp;
    uint32_t *clusters; /* those that the flood has met */
    size_t cluster_count, cluster_capacity, order_capacity, sorted_capacity, sample_capacity,
        crease_capacity, crease_box_capacity;
} psplat_neighborhood;

/* Gathers the samples (blue noise) within reach of the metric's centre, which the metric does not
 * make larger than they are. A flood over the samples' clusters finds them from the cluster of a
 * triangle that is within reach. With creases_only it gathers only the creases. Returns 0 when out
 * of memory. */
int psplat_neighborhood_gather(psplat_neighborhood *neighborhood, const psplat_surface *surface,
                               const psplat_samples *samples, const psplat_metric *metric,
                               uint32_t triangle, double reach, int creases_only);

/* Returns the number of samples within reach, which is at most the reach of the last gathering. */
size_t psplat_neighborhood_within(const psplat_neighborhood *neighborhood, double reach);

/* Finds the sums over the nearest count samples, relative to the origin. */
void psplat_neighborhood_covariance(psplat_neighborhood *neighborhood, size_t count,
                                    psplat_covariance *covariance);

/* Frees what the neighbourhood owns, and zeroes it. */
void psplat_neighborhood_free(psplat_neighborhood *neighborhood);

#endif
