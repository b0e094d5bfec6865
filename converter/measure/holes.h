/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * holes.h - points of the surface that no splat covers.
 */
#ifndef PHONGSPLAT_MEASURE_HOLES_H
#define PHONGSPLAT_MEASURE_HOLES_H

#include <phongsplat/splat.h>

#include "features/surface.h"
#include "measure/measured_splats.h"

#include <stdint.h>

/* Points of the surface that no splat covers, and the triangles that they lie on. */
typedef struct psplat_holes {
    double *points;      /* count x 3 */
    uint32_t *triangles; /* count */
    size_t count, capacity;
    double unproven; /* the area of the parts that no single splat covers, and whose middles are
                        covered, when they became too small to be halved */
} psplat_holes;

/* Finds the holes between splats that are wider than about `fine`, and the points of a point set
 * that no splat covers, but for those in the surface's apron. Returns at most one of them in each
 * cube of side `coarse`. Both are lengths in the mesh's units. All of the surface but the holes and
 * what is unproven is proven to be covered. The holes are in the order of triangles, whatever the
 * number of threads; psplat_holes_free frees them. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_holes_find(const psplat_surface *surface,
                                const psplat_measured_splats *measured, double coarse, double fine,
                                psplat_holes *holes);

/* What is known of the triangles from the last search, so that the next one looks only where splats
 * have changed. Zero-initialise it. All searches with it must have the same surface; others
 * of its members are forgotten where the tolerance or a length differs. */
typedef struct psplat_hole_memory {
    psplat_region *regions; /* region_count: those of the last search */
    size_t region_count;
    uint32_t *covers; /* for each triangle, and then each point of a point set: the region that
                         covers it, or one of two greater numbers */
    size_t cover_count;
    double tolerance, coarse, fine; /* of the last search */
} psplat_hole_memory;

/* Finds the same holes, except that `unproven` counts only where it looked: not where a splat that
 * has not changed covers a triangle, nor where there was no hole and no splat near has changed or
 * gone. */
psplat_result psplat_holes_find_changed(const psplat_surface *surface,
                                        const psplat_measured_splats *measured, double coarse,
                                        double fine, psplat_hole_memory *memory,
                                        psplat_holes *holes);

/* Frees what the memory owns, and zeroes it. */
void psplat_hole_memory_free(psplat_hole_memory *memory);

/* Frees the points and triangles, and zeroes holes. */
void psplat_holes_free(psplat_holes *holes);

#endif
