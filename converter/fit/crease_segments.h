/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_segments.h - the parts of crease edges that lie inside a region.
 */
#ifndef PHONGSPLAT_FIT_CREASE_SEGMENTS_H
#define PHONGSPLAT_FIT_CREASE_SEGMENTS_H

#include "base/region.h"
#include "features/neighborhood.h"
#include "features/surface.h"

#include <stdint.h>

/* The part of a crease inside a region: its ends as (u, v, height), the surface to its left. */
typedef struct psplat_segment {
    double a[3], b[3];
    uint32_t vertex[2]; /* the crease edge's ends, before clipping */
    uint32_t triangle;  /* to the left of the crease edge */
    uint32_t across;    /* triangle on the other side, or PSPLAT_NONE */
    int is_smooth;      /* 1: no crease: the surface goes on across (PSPLAT_BOUND_...) */
    int is_chart;       /* 1: a border of charts alone */
    int is_tangent;     /* 1: neither a crease nor a border of charts: only the curvature jumps */
    int is_facet;       /* 1: none of these: the edge of a facet */
} psplat_segment;

/* Finds the parts of crease edges (3 x triangle + side) that lie inside the region's ellipse and
 * lines. It leaves out edges whose triangle faces away from the region, and parts both of whose
 * ends are farther from its plane than height. segments has room for crease_count. Returns their
 * number.
 */
size_t psplat_segments_find(const psplat_surface *surface, const uint32_t *creases,
                            size_t crease_count, const psplat_region *region, double height,
                            psplat_segment *segments);

/* Does the same for the creases of a neighbourhood. */
size_t psplat_segments_find_near(const psplat_surface *surface, const psplat_neighborhood *near,
                                 const psplat_region *region, double height,
                                 psplat_segment *segments);

#endif
