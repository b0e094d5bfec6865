/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stand_off.c - how far rims of splats stand off from the surface.
 */
#include "finish/stand_off.h"

#include "base/vector.h"
#include "features/surface.h"
#include "mesh/distance.h"

/* What rounding may put a point of the rim beyond it, in units of u and v. */
static const double rim_slack = 1e-9;

psplat_result psplat_stand_off_find(const psplat_fit_context *context, const psplat_region *region,
                                    const double uv[2], uint32_t *guess,
                                    psplat_stand_off *stand_off) {
    double nearest[3], away[3];
    uint32_t triangle;
    *stand_off = (psplat_stand_off){.triangle = PSPLAT_NONE};
    if (!psplat_region_contains(region, uv, 1 + rim_slack, 0)) return PSPLAT_OK;
    psplat_region_point(region, uv, stand_off->point);
    psplat_result result = psplat_distance_nearest(context->limits->distance, stand_off->point,
                                                   guess, nearest, &triangle);
    if (result || triangle == PSPLAT_NONE) return result;
    sub3(away, stand_off->point, nearest);
    if (!(dot3(away, context->surface->face_normals + 3 * (size_t)triangle) > 0)) return PSPLAT_OK;
    stand_off->length = length3(away);
    stand_off->triangle = triangle;
    return PSPLAT_OK;
}
