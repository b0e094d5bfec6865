/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * triangle_flood.c - the triangles that are connected with one, within reach of a point.
 */
#include "features/triangle_flood.h"

#include "base/vector.h"
#include "mesh/mesh.h"

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
            if (!surface->creases[e] && f->stamps[next] != f->stamp) push(f, next);
        }
    }
    return 1;
}

int psplat_triangle_flood_met(const psplat_triangle_flood *f, uint32_t triangle) {
    return f->stamps[triangle] == f->stamp;
}
