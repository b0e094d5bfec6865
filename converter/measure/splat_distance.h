/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_distance.h - the greatest distance from all points of a splat to a mesh, bounded from both
 * sides.
 */
#ifndef PHONGSPLAT_MEASURE_SPLAT_DISTANCE_H
#define PHONGSPLAT_MEASURE_SPLAT_DISTANCE_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "measure/region_cell.h"
#include "mesh/distance.h"

#include <stddef.h>

/* Whether all of a splat lies within a tolerance of a mesh. */
typedef enum psplat_nearness {
    PSPLAT_NEARNESS_WITHIN,   /* proven: the bound is at most the tolerance */
    PSPLAT_NEARNESS_EXCEEDS,  /* a point was found that is farther away */
    PSPLAT_NEARNESS_UNDECIDED /* neither, within the limit of the search */
} psplat_nearness;

/* What a search asks for. */
typedef struct psplat_splat_distance_desc {
    double tolerance;  /* a length, > 0 */
    int stop_at_first; /* 1: one point beyond the tolerance is enough; bound and found are then not
                          those of the whole splat where the result is EXCEEDS */
    size_t most_cells; /* after which the search gives up refining; 0 means 100,000 */
} psplat_splat_distance_desc;

/* What a search found. Lengths are in the mesh's units. */
typedef struct psplat_splat_distance {
    psplat_nearness nearness;
    double found;    /* the greatest distance of the points of the splat that were measured */
    double point[3]; /* which has that distance */
    double bound;    /* no point of the splat is farther from the mesh; at most the tolerance, or
                        1 % more than found, unless the limit of the search was met */
    size_t cells;    /* looked at */
} psplat_splat_distance;

/* Bounds the distance from all points of a region, as far as ellipse and clip lines leave it, to
 * the mesh. A region of which they leave nothing is within any tolerance. The result holds up to
 * rounding, some 1e-12 of the coordinates. May be called by several threads at once. Fails only
 * with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_splat_distance_find(const psplat_region *region,
                                         const psplat_distance *distance,
                                         const psplat_splat_distance_desc *desc,
                                         psplat_splat_distance *result);

/* The same for the part of a region that a convex polygon of its parameters holds. distance must be
 * one with a tree for fits. *guess is the place in it of a triangle that is likely near all of that
 * part, and becomes that of the one found last. */
psplat_result psplat_splat_distance_find_in(const psplat_region *region,
                                            const psplat_distance *distance,
                                            const psplat_splat_distance_desc *desc,
                                            const psplat_cell *cell, uint32_t *guess,
                                            psplat_splat_distance *result);

#endif
