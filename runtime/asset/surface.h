/* SPDX-License-Identifier: MIT
 *
 * surface.h - the surface of a splat, flat or curved, as the reader checks and bounds it.
 */
#ifndef PHONGSPLAT_ASSET_SURFACE_H
#define PHONGSPLAT_ASSET_SURFACE_H

#include <phongsplat/splat.h>

/* Finds the columns U, V, N of the rotation by quaternion q. */
static inline void psplat_rotation_axes(const float q[4], double axes[3][3]) {
    double x = (double)q[0], y = (double)q[1], z = (double)q[2], w = (double)q[3];
    axes[0][0] = 1 - 2 * (y * y + z * z);
    axes[0][1] = 2 * (x * y + z * w);
    axes[0][2] = 2 * (x * z - y * w);
    axes[1][0] = 2 * (x * y - z * w);
    axes[1][1] = 1 - 2 * (x * x + z * z);
    axes[1][2] = 2 * (y * z + x * w);
    axes[2][0] = 2 * (x * z + y * w);
    axes[2][1] = 2 * (y * z - x * w);
    axes[2][2] = 1 - 2 * (x * x + y * y);
}

/* Stores the x and y of a splat's normal field (spec eq. 3). */
void psplat_surface_find_tilt(const psplat_splat *splat, float tilt[2]);

/* Returns whether the shape of a splat fulfils spec eq. (1b). */
int psplat_surface_is_allowed(const psplat_splat *splat);

/* How far from its centre a surface that fulfils (1b) may reach, in radii r_u: no height is more
 * than 4 of them, so that it is the root of 17, and a little for rounding. */
#define PSPLAT_CURVED_REACH 4.1232

/* Finds an axis-aligned box around the whole surface of a splat, without its clip lines, relative
 * to its centre. */
void psplat_surface_find_box(const psplat_splat *splat, double low[3], double high[3]);

#endif
