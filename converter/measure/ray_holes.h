/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ray_holes.h - rays that see the surface and pass between the splats that should be there.
 */
#ifndef PHONGSPLAT_MEASURE_RAY_HOLES_H
#define PHONGSPLAT_MEASURE_RAY_HOLES_H

#include <phongsplat/splat.h>

#include "base/region_tree.h"
#include "features/surface.h"
#include "measure/measured_splats.h"
#include "measure/ray_meeting.h"
#include "mesh/distance.h"

#include <stdint.h>

/* The least cosine of a ray to the normal of the face that it sees at which splats have to be
 * whole. Rays from rims, which show folds and slits, are tried down to the flatter one.
 */
#define PSPLAT_LEAST_SIGHT_COSINE 0.2
#define PSPLAT_FLATTEST_SIGHT_COSINE 0.08

/* How far along a ray from the point that it sees, in tolerances over its cosine, a splat still
 * hides that the ray is a hole: beyond one it stands too high or too low, but nobody sees through
 * the surface there. */
#define PSPLAT_HIDING_TOLERANCES 1.5

/* How far down the walls under rims are taken to reach (spec 5.1), in tolerances: a quarter of the
 * depth tolerance, and that mostly is two (depth_tolerance.h). */
#define PSPLAT_WALL_TOLERANCES 0.5

/* A ray that sees a point of a triangle, with that cosine, and meets no splat there. */
typedef struct psplat_ray_hole {
    psplat_sight sight;
    double cosine;
    uint32_t triangle;
} psplat_ray_hole;

typedef struct psplat_ray_holes {
    psplat_ray_hole *holes; /* count */
    size_t count;
} psplat_ray_holes;

/* Which rays are tried: 24 from each of so many points, which are uniform by area, and 16 past the
 * rims of splats at points so far apart, but for those in the surface's apron; their directions
 * are spread over all sides and cosines, with more of them where rays are slanted. */
typedef struct psplat_ray_search {
    const psplat_surface *surface;
    const psplat_measured_splats *measured; /* only the tree, the regions, the tolerance and the
                                               walls count */
    const psplat_distance *distance;        /* to the surface */
    const psplat_measured_splats *hiders;   /* NULL, or what matters, of which only the tree, the
                                               regions and the walls count: rays that none of them
                                               would hide are left out */
    size_t points;
    double rim_spacing; /* a length; 0: no rays past rims */
    uint64_t seed;
} psplat_ray_search;

/* Finds the rays that meet no splat's front, and no wall, within the tolerance over their cosine of
 * the point that they see, and that one of the hiders would hide where hiders is not NULL. The
 * result does not depend on the number of threads; psplat_ray_holes_free frees it. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_ray_holes_find(const psplat_ray_search *search, psplat_ray_holes *holes);

/* Returns whether a ray meets the front of a region within the tolerance over its cosine of the
 * point that it sees. */
int psplat_ray_hole_is_closed(const psplat_ray_hole *hole, const psplat_region *region,
                              double tolerance);

/* Returns whether the front of a region, or its wall, which reaches down by a length, hides that a
 * ray is a hole. */
int psplat_ray_hole_is_hidden(const psplat_ray_hole *hole, const psplat_region *region,
                              double tolerance, double wall);

/* Returns whether one sees through the surface along a ray: whether none of these splats hides it.
 * As in a search, only the tree, the regions, the tolerance and the walls count. */
int psplat_ray_hole_shows(const psplat_ray_hole *hole, const psplat_measured_splats *measured);

/* Frees the rays, and zeroes holes. */
void psplat_ray_holes_free(psplat_ray_holes *holes);

#endif
