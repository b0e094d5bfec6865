/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_flood.h - the triangles that are connected with one, within reach of a point.
 */
#ifndef PHONGSPLAT_FEATURES_TRIANGLE_FLOOD_H
#define PHONGSPLAT_FEATURES_TRIANGLE_FLOOD_H

#include "base/region.h"
#include "features/metric.h"
#include "features/surface.h"

#include <stddef.h>
#include <stdint.h>

/* The last flood: memory of one thread for one surface. Zero-initialise it. */
typedef struct psplat_triangle_flood {
    uint32_t *stamps; /* per triangle: the flood that met it last */
    uint32_t stamp;
    uint32_t *triangles; /* those that it met, triangle_count; room for all of the surface */
    size_t triangle_count;
} psplat_triangle_flood;

/* Floods from a triangle, over edges that are neither creases nor borders of charts, what is no
 * farther from a splat's centre than the splat reaches and a margin (a length). Returns 0 when out
 * of memory. */
int psplat_triangle_flood_around(psplat_triangle_flood *flood, const psplat_surface *surface,
                                 const psplat_region *region, double margin, uint32_t triangle);

/* Floods from a triangle, over edges that are neither creases nor borders of charts, what the
 * region covers or is no farther from that than a margin (a length): the triangles that meet it
 * when they are put onto its plane, at heights that its surface has there. So a flood around the
 * neck of a vase does not come back to the region from behind. Returns 0 when out of memory. */
int psplat_triangle_flood_beneath(psplat_triangle_flood *flood, const psplat_surface *surface,
                                  const psplat_region *region, double margin, uint32_t triangle);

/* Begins a flood that has met nothing yet. Returns 0 when out of memory. */
int psplat_triangle_flood_begin(psplat_triangle_flood *flood, const psplat_surface *surface);

/* Goes on with a flood from one more triangle, unless it has met that: as
 * psplat_triangle_flood_beneath, but over creases and borders of charts too. */
void psplat_triangle_flood_add_beneath(psplat_triangle_flood *flood, const psplat_surface *surface,
                                       const psplat_region *region, double margin,
                                       uint32_t triangle);

/* Returns whether the last flood met a triangle: one that it is about, that which it started from,
 * or, of psplat_triangle_flood_around, one next to these. */
int psplat_triangle_flood_met(const psplat_triangle_flood *flood, uint32_t triangle);

/* Makes a triangle one that the last flood has not met; it stays in the list. */
void psplat_triangle_flood_forget(psplat_triangle_flood *flood, uint32_t triangle);

/* Returns whether a triangle comes within reach of a metric's centre. */
int psplat_triangle_within(const psplat_surface *surface, const psplat_metric *metric,
                           uint32_t triangle, double reach);

/* Frees what the flood owns, and zeroes it. */
void psplat_triangle_flood_free(psplat_triangle_flood *flood);

#endif
