/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_fit.h - the least-squares fit of a splat's curved surface to samples.
 */
#ifndef PHONGSPLAT_FIT_SURFACE_FIT_H
#define PHONGSPLAT_FIT_SURFACE_FIT_H

#include "base/region.h"
#include "features/neighborhood.h"

#include <stddef.h>
#include <stdint.h>

/* The greatest slope of a splat's surface over its ellipse: spec (1b) allows 4, advises 3, and
 * rounding to a file's integers may add to it. */
#define PSPLAT_GREATEST_SURFACE_SLOPE 2.75

/* The sagitta, in tolerances, up to which a splat is flat instead: nobody sees the difference, and
 * a flat one is drawn faster. Chosen by hand. */
#define PSPLAT_FLAT_PART 0.25

/* Returns how far a region's surface leaves its tangent plane at the centre, a length. */
double psplat_surface_sagitta(const psplat_region *region);

/* Returns the greatest slope of a region's surface over its ellipse, as spec (1b) bounds it. */
double psplat_surface_slope_bound(const psplat_region *region);

/* Fits a quadric to count samples (some: their indices; NULL: the first ones), whose positions are
 * relative to origin, by their heights and, with a small weight, by their normals. The region's
 * axes are turned about its centre, and that is moved along its normal, so that the surface passes
 * through the centre with normal n: its slope there is 0. Radii only set the scale; lines stay.
 * Where the normals would move the surface off the heights by more than most_pull (a length, root
 * mean square; HUGE_VAL: any), as those of a box with smooth normals do, heights alone count.
 * Returns 0, with the region flat, where the surface would be too steep at the centre. */
int psplat_fit_surface(const psplat_near_sample *samples, const uint32_t *some, size_t count,
                       const double origin[3], double most_pull, psplat_region *region);

#endif
