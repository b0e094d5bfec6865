/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cloud.h - points all over a mesh or over splats.
 */
#ifndef PHONGSPLAT_CLOUD_H
#define PHONGSPLAT_CLOUD_H

#include "original.h"

typedef struct psplat_cloud {
    double *points; /* count x 3 */
    float *normals; /* uniform x 3, of a mesh */
    size_t count;
    size_t uniform; /* the first of them are spread evenly over the area; the others are corners,
                       where the extremes are likely */
} psplat_cloud;

/* count points of a mesh, moved by -shift, and up to as many of its vertices. Errors: MEMORY. */
psplat_result psplat_cloud_of_mesh(const psplat_original *mesh, const double shift[3], size_t count,
                                   uint64_t seed, psplat_cloud *cloud, psplat_error *error);
/* About count points of regions, and corners of their outlines: as many, or some of each. Errors:
 * MEMORY. */
psplat_result psplat_cloud_of_regions(const psplat_region *regions, size_t region_count,
                                      size_t count, uint64_t seed, psplat_cloud *cloud,
                                      psplat_error *error);
void psplat_cloud_free(psplat_cloud *cloud); /* accepts a zero-initialised struct */

#endif
