/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rays.h - whether rays from outside that meet the visible source meet the tested surface there:
 * cracks and holes that show from some side, also where every point is covered along its normal.
 */
#ifndef PHONGSPLAT_COMPARE_RAYS_H
#define PHONGSPLAT_COMPARE_RAYS_H

#include <phongsplat/phongsplat.h>
#include <phongsplat/splat.h>

#include "compare/source_mesh.h"

#include <stdint.h>

/* The ranges of the cosine between a ray and the normal of the face that it meets, each as wide,
 * from PSPLAT_LEAST_RAY_COSINE to 1; and the most places that are kept. */
enum { PSPLAT_RAY_RANGES = 4, PSPLAT_RAY_PLACES = 8 };
#define PSPLAT_LEAST_RAY_COSINE 0.2

/* A missed ray: the point of the source, in the coordinates of its file, the unit direction to the
 * eye, and the cosine between that and the face's normal. */
typedef struct psplat_ray_place {
    double point[3], direction[3], cosine;
} psplat_ray_place;

/* The rays that see a point of the source from outside. One is met where a front of the tested
 * surface, or the wall under the rim of a splat that is not flat (spec 5.1), lies on it within
 * reach / cosine of that point. Of the others, one is hidden where one lies before that, and else
 * missed: then the eye sees the background, or another part of the model. Rays that pass an outline
 * of the source by less than the reach are counted apart: where a surface errs by the reach, so do
 * its outlines, and a ray that sees the rim of the source may pass by its splats
 * (psplat_sight_is_inner). */
typedef struct psplat_ray_errors {
    size_t count, missed, hidden;
    size_t outline; /* neither met nor hidden, but within the reach of an outline of the source */
    size_t open;    /* of those missed: that meet neither at all, so that the background shows */
    size_t range_count[PSPLAT_RAY_RANGES], range_missed[PSPLAT_RAY_RANGES];
    double reach; /* %, that was used */
    size_t place_count;
    psplat_ray_place places[PSPLAT_RAY_PLACES]; /* missed rays, those most straight on first */
} psplat_ray_errors;

/* Returns the part of the rays that missed, %; 0 where there are none. */
double psplat_rays_missed_percent(const psplat_ray_errors *errors);

/* Returns the least cosine of a range 0 ... PSPLAT_RAY_RANGES, the last of which is 1. */
double psplat_rays_least_cosine(int range);

/* A zero in a member means its default. */
typedef struct psplat_ray_desc {
    size_t rays;  /* tried: points uniform by area, directions uniform by solid angle; those that
                     the source itself hides are left out; default 100,000 */
    double reach; /* % of the source's diagonal; default half of the greatest depth tolerance of
                     the asset (spec 5.3), which is the tolerance of its conversion or a little
                     less, or half of that where layers lie close to each other
                     (finish/depth_tolerance.h); a quarter % for a mesh */
    uint64_t seed;
} psplat_ray_desc;

/* Measures an asset in the coordinates of the source file. The result does not depend on the number
 * of threads. Errors: MEMORY, RANGE. */
psplat_result psplat_rays_compare(const psplat_source_mesh *source, const psplat_asset *asset,
                                  const psplat_ray_desc *desc, psplat_ray_errors *errors,
                                  psplat_error *error);

/* Measures several assets (count) that are shown together, such as tiles. */
psplat_result psplat_rays_compare_assets(const psplat_source_mesh *source,
                                         const psplat_asset *const *assets, size_t count,
                                         const psplat_ray_desc *desc, psplat_ray_errors *errors,
                                         psplat_error *error);

/* Measures another mesh in the same way. */
psplat_result psplat_rays_compare_mesh(const psplat_source_mesh *source,
                                       const psplat_source_mesh *mesh, const psplat_ray_desc *desc,
                                       psplat_ray_errors *errors, psplat_error *error);

#endif
