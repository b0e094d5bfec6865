/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * nearness.h - whether points and regions are within the tolerance of the mesh, by its proxy if it
 * has one.
 */
#ifndef PHONGSPLAT_FIT_NEARNESS_H
#define PHONGSPLAT_FIT_NEARNESS_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "fit/fit_context.h"

/* These store in *near whether a point, or all of a region, is within limits->tolerance of the mesh
 * (psplat_distance_is_within, psplat_region_near), whose tree must not be NULL for points; a region
 * is near where there is none. What is near is near for certain; with a proxy, what is near by less
 * than twice its deviation may count as farther. *guess is as there. They fail only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_limits_point_near(const psplat_limits *limits, const double point[3],
                                       uint32_t *guess, int *near);
psplat_result psplat_limits_region_near(const psplat_limits *limits, const psplat_region *region,
                                        int *near);

/* Returns all of a candidate's region that has to be near: lines at borders of charts keep more,
 * since the surface goes on there, and those lines will be seams, beyond which the splat is still
 * there (finish/open_seams.h). */
psplat_region psplat_region_beyond_charts(const psplat_region *region);

#endif
