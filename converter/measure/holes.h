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
 * that no splat covers. Returns at most one of them in each cube of side `coarse`. Both are lengths
 * in the mesh's units. All of
 * the surface but the holes and what is unproven is proven to be covered. The holes are in the
 * order of triangles, whatever the number of threads; psplat_holes_free frees them. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_holes_find(const psplat_surface *surface,
                                const psplat_measured_splats *measured, double coarse, double fine,
                                psplat_holes *holes);

/* Frees the points and triangles, and zeroes holes. */
void psplat_holes_free(psplat_holes *holes);

#endif
