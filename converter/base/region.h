/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region.h - the shape of a splat: an elliptical surfel cut by clip lines.
 */
#ifndef PHONGSPLAT_BASE_REGION_H
#define PHONGSPLAT_BASE_REGION_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

/* A convex part of a plane: an ellipse cut by clip lines. Parameters (u, v) are coordinates along
 * the axes in units of the radii, so that the ellipse is the unit disc. A line (a, b, c) keeps the
 * points with a u + b v + c >= 0 (spec 3.6). */
typedef struct psplat_region {
    double center[3];
    double u[3], v[3], n[3]; /* orthonormal */
    double radius[2];
    double lines[PSPLAT_MAX_CLIP_LINES][3];
    uint32_t line_count;
} psplat_region;

/* Stores the parameters (u, v) of a point and its height above the plane, in units of length. */
void psplat_region_local(const psplat_region *region, const double point[3], double uvh[3]);

/* Whether (u, v) lies in the region, with its ellipse scaled by scale and its lines moved outwards
 * by slack, in units of their values. */
int psplat_region_contains(const psplat_region *region, const double uv[2], double scale,
                           double slack);

/* Stores the region as a polygon in (u, v) with at most capacity corners, counter-clockwise: a
 * regular polygon that is inscribed in the unit circle or else circumscribed, cut by the lines.
 * Returns the number of corners, which is 0 if the lines leave nothing. */
size_t psplat_region_polygon(const psplat_region *region, int inscribed, double (*polygon)[2],
                             size_t capacity);

/* The capacity of the polygons at whose corners fits are checked: 16 corners are enough to notice a
 * fit that leaves the surface between samples. Chosen by hand. */
enum { PSPLAT_OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES };

/* Returns the area, in units of length squared, of the inscribed polygon of 64 sides. */
double psplat_region_area(const psplat_region *region);

/* The most points that psplat_region_points stores. */
#define PSPLAT_REGION_POINTS 145

/* Stores points that are spread over a region: its middle, the corners of its inscribed polygon,
 * and the points halfway between. points has room for PSPLAT_REGION_POINTS. Returns the count
 * stored. */
size_t psplat_region_points(const psplat_region *region, double (*points)[3]);

#endif
