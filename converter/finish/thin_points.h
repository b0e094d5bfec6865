/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * thin_points.h - few of many points: one of each cube.
 */
#ifndef PHONGSPLAT_FINISH_THIN_POINTS_H
#define PHONGSPLAT_FINISH_THIN_POINTS_H

#include <stddef.h>
#include <stdint.h>

/* Keeps of *count points (indices of positions, x, y, z each) that of each cube of this side, a
 * length, which has the smallest index, sorted by cubes, and stores how many are left. Returns 0
 * when out of memory. */
int psplat_thin_points(const double *positions, double side, uint32_t *points, size_t *count);

#endif
