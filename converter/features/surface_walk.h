/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_walk.h - straight walks over a surface from triangle to triangle.
 */
#ifndef PHONGSPLAT_FEATURES_SURFACE_WALK_H
#define PHONGSPLAT_FEATURES_SURFACE_WALK_H

#include "features/surface.h"

#include <stdint.h>

/* A walk along a geodesic. */
typedef struct psplat_surface_walk {
    const psplat_surface *surface;
    uint32_t triangle, entry; /* where it is, and the edge through which it came */
    double at[3], ahead[3];   /* a point of that edge, and the unit direction */
    double length;            /* so far */
} psplat_surface_walk;

/* Returns the edge of the triangle across that runs along an edge, which must have a neighbour. */
uint32_t psplat_surface_edge_across(const psplat_surface *surface, uint32_t edge);

/* Starts at the middle of an edge, into its triangle and at a right angle to the edge. */
psplat_surface_walk psplat_surface_walk_begin(const psplat_surface *surface, uint32_t edge);

/* Finds the edge through which the walk leaves its triangle; PSPLAT_NONE where the triangle has no
 * width. Returns how far ahead that is, a length. */
double psplat_surface_walk_exit(const psplat_surface_walk *walk, uint32_t *exit);

/* Goes on to the next triangle. Returns 0, at the far side of its own one, where a crease or border
 * ends the walk. */
int psplat_surface_walk_on(psplat_surface_walk *walk);

#endif
