/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ray_meeting.h - where a ray meets the splats of a place (spec 5.1, 5.2), in double precision.
 */
#ifndef PHONGSPLAT_MEASURE_RAY_MEETING_H
#define PHONGSPLAT_MEASURE_RAY_MEETING_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "mesh/distance.h"

/* A line through a point of the surface, along a unit direction that leads outwards, to the eye. */
typedef struct psplat_sight {
    double point[3], direction[3];
} psplat_sight;

/* Finds where the sight leaves the front of the surface that a region is a part of, as if its
 * ellipse and its lines ended nowhere: *height and uv as below. Returns 0 where it does not. */
int psplat_sight_leaves(const psplat_sight *sight, const psplat_region *region, double *height,
                        double uv[2]);

/* Finds where an eye far along the sight, which does not see the front of a curved splat, sees the
 * wall under its rim (spec 5.1), which reaches down by a length: *height and uv as below. Returns 0
 * where it does not. */
int psplat_sight_meets_wall(const psplat_sight *sight, const psplat_region *region, double wall,
                            double *height, double uv[2]);

/* Finds where an eye far along the sight sees the front of a splat's surface, or the wall under its
 * rim, which reaches down by a length: *height is how far along the direction from the point, a
 * length, which is negative behind the point; uv are the parameters there. Returns 0 where the line
 * misses both, or meets the front outside the ellipse, or either beyond a clip line. Rounding may
 * widen ellipse and lines by slack, in units of u, v and of the lines' values. */
int psplat_sight_meets(const psplat_sight *sight, const psplat_region *region, double wall,
                       double slack, double *height, double uv[2]);

/* The directions whose cosine to a normal is at least this. */
typedef struct psplat_sight_cone {
    double cosine, sine;
} psplat_sight_cone;

/* Returns the first of some cones, the widest first, of which every ray that leaves through a point
 * surely meets the front of a splat, as psplat_sight_meets finds it, within the tolerance over the
 * ray's cosine of the point; else count. normal is the unit axis of the cones, and bend is
 * psplat_region_bend of the region. The bound needs no ray: it takes the way to the surface along
 * the flattest ray, and asks whether the region holds a disc of that radius. */
int psplat_sight_cones_meet(const psplat_region *region, double bend, const double point[3],
                            const double normal[3], double tolerance,
                            const psplat_sight_cone *cones, int count);

/* Stores in *is_free whether nothing of the mesh lies on the sight before its point, whichever side
 * it shows. length is that of the way to the eye; the first ten-millionth of it does not count,
 * since points are rounded. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_sight_is_free(const psplat_sight *sight, const psplat_distance *distance,
                                   double length, int *is_free);

/* Stores in *is_inner whether the point that a sight sees lies inside the outline of the mesh, seen
 * from there, by more than a tolerance: whether the sight, moved along the normal of its face and
 * against it by that length, meets fronts nearby. Where every point is within the tolerance,
 * outlines may move by as much, and a sight that is not inner may pass by with good reason. cosine
 * is that of the sight to the normal. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_sight_is_inner(const psplat_sight *sight, const double normal[3],
                                    double cosine, const psplat_distance *distance,
                                    double tolerance, int *is_inner);

#endif
