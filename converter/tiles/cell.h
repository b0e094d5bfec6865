/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cell.h - the cells of tiles: boxes of the binary tree that halves a root box at the middle of its
 * longest side, again and again.
 *
 * The tree depends on the root box alone, so that cells of any two cuts of it nest or are apart.
 */
#ifndef PHONGSPLAT_TILES_CELL_H
#define PHONGSPLAT_TILES_CELL_H

#include <stddef.h>

/* The greatest depth of a cell: 2^20 halvings of each side. */
enum { PSPLAT_MOST_CELL_DEPTH = 60 };

/* Room for the path of a cell: characters 0 (lower half) and 1 (upper half) from the root on, and a
 * zero. The path of the root is "". */
enum { PSPLAT_CELL_PATH = PSPLAT_MOST_CELL_DEPTH + 1 };

/* A cell, in the coordinates of the source. It holds its lower sides but not its upper ones, except
 * for those that are the root's. */
typedef struct psplat_tile_cell {
    double low[3], high[3];
    int holds_high[3]; /* 1: the upper side along this axis is the root's */
    char path[PSPLAT_CELL_PATH];
    size_t depth; /* the length of path */
} psplat_tile_cell;

/* Returns the root cell with these corners. */
psplat_tile_cell psplat_tile_cell_root(const double low[3], const double high[3]);

/* Returns the axis of the longest side, the first of equals, at whose middle a cell is halved. */
int psplat_tile_cell_axis(const psplat_tile_cell *cell);

/* Returns half 0 (lower) or 1 (upper) of a cell whose depth is less than the greatest. */
psplat_tile_cell psplat_tile_cell_half(const psplat_tile_cell *cell, int half);

/* Finds the cell of a path. Returns 0 where the path is none or too long. */
int psplat_tile_cell_find(const psplat_tile_cell *root, const char *path, psplat_tile_cell *cell);

/* Returns whether a point of the root lies in a cell. Every point does in one of two halves. */
int psplat_tile_cell_holds(const psplat_tile_cell *cell, const double point[3]);

/* Moves a point that rounding has put beside a side of a cell onto that side. extent is the
 * greatest coordinate of what the point was computed from. */
void psplat_tile_cell_settle(const psplat_tile_cell *cell, double extent, double point[3]);

/* Returns how far a point is from a cell; 0 within. */
double psplat_tile_cell_distance(const psplat_tile_cell *cell, const double point[3]);

/* Returns whether a triangle, given by its corners, meets a cell: never 0 where it does; 1 also
 * where it only touches, up to rounding, a side that the cell holds. A triangle that lies in the
 * plane between two halves meets the upper one alone. */
int psplat_tile_cell_meets_triangle(const psplat_tile_cell *cell, const double corners[9]);

/* Returns whether the path of one cell begins with that of another: the first one lies in it. */
int psplat_tile_path_is_in(const char *path, const char *outer);

#endif
