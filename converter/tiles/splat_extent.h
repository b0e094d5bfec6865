/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_extent.h - bounds of what a splat shows: of its surface as far as ellipse and clip lines
 * leave it.
 */
#ifndef PHONGSPLAT_TILES_SPLAT_EXTENT_H
#define PHONGSPLAT_TILES_SPLAT_EXTENT_H

#include "base/region.h"

#include <stddef.h>
#include <stdint.h>

/* Stores a box that holds all of a region's surface, and little more. Returns 0 where the clip
 * lines leave nothing. */
int psplat_splat_extent_box(const psplat_region *region, double low[3], double high[3]);

/* Returns whether a region's surface may reach into a box: never 0 where it does. */
int psplat_splat_extent_meets(const psplat_region *region, const double low[3],
                              const double high[3]);

/* A cone of directions: those whose cosine to the axis is at least this one. */
typedef struct psplat_normal_cone {
    double axis[3]; /* unit, but 0 0 0 where there is no direction */
    double cosine;  /* above 0, or there is no cone */
} psplat_normal_cone;

/* Returns a cone that holds the normals of the surfaces of those of the regions whose indices are
 * given (count), at all of their points. */
psplat_normal_cone psplat_splat_extent_cone(const psplat_region *regions, const uint32_t *indices,
                                            size_t count);

#endif
