/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * cell.c - the cells of tiles, and whether triangles meet them.
 */
#include "tiles/cell.h"

#include "base/vector.h"

#include <float.h>
#include <math.h>
#include <string.h>

psplat_tile_cell psplat_tile_cell_root(const double low[3], const double high[3]) {
    psplat_tile_cell cell = {.holds_high = {1, 1, 1}};
    memcpy(cell.low, low, sizeof cell.low);
    memcpy(cell.high, high, sizeof cell.high);
    return cell;
}

int psplat_tile_cell_axis(const psplat_tile_cell *cell) {
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (cell->high[k] - cell->low[k] > cell->high[axis] - cell->low[axis]) axis = k;
    return axis;
}

psplat_tile_cell psplat_tile_cell_half(const psplat_tile_cell *cell, int half) {
    psplat_tile_cell child = *cell;
    int axis = psplat_tile_cell_axis(cell);
    /* Corners of opposite signs and great magnitudes do not overflow like this. */
    double middle = 0.5 * cell->low[axis] + 0.5 * cell->high[axis];
    child.path[child.depth++] = half ? '1' : '0';
    child.path[child.depth] = 0;
    if (half) {
        child.low[axis] = middle;
    } else {
        child.high[axis] = middle;
        child.holds_high[axis] = 0;
    }
    return child;
}

int psplat_tile_cell_find(const psplat_tile_cell *root, const char *path, psplat_tile_cell *cell) {
    *cell = *root;
    for (; *path; ++path) {
        if ((*path != '0' && *path != '1') || cell->depth == PSPLAT_MOST_CELL_DEPTH) return 0;
        *cell = psplat_tile_cell_half(cell, *path == '1');
    }
    return 1;
}

int psplat_tile_cell_holds(const psplat_tile_cell *cell, const double point[3]) {
    for (int k = 0; k < 3; ++k) {
        if (!(point[k] >= cell->low[k] && point[k] <= cell->high[k])) return 0;
        if (point[k] == cell->high[k] && !cell->holds_high[k]) return 0;
    }
    return 1;
}

void psplat_tile_cell_settle(const psplat_tile_cell *cell, double extent, double point[3]) {
    for (int k = 0; k < 3; ++k) {
        double inside = min2(max2(point[k], cell->low[k]), cell->high[k]);
        double slack = 16 * DBL_EPSILON * max2(extent, fabs(inside));
        if (fabs(point[k] - inside) <= slack) point[k] = inside;
    }
}

double psplat_tile_cell_distance(const psplat_tile_cell *cell, const double point[3]) {
    double beside[3];
    for (int k = 0; k < 3; ++k)
        beside[k] = max2(max2(cell->low[k] - point[k], point[k] - cell->high[k]), 0);
    return length3(beside);
}

/* Returns whether the box of a triangle is beyond one side of a cell. */
static int is_beside(const psplat_tile_cell *cell, const double corners[9]) {
    for (int k = 0; k < 3; ++k) {
        double low = min2(corners[k], min2(corners[k + 3], corners[k + 6]));
        double high = max2(corners[k], max2(corners[k + 3], corners[k + 6]));
        if (high < cell->low[k] || low > cell->high[k]) return 1;
        if (low == cell->high[k] && !cell->holds_high[k]) return 1;
    }
    return 0;
}

/* Returns whether an axis separates a triangle, given relative to the middle of a cell, from the
 * cell with these halves of its sides. What rounding may have moved does not separate. */
static int separates(const double axis[3], double corners[3][3], const double halves[3],
                     double extent) {
    double low = HUGE_VAL, high = -HUGE_VAL, reach = 0, length = 0;
    for (int i = 0; i < 3; ++i) {
        double at = dot3(axis, corners[i]);
        low = min2(low, at);
        high = max2(high, at);
        reach += fabs(axis[i]) * halves[i];
        length += fabs(axis[i]);
    }
    double slack = 16 * DBL_EPSILON * length * extent;
    return low > reach + slack || high < -reach - slack;
}

/* The separating axes of a box and a triangle (Akenine-Möller 2001): the sides of the box, the
 * normal of the triangle, and the products of their edges. */
int psplat_tile_cell_meets_triangle(const psplat_tile_cell *cell, const double corners[9]) {
    double relative[3][3], edges[3][3], halves[3], axis[3], extent = 0;
    if (is_beside(cell, corners)) return 0;
    for (int k = 0; k < 3; ++k) {
        double middle = 0.5 * cell->low[k] + 0.5 * cell->high[k];
        halves[k] = 0.5 * cell->high[k] - 0.5 * cell->low[k];
        extent = max2(extent, fabs(middle) + halves[k]);
        for (int i = 0; i < 3; ++i) {
            relative[i][k] = corners[3 * i + k] - middle;
            extent = max2(extent, fabs(corners[3 * i + k]));
        }
    }
    for (int i = 0; i < 3; ++i) sub3(edges[i], relative[(i + 1) % 3], relative[i]);
    cross3(axis, edges[0], edges[1]);
    if (separates(axis, relative, halves, extent)) return 0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const double side[3] = {k == 0, k == 1, k == 2};
            cross3(axis, side, edges[i]);
            if (separates(axis, relative, halves, extent)) return 0;
        }
    return 1;
}

int psplat_tile_path_is_in(const char *path, const char *outer) {
    return !strncmp(path, outer, strlen(outer));
}
