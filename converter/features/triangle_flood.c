/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_flood.c - the triangles that are connected with one, within reach of a point.
 */
#include "features/triangle_flood.h"

#include "base/vector.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void psplat_triangle_flood_free(psplat_triangle_flood *f) {
    free(f->stamps);
    free(f->triangles);
    *f = (psplat_triangle_flood){0};
}

int psplat_triangle_within(const psplat_surface *surface, const psplat_metric *metric,
                           uint32_t triangle, double reach) {
    double corners[3][3];
    const double origin[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) { /* Mostly the first corner is near enough. */
        psplat_metric_coordinates(metric, psplat_mesh_corner(surface->mesh, triangle, k),
                                  corners[k]);
        if (dot3(corners[k], corners[k]) <= reach * reach) return 1;
    }
    for (int k = 0; k < 3; ++k) {
        double low = min2(corners[0][k], min2(corners[1][k], corners[2][k]));
        double high = max2(corners[0][k], max2(corners[1][k], corners[2][k]));
        if (low > reach || high < -reach) return 0;
    }
    return point_triangle_distance2(origin, corners[0], corners[1], corners[2]) <= reach * reach;
}

static void push(psplat_triangle_flood *f, uint32_t triangle) {
    f->stamps[triangle] = f->stamp;
    f->triangles[f->triangle_count++] = triangle;
}

static int begin(psplat_triangle_flood *f, size_t triangles) {
    if (!f->stamps) f->stamps = calloc(triangles + 1, sizeof *f->stamps);
    if (!f->triangles) f->triangles = malloc((triangles + 1) * sizeof *f->triangles);
    if (!f->stamps || !f->triangles) return 0;
    if (++f->stamp == 0) { /* The stamp wrapped around: all old ones are cleared. */
        memset(f->stamps, 0, triangles * sizeof *f->stamps);
        f->stamp = 1;
    }
    f->triangle_count = 0;
    return 1;
}

/* The edges at which floods end: over tangent edges both the surface and its texture go on. */
static const uint8_t ends = PSPLAT_BOUND_CREASE | PSPLAT_BOUND_CHART;

int psplat_triangle_flood_around(psplat_triangle_flood *f, const psplat_surface *surface,
                                 const psplat_region *region, double margin, uint32_t triangle) {
    psplat_metric metric;
    double reach = psplat_region_reach(region) + margin;
    memcpy(metric.center, region->center, sizeof metric.center);
    memcpy(metric.rows[0], region->u, sizeof metric.rows[0]);
    memcpy(metric.rows[1], region->v, sizeof metric.rows[1]);
    memcpy(metric.rows[2], region->n, sizeof metric.rows[2]);
    if (!begin(f, surface->mesh->triangle_count)) return 0;
    push(f, triangle);
    for (size_t at = 0; at < f->triangle_count; ++at) {
        uint32_t t = f->triangles[at];
        if (!psplat_triangle_within(surface, &metric, t, reach)) continue;
        for (size_t e = 3 * (size_t)t; e < 3 * (size_t)t + 3; ++e) {
            uint32_t next = surface->neighbors[e];
            if (!(surface->creases[e] & ends) && f->stamps[next] != f->stamp) push(f, next);
        }
    }
    return 1;
}

/* Returns a bound of the magnitude of the height of a region's surface over its plane. */
static double height_bound(const psplat_region *r) {
    const double *hessian = r->hessian, s = r->radius[0], t = r->radius[1];
    return fabs(r->slope[0]) * s + fabs(r->slope[1]) * t +
           (fabs(hessian[0]) * s * s + 2 * fabs(hessian[1]) * s * t + fabs(hessian[2]) * t * t) / 2;
}

/* Returns whether a line cuts all of a triangle in (u, v) away. What a line that bulges in keeps is
 * no more than its straight line keeps, and what one that bulges out cuts away is convex. */
static int cuts_triangle(const psplat_region *region, uint32_t i, const double corners[3][3]) {
    const double *line = region->lines[i];
    for (int k = 0; k < 3; ++k) {
        const double *c = corners[k];
        double along = line[0] * c[1] - line[1] * c[0];
        double bulge = max2(region->bends[i], 0) * along * along / 2;
        if (line[0] * c[0] + line[1] * c[1] + line[2] + bulge >= 0) return 0;
    }
    return 1;
}

/* Returns whether a triangle comes as near to a region as a margin, put onto its plane. */
static int is_beneath(const psplat_surface *surface, const psplat_region *region, double margin,
                      uint32_t triangle) {
    double corners[3][3], low = HUGE_VAL, high = -HUGE_VAL, bound = height_bound(region) + margin;
    const double origin[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        double d[3];
        sub3(d, psplat_mesh_corner(surface->mesh, triangle, k), region->center);
        corners[k][0] = dot3(d, region->u) / region->radius[0];
        corners[k][1] = dot3(d, region->v) / region->radius[1];
        corners[k][2] = 0;
        low = min2(low, dot3(d, region->n)), high = max2(high, dot3(d, region->n));
    }
    if (low > bound || high < -bound) return 0;
    for (uint32_t i = 0; i < region->line_count; ++i)
        if (cuts_triangle(region, i, (const double(*)[3])corners)) return 0;
    for (int k = 0; k < 3; ++k) /* Lines are theirs; only the ellipse gets the margin. */
        for (int axis = 0; axis < 2; ++axis)
            corners[k][axis] *= region->radius[axis] / (region->radius[axis] + margin);
    return point_triangle_distance2(origin, corners[0], corners[1], corners[2]) <= 1;
}

/* Lets a flood spread beneath a region, from its triangle `at` on, but not over edges that bound
 * what is in `bounds`. */
static void spread_beneath(psplat_triangle_flood *f, const psplat_surface *surface,
                           const psplat_region *region, double margin, uint8_t bounds, size_t at) {
    for (; at < f->triangle_count; ++at) {
        size_t first = 3 * (size_t)f->triangles[at];
        for (size_t e = first; e < first + 3; ++e) {
            uint32_t next = surface->neighbors[e];
            if (next == PSPLAT_NONE || (surface->creases[e] & bounds) ||
                f->stamps[next] == f->stamp)
                continue;
            if (is_beneath(surface, region, margin, next)) push(f, next);
        }
    }
}

int psplat_triangle_flood_beneath(psplat_triangle_flood *f, const psplat_surface *surface,
                                  const psplat_region *region, double margin, uint32_t triangle) {
    if (!begin(f, surface->mesh->triangle_count)) return 0;
    push(f, triangle);
    spread_beneath(f, surface, region, margin, ends, 0);
    return 1;
}

int psplat_triangle_flood_begin(psplat_triangle_flood *f, const psplat_surface *surface) {
    return begin(f, surface->mesh->triangle_count);
}

void psplat_triangle_flood_add_beneath(psplat_triangle_flood *f, const psplat_surface *surface,
                                       const psplat_region *region, double margin,
                                       uint32_t triangle) {
    size_t at = f->triangle_count;
    if (psplat_triangle_flood_met(f, triangle)) return;
    push(f, triangle);
    spread_beneath(f, surface, region, margin, 0, at);
}

int psplat_triangle_flood_met(const psplat_triangle_flood *f, uint32_t triangle) {
    return f->stamps[triangle] == f->stamp;
}

void psplat_triangle_flood_forget(psplat_triangle_flood *f, uint32_t triangle) {
    f->stamps[triangle] = 0;
}
