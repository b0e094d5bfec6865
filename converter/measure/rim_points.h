/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rim_points.h - points a little beyond the rims of splats, where gaps between them begin.
 */
#ifndef PHONGSPLAT_MEASURE_RIM_POINTS_H
#define PHONGSPLAT_MEASURE_RIM_POINTS_H

#include <phongsplat/splat.h>

#include "base/region.h"

#include <stddef.h>
#include <stdint.h>

/* A point of the surface of a splat, with the unit normal of that surface. */
typedef struct psplat_rim_point {
    double point[3], normal[3];
} psplat_rim_point;

/* Which points are drawn. */
typedef struct psplat_rim_draw {
    const psplat_region *regions;
    size_t count;
    double spacing;         /* between points along a rim, a length */
    double least, greatest; /* how far outside the rim they lie, lengths; the nearer, the more */
    uint64_t seed;
} psplat_rim_draw;

/* Draws points along the outlines of splats, on their ellipses as far as lines keep these and on
 * their lines as far as the ellipse holds these, and moves them outwards along the surface. At most
 * 512 of each ellipse and of each line. The caller frees *points. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_rim_points_draw(const psplat_rim_draw *draw, psplat_rim_point **points,
                                     size_t *count);

#endif
