/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * poisson_thin.h - Poisson disc thinning of a point set.
 */
#ifndef PHONGSPLAT_POINTS_POISSON_THIN_H
#define PHONGSPLAT_POINTS_POISSON_THIN_H

#include <stddef.h>
#include <stdint.h>

/* Keeps points in the order of their indices so that no two are closer than radius. Points whose
 * normals face away from each other may be closer, since they are on the two sides of a sheet;
 * normals is NULL if they are unknown. owners[i] is the kept point near point i, as an index into
 * kept. kept and owners have room for count. Returns the number of kept points, or 0 when out of
 * memory. */
size_t psplat_poisson_thin(const double *positions, const float *normals, size_t count,
                           double radius, uint32_t *kept, uint32_t *owners);

#endif
