/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stand_off.h - how far rims of splats stand off from the surface, outwards, where outlines show
 * them.
 */
#ifndef PHONGSPLAT_FINISH_STAND_OFF_H
#define PHONGSPLAT_FINISH_STAND_OFF_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "fit/fit_context.h"

#include <stdint.h>

/* A point of a rim. */
typedef struct psplat_stand_off {
    double point[3];
    double length; /* from the surface, outwards; 0 where the point is not outside of it, or where
                      a line cuts the rim off */
    uint32_t triangle; /* the nearest; PSPLAT_NONE where length is 0 */
} psplat_stand_off;

/* Finds how far the point of a region's rim at uv, on the unit circle, stands off. limits->distance
 * must not be NULL, and *guess is that of psplat_distance_nearest. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_stand_off_find(const psplat_fit_context *context, const psplat_region *region,
                                    const double uv[2], uint32_t *guess,
                                    psplat_stand_off *stand_off);

#endif
