/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * thin_points.c - few of many points: one of each cube.
 */
#include "finish/thin_points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A point and the cube that it is in. */
typedef struct cube_point {
    int64_t cube[3];
    uint32_t point;
} cube_point;

static int compare_cubes(const void *left, const void *right) {
    const cube_point *a = left, *b = right;
    for (int k = 0; k < 3; ++k)
        if (a->cube[k] != b->cube[k]) return a->cube[k] < b->cube[k] ? -1 : 1;
    return a->point < b->point ? -1 : a->point > b->point;
}

int psplat_thin_points(const double *positions, double side, uint32_t *points, size_t *count) {
    cube_point *sorted = malloc((*count + 1) * sizeof *sorted);
    size_t kept = 0;
    if (!sorted) return 0;
    for (size_t i = 0; i < *count; ++i) {
        const double *p = positions + 3 * (size_t)points[i];
        sorted[i].point = points[i];
        for (int k = 0; k < 3; ++k) sorted[i].cube[k] = (int64_t)floor(p[k] / side);
    }
    qsort(sorted, *count, sizeof *sorted, compare_cubes);
    for (size_t i = 0; i < *count; ++i)
        if (!i || memcmp(sorted[i].cube, sorted[i - 1].cube, sizeof sorted->cube) != 0)
            points[kept++] = sorted[i].point;
    *count = kept;
    free(sorted);
    return 1;
}
