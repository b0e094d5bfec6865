/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * blend_points.h - random points of the surface, and which splats blend there.
 */
#ifndef PHONGSPLAT_FINISH_BLEND_POINTS_H
#define PHONGSPLAT_FINISH_BLEND_POINTS_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

#include <stdint.h>

/* A splat's fragment at a point, seen along the surface's normal there. */
typedef struct psplat_blend_hit {
    uint32_t point;
    float uv[2];  /* where in the splat */
    float weight; /* of the kernel, above 0 */
} psplat_blend_hit;

/* Points of the surface and the fragments there, sorted by splats. */
typedef struct psplat_blend_points {
    double (*normals)[3]; /* count: the surface's shading normals, unit */
    size_t count;
    psplat_blend_hit *hits; /* of candidate i: first[i] ... first[i + 1] - 1 */
    size_t *first;          /* candidates + 1 */
} psplat_blend_points;

/* Draws about per_splat points for each candidate of a selection, of which all are taken; the total
 * is bounded. Points of an apron are left out. psplat_blend_points_free frees *points. Fails only
 * with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_blend_points_draw(const psplat_conversion *c, size_t per_splat, uint64_t seed,
                                       psplat_blend_points *points);

/* Frees all that points owns, and zeroes it. */
void psplat_blend_points_free(psplat_blend_points *points);

#endif
