/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_cell.h - convex polygons of a region's parameters.
 */
#ifndef PHONGSPLAT_MEASURE_REGION_CELL_H
#define PHONGSPLAT_MEASURE_REGION_CELL_H

#include "base/region.h"

#include <stddef.h>

/* The most corners of a cell; one with more is replaced by its box. */
enum { PSPLAT_CELL_CORNERS = 32 };

/* A convex polygon in (u, v), counter-clockwise; without corners it is empty. */
typedef struct psplat_cell {
    double corners[PSPLAT_CELL_CORNERS][2];
    size_t count;
} psplat_cell;

/* Returns a polygon of 16 sides around the unit disc. */
psplat_cell psplat_cell_of_disc(void);

/* Keeps the part of a cell with line[0] u + line[1] v + line[2] >= 0. */
void psplat_cell_clip(psplat_cell *cell, const double line[3]);

/* Cuts off what lies beyond the rim of a region, as far as a few straight lines do. The cell
 * becomes empty where it lies outside. */
void psplat_cell_clip_by_rim(const psplat_region *region, psplat_cell *cell);

/* Stores the box of a cell that is not empty, and the mean of its corners. */
void psplat_cell_box(const psplat_cell *cell, double low[2], double high[2]);
void psplat_cell_mean(const psplat_cell *cell, double mean[2]);

/* Returns whether more than an end of a segment lies inside a cell, by more than a length; 1 rather
 * than 0 where rounding decides. */
int psplat_cell_holds_segment(const psplat_cell *cell, const double a[2], const double b[2],
                              double slack);

#endif
