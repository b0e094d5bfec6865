/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ray_meeting.c - where a ray meets the splats of a place (spec 5.1, 5.2), in double precision.
 *
 * The height of the line over a curved splat is F0 + F1 t + F2 t^2 at t along it. An eye far along
 * it looks down on the front at the root where the height rises, and on the wall where the line
 * leaves the cylinder of the rim.
 */
#include "measure/ray_meeting.h"

#include "base/region.h"
#include "base/vector.h"
#include "mesh/distance.h"

#include <math.h>
#include <string.h>

/* Finds t at which the line comes out of the front of a curved splat. Returns 0 where it does not.
 */
static int meet_quadric(const psplat_sight *sight, const psplat_region *region, double *height) {
    const double *h = region->hessian, *d = sight->direction;
    double from[3], slope[2], x = dot3(d, region->u), y = dot3(d, region->v);
    sub3(from, sight->point, region->center);
    const double uv[2] = {dot3(from, region->u) / region->radius[0],
                          dot3(from, region->v) / region->radius[1]};
    psplat_region_slope(region, uv, slope);
    double f0 = dot3(from, region->n) - psplat_region_height(region, uv);
    double f1 = dot3(d, region->n) - slope[0] * x - slope[1] * y;
    double f2 = -(h[0] * x * x + 2 * h[1] * x * y + h[2] * y * y) / 2;
    double square = f1 * f1 - 4 * f0 * f2;
    if (!(square > 0)) return 0;
    double rise = sqrt(square);
    *height = f1 > 0 ? -2 * f0 / (f1 + rise) : (rise - f1) / (2 * f2);
    return isfinite(*height);
}

static int meet_plane(const psplat_sight *sight, const psplat_region *region, double *height) {
    double d[3], cosine = dot3(sight->direction, region->n);
    if (!(cosine > 0)) return 0;
    sub3(d, region->center, sight->point);
    *height = dot3(d, region->n) / cosine;
    return isfinite(*height);
}

int psplat_sight_leaves(const psplat_sight *sight, const psplat_region *region, double *height,
                        double uv[2]) {
    double q[3];
    int met = psplat_region_is_curved(region) ? meet_quadric(sight, region, height)
                                              : meet_plane(sight, region, height);
    if (!met) return 0;
    along3(q, sight->point, *height, sight->direction);
    sub3(q, q, region->center);
    uv[0] = dot3(q, region->u) / region->radius[0];
    uv[1] = dot3(q, region->v) / region->radius[1];
    return 1;
}

/* What rounding may make of lengths and parameters, in parts of them. */
static const double cone_slack = 1e-9;

/* In units of the radii the line leaves the unit circle half a chord beyond its point next to the
 * axis. */
int psplat_sight_meets_wall(const psplat_sight *sight, const psplat_region *region, double wall,
                            double *height, double uv[2]) {
    const double *r = region->radius, *to = sight->direction;
    double from[3], at[3], slope[2];
    if (!(wall > 0) || !psplat_region_is_curved(region)) return 0;
    sub3(from, sight->point, region->center);
    const double o[2] = {dot3(from, region->u) / r[0], dot3(from, region->v) / r[1]};
    const double d[2] = {dot3(to, region->u) / r[0], dot3(to, region->v) / r[1]};
    double length2 = d[0] * d[0] + d[1] * d[1], away = o[0] * d[1] - o[1] * d[0];
    double square = length2 - away * away;
    if (!(square > 0)) return 0;
    *height = (sqrt(square) - o[0] * d[0] - o[1] * d[1]) / length2;
    for (int k = 0; k < 2; ++k) uv[k] = o[k] + *height * d[k];
    along3(at, from, *height, to);
    double over = dot3(at, region->n) - psplat_region_height(region, uv);
    if (!(over < 0 && over > -wall)) return 0;
    psplat_region_slope(region, uv, slope);
    double rise =
        dot3(to, region->n) - slope[0] * dot3(to, region->u) - slope[1] * dot3(to, region->v);
    return rise > 0 && psplat_region_contains(region, uv, 1 + cone_slack, 0);
}

int psplat_sight_meets(const psplat_sight *sight, const psplat_region *region, double wall,
                       double slack, double *height, double uv[2]) {
    return (psplat_sight_leaves(sight, region, height, uv) &&
            psplat_region_contains(region, uv, 1 + slack, slack)) ||
           psplat_sight_meets_wall(sight, region, wall, height, uv);
}

/* Returns a bound of how far along rays of a cone the front of a surface is met, or HUGE_VAL. The
 * height of such a ray over the surface is f0 + f1 t + f2 t^2, with |f2| at most half of the bend:
 * its first root is the nearer, the greater f1 is, which is least at the side of the cone that
 * leans away from the surface's normal. along and across are the parts of that normal along the
 * cone's axis and across. */
static double cone_way(double f0, double bend, double along, double across,
                       const psplat_sight_cone *cone) {
    double f1 = cone->cosine * along - cone->sine * across, square = f1 * f1 - 2 * fabs(f0) * bend;
    if (!(f1 > 0 && square > 0)) return HUGE_VAL;
    return 2 * fabs(f0) / (f1 + sqrt(square));
}

/* Returns whether a region holds all that is no farther from a point of its plane at (u, v) than a
 * length. A line's value changes by its slope there, and by its bend. */
static int holds_disc(const psplat_region *region, const double uv[2], double length) {
    double a = length / region->radius[0], b = length / region->radius[1];
    double r = 1 - max2(a, b) - cone_slack;
    if (!(r >= 0) || uv[0] * uv[0] + uv[1] * uv[1] > r * r) return 0;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        double turn = region->bends[i] * (line[0] * uv[1] - line[1] * uv[0]);
        double s = a * (line[0] - turn * line[1]), t = b * (line[1] + turn * line[0]);
        double most = fabs(a * line[1]) + fabs(b * line[0]);
        double bent = region->bends[i] < 0 ? -region->bends[i] * most * most / 2 : 0;
        if (psplat_region_line_value(region, i, uv) < sqrt(s * s + t * t) + bent + cone_slack)
            return 0;
    }
    return 1;
}

int psplat_sight_cones_meet(const psplat_region *region, double bend, const double point[3],
                            const double normal[3], double tolerance,
                            const psplat_sight_cone *cones, int count) {
    double d[3], slope[2], least = tolerance * (1 - cone_slack);
    sub3(d, point, region->center);
    const double uv[2] = {dot3(d, region->u) / region->radius[0],
                          dot3(d, region->v) / region->radius[1]};
    if (uv[0] * uv[0] + uv[1] * uv[1] > 1) return count;
    psplat_region_slope(region, uv, slope);
    double f0 = dot3(d, region->n) - psplat_region_height(region, uv);
    double length2 = 1 + slope[0] * slope[0] + slope[1] * slope[1];
    double along = dot3(normal, region->n) - slope[0] * dot3(normal, region->u) -
                   slope[1] * dot3(normal, region->v);
    double across = sqrt(max2(length2 - along * along, 0)) + cone_slack;
    for (int k = 0; k < count; ++k) {
        double way = cone_way(f0, bend, along, across, &cones[k]);
        if (way * cones[k].cosine <= least && holds_disc(region, uv, way)) return k;
    }
    return count;
}

/* The part of the way to the eye that begins at the point and does not count. */
static const double skipped_part = 1e-7;

psplat_result psplat_sight_is_free(const psplat_sight *sight, const psplat_distance *distance,
                                   double length, int *is_free) {
    double near[3], far[3];
    int front = 0, back = 0;
    along3(near, sight->point, skipped_part * length, sight->direction);
    along3(far, sight->point, length, sight->direction);
    psplat_result result = psplat_distance_meets(distance, far, near, &front);
    if (!result && !front) result = psplat_distance_meets(distance, near, far, &back);
    *is_free = !front && !back;
    return result;
}

/* On a sphere that the moved sight touches, it is that many tolerances over the cosine from the
 * point to there; on all that is flatter it is less. */
static const double outline_way = 2;

psplat_result psplat_sight_is_inner(const psplat_sight *sight, const double normal[3],
                                    double cosine, const psplat_distance *distance,
                                    double tolerance, int *is_inner) {
    double across[3], moved[3], from[3], to[3], way = (outline_way + 1e-3) * tolerance / cosine;
    psplat_result result = PSPLAT_OK;
    memcpy(across, normal, sizeof across);
    mad3(across, -cosine, sight->direction);
    normalize3(across); /* It stays 0 where the sight is the normal, and the point is inner. */
    *is_inner = 1;
    /* Outwards first, where most that pass an outline miss it. */
    for (int side = 1; side >= -1 && *is_inner && !result; side -= 2) {
        along3(moved, sight->point, side * tolerance, across);
        along3(from, moved, way, sight->direction);
        along3(to, moved, -way, sight->direction);
        result = psplat_distance_meets(distance, from, to, is_inner);
    }
    return result;
}
