/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region.h - the shape of a splat: an elliptical surfel, flat or curved, cut by clip lines.
 */
#ifndef PHONGSPLAT_BASE_REGION_H
#define PHONGSPLAT_BASE_REGION_H

#include <phongsplat/splat.h>

#include "base/vector.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* An ellipse cut by clip lines, and the surface over it. Parameters (u, v) are coordinates along
 * the axes in units of the radii, so that the ellipse is the unit disc. A line (a, b, c) of bend k
 * keeps the points with a u + b v + c + k (a v - b u)^2 / 2 >= 0 (spec 3.6); with k > 0 what it
 * keeps is not convex. Behind the lines that cut the region there may be seams (spec 3.6), which
 * bound what the material is and cut nothing off. At s along u and t along v, in lengths, the
 * surface has over the plane the height slope . (s, t) + (A s^2 + 2 B s t + C t^2) / 2 with A, B, C
 * = hessian (spec 3.4 in lengths). */
typedef struct psplat_region {
    double center[3];
    double u[3], v[3], n[3]; /* orthonormal */
    double radius[2];
    double lines[PSPLAT_MAX_CLIP_LINES][3];
    double bends[PSPLAT_MAX_CLIP_LINES]; /* 0: the line is straight */
    uint32_t line_count;                 /* of those that cut */
    uint32_t chart_lines; /* a bit for each line that was fitted to borders of charts alone */
    uint32_t seam_count;  /* of the seams, lines[line_count] on; both are PSPLAT_MAX_CLIP_LINES at
                             most */
    double slope[2], hessian[3]; /* of the surface; all 0: it is the plane */
} psplat_region;

/* Returns whether the surface differs from the plane. */
static inline int psplat_region_is_curved(const psplat_region *r) {
    return r->slope[0] != 0 || r->slope[1] != 0 || r->hessian[0] != 0 || r->hessian[1] != 0 ||
           r->hessian[2] != 0;
}

/* Stores the slopes of the surface along u and v at (u, v): lengths over lengths. */
static inline void psplat_region_slope(const psplat_region *r, const double uv[2],
                                       double slope[2]) {
    double s = uv[0] * r->radius[0], t = uv[1] * r->radius[1];
    slope[0] = r->slope[0] + r->hessian[0] * s + r->hessian[1] * t;
    slope[1] = r->slope[1] + r->hessian[1] * s + r->hessian[2] * t;
}

/* Returns the height of the surface over the plane at (u, v), a length. */
static inline double psplat_region_height(const psplat_region *r, const double uv[2]) {
    double slope[2];
    psplat_region_slope(r, uv, slope);
    return ((r->slope[0] + slope[0]) * uv[0] * r->radius[0] +
            (r->slope[1] + slope[1]) * uv[1] * r->radius[1]) /
           2;
}

/* Stores the point of the surface at (u, v). */
static inline void psplat_region_point(const psplat_region *r, const double uv[2],
                                       double point[3]) {
    memcpy(point, r->center, 3 * sizeof *point);
    mad3(point, uv[0] * r->radius[0], r->u);
    mad3(point, uv[1] * r->radius[1], r->v);
    mad3(point, psplat_region_height(r, uv), r->n);
}

/* Stores the unit normal of the surface at (u, v). */
static inline void psplat_region_normal(const psplat_region *r, const double uv[2],
                                        double normal[3]) {
    double slope[2];
    psplat_region_slope(r, uv, slope);
    memcpy(normal, r->n, 3 * sizeof *normal);
    mad3(normal, -slope[0], r->u);
    mad3(normal, -slope[1], r->v);
    normalize3(normal);
}

/* Returns the area of the whole ellipse over pi, whatever lines cut off, in units of area. */
static inline double psplat_region_ellipse(const psplat_region *r) {
    return r->radius[0] * r->radius[1];
}

/* Returns the radius of a sphere around the centre that holds the surface over all of the ellipse.
 */
double psplat_region_reach(const psplat_region *region);

/* Returns the greatest magnitude of the surface's second derivative, one over a length, and with
 * that how far it may leave a chord of length l: that times l^2 / 8. */
double psplat_region_bend(const psplat_region *region);

/* Stores the parameters (u, v) of a point and how far it lies above the surface, in units of
 * length: for a plane its height, else the height times the cosine of the surface's slope, which
 * is the distance up to the third order. */
static inline void psplat_region_local(const psplat_region *region, const double point[3],
                                       double uvh[3]) {
    double d[3], slope[2];
    sub3(d, point, region->center);
    uvh[0] = dot3(d, region->u) / region->radius[0];
    uvh[1] = dot3(d, region->v) / region->radius[1];
    uvh[2] = dot3(d, region->n);
    if (!psplat_region_is_curved(region)) return;
    psplat_region_slope(region, uvh, slope);
    uvh[2] = (uvh[2] - psplat_region_height(region, uvh)) /
             sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

/* Returns the value of clip line i at (u, v), which is at least 0 where the line keeps the point.
 */
static inline double psplat_region_line_value(const psplat_region *region, uint32_t i,
                                              const double uv[2]) {
    const double *line = region->lines[i];
    double along = line[0] * uv[1] - line[1] * uv[0];
    return line[0] * uv[0] + line[1] * uv[1] + line[2] + region->bends[i] * along * along / 2;
}

/* The factor of what a fragment beyond a seam weighs, but for its normal (spec 3.6). */
#define PSPLAT_SEAM_WEIGHT (1.0 / 256)

/* Returns whether (u, v) lies beyond a seam. */
static inline int psplat_region_is_beyond_seam(const psplat_region *region, const double uv[2]) {
    for (uint32_t i = 0; i < region->seam_count; ++i)
        if (psplat_region_line_value(region, region->line_count + i, uv) < 0) return 1;
    return 0;
}

/* Returns the part of a region that is inside all of its seams, which cut it. */
static inline psplat_region psplat_region_inside_seams(const psplat_region *region) {
    psplat_region inside = *region;
    inside.line_count += inside.seam_count;
    inside.seam_count = 0;
    return inside;
}

/* Gives a region, which has room for it, another line that cuts, behind the others and before the
 * seams. */
void psplat_region_add_line(psplat_region *region, const double line[3], double bend);

/* Takes the last line that cuts from a region, whose place becomes 0. */
void psplat_region_remove_line(psplat_region *region);

/* Stores the point (u, v) of clip line i, straight or bent, that is m along it: m is measured in
 * units of the radii from the line's point that is nearest to u = v = 0, along the straight line.
 */
void psplat_region_line_point(const psplat_region *region, uint32_t i, double m, double uv[2]);

/* Whether (u, v) lies in the region, with its ellipse scaled by scale and its lines moved outwards
 * by slack, in units of their values. */
static inline int psplat_region_contains(const psplat_region *region, const double uv[2],
                                         double scale, double slack) {
    if (uv[0] * uv[0] + uv[1] * uv[1] > scale * scale) return 0;
    for (uint32_t i = 0; i < region->line_count; ++i)
        if (psplat_region_line_value(region, i, uv) < -slack) return 0;
    return 1;
}

/* Stores the region as a polygon in (u, v) with at most capacity corners, counter-clockwise: a
 * regular polygon that is inscribed in the unit circle or else circumscribed, cut by the lines.
 * Bent lines become a few chords, or tangents where the polygon is circumscribed and they bulge
 * out. So a circumscribed polygon holds all of the region, and the corners of an inscribed one are
 * points of it; its sides are inside too, but for those that are chords of lines that bulge in.
 * capacity is at least PSPLAT_OUTLINE. Returns the number of corners, which is 0 if the lines leave
 * nothing. */
size_t psplat_region_polygon(const psplat_region *region, int inscribed, double (*polygon)[2],
                             size_t capacity);

/* The capacity of the polygons at whose corners fits are checked: 16 corners are enough to notice a
 * fit that leaves the surface between samples. Chosen by hand. */
enum { PSPLAT_OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES };

/* Returns the area in the plane, in units of length squared: with straight lines that of the
 * inscribed polygon of 64 sides, with bent ones within about as much of what they leave. */
double psplat_region_area(const psplat_region *region);

/* The most points that psplat_region_points stores. */
#define PSPLAT_REGION_POINTS 385

/* Stores points that are spread over a region's surface: its middle, the corners of its inscribed
 * polygon, and the points halfway between, as far as lines keep these; of a curved region also
 * points along the sides, and more between. points has room for PSPLAT_REGION_POINTS. Returns the
 * count stored. */
size_t psplat_region_points(const psplat_region *region, double (*points)[3]);

/* Stores such points of a flat region, too, that are as dense as those of a curved one. */
size_t psplat_region_dense_points(const psplat_region *region, double (*points)[3]);

/* Stores those of these points that lie on the outline, and the middle. Returns the count stored.
 */
size_t psplat_region_rim_points(const psplat_region *region, double (*points)[3]);

#endif
