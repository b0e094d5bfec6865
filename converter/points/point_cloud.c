/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * point_cloud.c - statistics of a point set on its way to a mesh.
 */
#include "points/point_cloud.h"

#include <stdlib.h>

static int compare_doubles(const void *left, const void *right) {
    const double *a = left, *b = right;
    return *a < *b ? -1 : *a > *b;
}

double psplat_points_median(double *values, size_t count) {
    qsort(values, count, sizeof *values, compare_doubles);
    return values[count / 2];
}
