/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * point_blend.h - the blend of the splats at a surface point, seen along the surface's normal.
 */
#ifndef PHONGSPLAT_MEASURE_POINT_BLEND_H
#define PHONGSPLAT_MEASURE_POINT_BLEND_H

#include "measure/measured_splats.h"

#include <stdint.h>

/* The two passes over the splats at one point (spec 5.1 to 5.4). The caller sets the members up to
 * limit, passes each splat to psplat_point_blend_limit where splats may hide others, and then each
 * to psplat_point_blend_add. */
typedef struct psplat_point_blend {
    const psplat_measured_splats *measured;
    double point[3], normal[3]; /* of the surface; the normal is a unit vector */
    double reach;               /* greatest distance of a fragment along the normal */
    double limit;               /* least height of a fragment that is not hidden; first -HUGE_VAL */
    /* The sums (spec eq. 6) of weighted normals, with and without gradients: 0 0 0 where nothing is
     * seen. */
    double blended[3], constant[3];
    double color[3], flat_color[3]; /* the sums of weighted colours, with and without gradients */
    double finish[5];               /* of emissive R G B, roughness and metallic */
    double weight;                  /* the sum of weights */
} psplat_point_blend;

/* Raises the limit to the height below which a splat hides others, where its front is seen. Returns
 * 0 where it is not seen, so that there is nothing to add either. */
int psplat_point_blend_limit(psplat_point_blend *blend, uint32_t splat);

/* Stores where in a splat (u, v) its fragment at the point lies, hidden or not. Returns 0 where it
 * has none: where the line along the surface's normal does not meet its front within reach. */
int psplat_point_blend_meet(const psplat_point_blend *blend, uint32_t splat, double uv[2]);

/* Adds the fragment of a splat, where its front is seen and it is not hidden. */
void psplat_point_blend_add(psplat_point_blend *blend, uint32_t splat);

#endif
