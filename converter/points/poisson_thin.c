/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * poisson_thin.c - Poisson disc thinning of a point set.
 *
 * This is dart throwing in the order of the points, with a hash grid of the points that are kept.
 */
#include "points/poisson_thin.h"

#include "base/vector.h"
#include "points/point_cloud.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct dart_grid {
    const double *positions;
    const float *normals;
    const uint32_t *kept;
    uint32_t *heads, *nexts; /* chains of kept points, by cell */
    size_t mask;
    double radius;
} dart_grid;

static size_t slot_of(const dart_grid *grid, const int64_t cell[3]) {
    uint64_t hash = (uint64_t)cell[0] * 0x9e3779b97f4a7c15u ^
                    (uint64_t)cell[1] * 0xc2b2ae3d27d4eb4fu ^
                    (uint64_t)cell[2] * 0x165667b19e3779f9u;
    return (size_t)(hash ^ (hash >> 31)) & grid->mask;
}

static void cell_of(const dart_grid *grid, uint32_t point, int64_t cell[3]) {
    for (int k = 0; k < 3; ++k)
        cell[k] = (int64_t)floor(grid->positions[3 * (size_t)point + (size_t)k] / grid->radius);
}

/* Returns whether the normals of two points face away from each other. */
static int face_away(const dart_grid *grid, uint32_t a, uint32_t b) {
    if (!grid->normals) return 0;
    const float *m = grid->normals + 3 * (size_t)a, *n = grid->normals + 3 * (size_t)b;
    return m[0] * n[0] + m[1] * n[1] + m[2] * n[2] < 0;
}

/* Returns the first kept point found that is closer than the radius, as an index into kept, or
 * PSPLAT_NO_POINT. The search begins with the cell of the point itself. */
static uint32_t find_owner(const dart_grid *grid, uint32_t point) {
    int64_t base[3], cell[3];
    cell_of(grid, point, base);
    for (int n = 0; n < 27; ++n) {
        int at = n < 14 ? 13 - n : n; /* 13 is the cell of the point */
        cell[0] = base[0] + at % 3 - 1, cell[1] = base[1] + at / 3 % 3 - 1;
        cell[2] = base[2] + at / 9 - 1;
        for (uint32_t i = grid->heads[slot_of(grid, cell)]; i != PSPLAT_NO_POINT;
             i = grid->nexts[i]) {
            double d[3];
            sub3(d, grid->positions + 3 * (size_t)grid->kept[i],
                 grid->positions + 3 * (size_t)point);
            if (dot3(d, d) < grid->radius * grid->radius && !face_away(grid, grid->kept[i], point))
                return i;
        }
    }
    return PSPLAT_NO_POINT;
}

size_t psplat_poisson_thin(const double *positions, const float *normals, size_t count,
                           double radius, uint32_t *kept, uint32_t *owners) {
    size_t size = 1024, kept_count = 0;
    while (size < count) size *= 2;
    dart_grid grid = {
        positions, normals, kept, malloc(size * sizeof(uint32_t)), malloc(count * sizeof(uint32_t)),
        size - 1,  radius};
    if (grid.heads && grid.nexts) {
        memset(grid.heads, 0xff, size * sizeof(uint32_t));
        for (uint32_t i = 0; i < count; ++i) {
            owners[i] = find_owner(&grid, i);
            if (owners[i] != PSPLAT_NO_POINT) continue;
            int64_t cell[3];
            cell_of(&grid, i, cell);
            uint32_t *head = &grid.heads[slot_of(&grid, cell)];
            owners[i] = (uint32_t)kept_count++;
            kept[owners[i]] = i;
            grid.nexts[owners[i]] = *head;
            *head = owners[i];
        }
    }
    free(grid.heads);
    free(grid.nexts);
    return kept_count;
}
