/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region_distance.c - distance of a point to a splat region, and to the nearest of many.
 *
 * In its plane a flat region with straight lines is a convex part of an ellipse. Its point nearest
 * to a point outside is the nearest point of the ellipse if the clip lines keep that, and lies on
 * one of the lines otherwise.
 */
#include "base/region_distance.h"

#include "base/curved_distance.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"

#include <math.h>

/* The most steps of Newton's iteration, which usually ends after a few. */
enum { MAX_NEWTON_STEPS = 60 };

/* Stores the point q of the ellipse with these radii that is nearest to p, which lies outside. It
 * is q_i = r_i^2 p_i / (t + r_i^2) with the t that makes q a point of the ellipse. The function
 * F(t) = sum (q_i / r_i)^2 - 1 falls and is convex (Eberly, Distance from a Point to an Ellipse,
 * 2013), so that Newton's iteration from any t below the root climbs to it. */
static void project_on_ellipse(const double radius[2], const double p[2], double q[2]) {
    double square[2] = {radius[0] * radius[0], radius[1] * radius[1]};
    double product[2] = {radius[0] * fabs(p[0]), radius[1] * fabs(p[1])};
    /* One term of F alone, or both over the greater of their denominators, are less than F. The
     * roots of these are therefore below that of F. */
    double t = norm2(product[0], product[1]) - max2(square[0], square[1]);
    for (int i = 0; i < 2; ++i) t = max2(t, product[i] - square[i]);
    t = max2(t, 0);
    for (int step = 0; step < MAX_NEWTON_STEPS; ++step) {
        double value = -1, slope = 0;
        for (int i = 0; i < 2; ++i) {
            double term = product[i] / (t + square[i]);
            value += term * term;
            slope -= 2 * term * term / (t + square[i]);
        }
        double next = t - value / slope;
        if (!(next > t)) break;
        t = next;
    }
    for (int i = 0; i < 2; ++i) q[i] = square[i] * p[i] / (t + square[i]);
}

/* Stores the ends a and b, in (u, v), of the part of a clip line that lies in the region. Returns 0
 * if no part does. */
static int clip_chord(const psplat_region *region, uint32_t index, double a[2], double b[2]) {
    const double *line = region->lines[index];
    double length = norm2(line[0], line[1]), away = -line[2] / length;
    double n[2] = {line[0] / length, line[1] / length}, low, high;
    if (!(fabs(away) <= 1)) return 0;
    high = sqrt(1 - away * away), low = -high;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *other = region->lines[i];
        double at = away * (other[0] * n[0] + other[1] * n[1]) + other[2];
        double slope = other[1] * n[0] - other[0] * n[1];
        if (i == index) continue;
        if (slope > 0)
            low = max2(low, -at / slope);
        else if (slope < 0)
            high = min2(high, -at / slope);
        else if (at < 0)
            return 0;
    }
    for (int k = 0; k < 2; ++k) {
        double middle = away * n[k], along = k ? n[0] : -n[1];
        a[k] = middle + low * along, b[k] = middle + high * along;
    }
    return low <= high;
}

/* Returns the distance within the plane, in units of length, of (u, v) outside the region. */
static double in_plane_distance(const psplat_region *region, const double uv[2]) {
    const double *radius = region->radius;
    double p[3] = {uv[0] * radius[0], uv[1] * radius[1], 0}, least = HUGE_VAL;
    if (uv[0] * uv[0] + uv[1] * uv[1] > 1) {
        double q[2];
        project_on_ellipse(radius, p, q);
        const double at[2] = {q[0] / radius[0], q[1] / radius[1]};
        if (psplat_region_contains(region, at, HUGE_VAL, 0)) return norm2(p[0] - q[0], p[1] - q[1]);
    }
    for (uint32_t i = 0; i < region->line_count; ++i) {
        double a[3] = {0}, b[3] = {0};
        if (!clip_chord(region, i, a, b)) continue;
        for (int k = 0; k < 2; ++k) a[k] *= radius[k], b[k] *= radius[k];
        least = min2(least, point_segment_distance2(p, a, b));
    }
    return sqrt(least);
}

/* Returns the distance of a point to a region, or at least limit where it is not less than that. */
static double distance_below(const psplat_region *region, const double point[3], double limit) {
    double uvh[3];
    int plain = !psplat_region_is_curved(region);
    for (uint32_t i = 0; i < region->line_count; ++i) plain = plain && region->bends[i] == 0;
    if (!plain) return psplat_curved_distance(region, point, limit);
    psplat_region_local(region, point, uvh);
    if (psplat_region_contains(region, uvh, 1, 0)) return fabs(uvh[2]);
    return norm2(uvh[2], in_plane_distance(region, uvh));
}

double psplat_region_distance(const psplat_region *region, const double point[3]) {
    return distance_below(region, point, HUGE_VAL);
}

typedef struct nearest_query {
    const psplat_region *regions;
    const double *point;
    double distance;
} nearest_query;

static int visit_nearer(void *user, uint32_t index) {
    nearest_query *n = user;
    const psplat_region *region = &n->regions[index];
    /* A region is no nearer than a sphere around its surface. */
    double beyond = n->distance + psplat_region_reach(region);
    if (distance2_3(region->center, n->point) > beyond * beyond) return 0;
    n->distance = min2(n->distance, distance_below(region, n->point, n->distance));
    return 0;
}

/* Searches boxes around the point that grow until the nearest region found is the nearest of
 * all. */
double psplat_region_nearest_distance(const psplat_region *regions, size_t count,
                                      const psplat_region_tree *region_tree, double expected,
                                      const double point[3]) {
    nearest_query n = {regions, point, HUGE_VAL};
    double low[3], high[3];
    for (double reach = expected; count; reach *= 4) {
        for (int k = 0; k < 3; ++k) low[k] = point[k] - reach, high[k] = point[k] + reach;
        psplat_region_tree_visit_box(region_tree, low, high, visit_nearer, &n);
        if (n.distance <= reach || !(reach < HUGE_VAL)) break;
    }
    return n.distance;
}
