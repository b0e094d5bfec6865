/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_frame.h - conversion between the rotation quaternion of a splat and its axes U, V, N.
 */
#ifndef PHONGSPLAT_SPLATS_SPLAT_FRAME_H
#define PHONGSPLAT_SPLATS_SPLAT_FRAME_H

#include <phongsplat/splat.h>

#include "base/region.h"

/* Finds the unit quaternion x y z w, with w >= 0, of the rotation whose columns are u, v and n.
 * These are unit vectors, each perpendicular to the others, and right-handed. */
void psplat_quaternion_of_axes(const double u[3], const double v[3], const double n[3],
                               float rotation[4]);

/* Finds the region of a splat, in double precision. The last seam_lines of its clip lines are
 * seams. */
void psplat_splat_region(const psplat_splat *splat, uint32_t seam_lines, psplat_region *region);

#endif
