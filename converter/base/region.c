/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * region.c - the shape of a splat, an ellipse cut by clip lines: point tests, its polygon and area.
 */
#include "base/region.h"

#include "base/angle.h"
#include "base/vector.h"

#include <math.h>
#include <string.h>

/* The sides of the finest polygon, and the room for its corners: each clip line adds one, and
 * rounding may add some. */
enum { OUTLINE_SIDES = 64, MAX_CORNERS = OUTLINE_SIDES + PSPLAT_MAX_CLIP_LINES + 4 };

void psplat_region_local(const psplat_region *region, const double point[3], double uvh[3]) {
    double d[3];
    sub3(d, point, region->center);
    uvh[0] = dot3(d, region->u) / region->radius[0];
    uvh[1] = dot3(d, region->v) / region->radius[1];
    uvh[2] = dot3(d, region->n);
}

int psplat_region_contains(const psplat_region *region, const double uv[2], double scale,
                           double slack) {
    if (uv[0] * uv[0] + uv[1] * uv[1] > scale * scale) return 0;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        if (line[0] * uv[0] + line[1] * uv[1] + line[2] < -slack) return 0;
    }
    return 1;
}

/* ---- polygons ------------------------------------------------------------------------------ */

typedef double corner[2]; /* u, v */

static double line_distance(const double line[3], const double p[2]) {
    return line[0] * p[0] + line[1] * p[1] + line[2];
}

/* Keeps the part of a polygon with line >= 0 (Sutherland, Hodgman 1974). Returns the number of its
 * corners. */
static size_t clip_polygon(const double line[3], corner *in, size_t count, corner *out) {
    size_t result = 0;
    /* Rounding may give a sliver more corners than a convex polygon can have; they are left out. */
    for (size_t i = 0; i < count && result + 2 <= MAX_CORNERS; ++i) {
        const double *a = in[i], *b = in[i + 1 < count ? i + 1 : 0];
        double da = line_distance(line, a), db = line_distance(line, b);
        if (da >= 0) memcpy(out[result++], a, sizeof(corner));
        if ((da >= 0) == (db >= 0)) continue;
        double t = da / (da - db);
        for (int k = 0; k < 2; ++k) out[result][k] = a[k] + t * (b[k] - a[k]);
        ++result;
    }
    return result;
}

size_t psplat_region_polygon(const psplat_region *region, int inscribed, double (*polygon)[2],
                             size_t capacity) {
    corner corners[MAX_CORNERS], clipped[MAX_CORNERS];
    size_t count = capacity - PSPLAT_MAX_CLIP_LINES;
    if (count > OUTLINE_SIDES) count = OUTLINE_SIDES;
    double half = PSPLAT_PI / (double)count, step[2] = {cos(2 * half), sin(2 * half)};
    double p[2] = {1, inscribed ? 0 : tan(half)};
    for (size_t i = 0; i < count; ++i) {
        double x = p[0];
        corners[i][0] = p[0], corners[i][1] = p[1];
        p[0] = step[0] * x - step[1] * p[1];
        p[1] = step[1] * x + step[0] * p[1];
    }
    for (uint32_t i = 0; i < region->line_count && count; ++i) {
        count = clip_polygon(region->lines[i], corners, count, clipped);
        memcpy(corners, clipped, count * sizeof(corner));
    }
    memcpy(polygon, corners, count * sizeof(corner));
    return count;
}

double psplat_region_area(const psplat_region *region) {
    double polygon[MAX_CORNERS][2], twice = 0;
    size_t count = psplat_region_polygon(region, 1, polygon, OUTLINE_SIDES + PSPLAT_MAX_CLIP_LINES);
    for (size_t i = 0; i < count; ++i) {
        const double *a = polygon[i], *b = polygon[i + 1 < count ? i + 1 : 0];
        twice += a[0] * b[1] - a[1] * b[0];
    }
    return twice / 2 * region->radius[0] * region->radius[1];
}

size_t psplat_region_points(const psplat_region *region, double (*points)[3]) {
    double polygon[MAX_CORNERS][2], middle[2] = {0, 0};
    size_t count = psplat_region_polygon(region, 1, polygon, OUTLINE_SIDES + PSPLAT_MAX_CLIP_LINES);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) middle[k] += polygon[i][k] / (double)count;
    if (!count) return 0;
    for (size_t i = 0; i < 2 * count + 1; ++i) {
        double t = i < count ? 1 : i < 2 * count ? 0.5 : 0;
        const double *corner = polygon[i % count];
        memcpy(points[i], region->center, sizeof points[i]);
        mad3(points[i], (middle[0] + t * (corner[0] - middle[0])) * region->radius[0], region->u);
        mad3(points[i], (middle[1] + t * (corner[1] - middle[1])) * region->radius[1], region->v);
    }
    return 2 * count + 1;
}
