/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_extent.c - bounds of what a splat shows.
 *
 * A convex polygon of (u, v) that holds the region (measure/region_cell.h) has corners p_i. The
 * surface is quadratic in (u, v), so that each of its points over the polygon is a convex
 * combination of the values P(p_i, p_j) of its polar form (the blossom: Ramshaw 1989). A box of
 * these holds the surface, and is tight: the values with i = j are points of the surface. Normals
 * that are not normalized are linear in (u, v), so that those at the corners span all others.
 */
#include "tiles/splat_extent.h"

#include "base/vector.h"
#include "measure/region_cell.h"

#include <math.h>
#include <string.h>

static psplat_cell outline_of(const psplat_region *region) {
    psplat_cell cell = psplat_cell_of_disc();
    psplat_cell_clip_by_rim(region, &cell);
    return cell;
}

/* Returns the polar form of the height over the plane at two places, lengths along u and v. */
static double polar_height(const psplat_region *r, const double a[2], const double b[2]) {
    const double *h = r->hessian;
    return (r->slope[0] * (a[0] + b[0]) + r->slope[1] * (a[1] + b[1]) + h[0] * a[0] * b[0] +
            h[1] * (a[0] * b[1] + a[1] * b[0]) + h[2] * a[1] * b[1]) /
           2;
}

static void place(const psplat_region *region, const double uv[2], double at[2]) {
    for (int k = 0; k < 2; ++k) at[k] = uv[k] * region->radius[k];
}

int psplat_splat_extent_box(const psplat_region *region, double low[3], double high[3]) {
    const psplat_cell cell = outline_of(region);
    for (int k = 0; k < 3; ++k) low[k] = HUGE_VAL, high[k] = -HUGE_VAL;
    for (size_t i = 0; i < cell.count; ++i)
        for (size_t j = i; j < cell.count; ++j) {
            double a[2], b[2], p[3];
            place(region, cell.corners[i], a);
            place(region, cell.corners[j], b);
            memcpy(p, region->center, sizeof p);
            mad3(p, 0.5 * (a[0] + b[0]), region->u);
            mad3(p, 0.5 * (a[1] + b[1]), region->v);
            mad3(p, polar_height(region, a, b), region->n);
            for (int k = 0; k < 3; ++k) {
                low[k] = min2(low[k], p[k]);
                high[k] = max2(high[k], p[k]);
            }
        }
    return cell.count > 0;
}

/* Stores the range of the heights over the plane. */
static void height_range(const psplat_region *region, const psplat_cell *cell, double range[2]) {
    range[0] = HUGE_VAL, range[1] = -HUGE_VAL;
    for (size_t i = 0; i < cell->count; ++i)
        for (size_t j = i; j < cell->count; ++j) {
            double a[2], b[2];
            place(region, cell->corners[i], a);
            place(region, cell->corners[j], b);
            double height = polar_height(region, a, b);
            range[0] = min2(range[0], height);
            range[1] = max2(range[1], height);
        }
}

/* Keeps the part of a polygon whose surface may lie on the inner side of a side of a box: sign
 * times coordinate k at least at. */
static void clip_by_side(const psplat_region *region, int k, double sign, double at,
                         const double heights[2], psplat_cell *cell) {
    double n = sign * region->n[k], most = max2(n * heights[0], n * heights[1]);
    const double line[3] = {sign * region->u[k] * region->radius[0],
                            sign * region->v[k] * region->radius[1],
                            sign * region->center[k] + most - at};
    if (cell->count) psplat_cell_clip(cell, line);
}

int psplat_splat_extent_meets(const psplat_region *region, const double low[3],
                              const double high[3]) {
    /* Heights have smaller ranges over what the first round leaves. */
    enum { ROUNDS = 4, SIDES = 6 };
    psplat_cell cell = outline_of(region);
    for (int round = 0; round < ROUNDS && cell.count; ++round) {
        double heights[2];
        if (cell.count + SIDES > PSPLAT_CELL_CORNERS) break;
        height_range(region, &cell, heights);
        for (int k = 0; k < 3; ++k) {
            clip_by_side(region, k, 1, low[k], heights, &cell);
            clip_by_side(region, k, -1, -high[k], heights, &cell);
        }
    }
    return cell.count > 0;
}

/* Calls visit with the unit normal at each corner of the outline of each region. */
static void visit_normals(const psplat_region *regions, const uint32_t *indices, size_t count,
                          void (*visit)(psplat_normal_cone *cone, const double normal[3]),
                          psplat_normal_cone *cone) {
    for (size_t i = 0; i < count; ++i) {
        const psplat_region *region = &regions[indices[i]];
        const psplat_cell cell = outline_of(region);
        for (size_t k = 0; k < cell.count; ++k) {
            double normal[3];
            psplat_region_normal(region, cell.corners[k], normal);
            visit(cone, normal);
        }
    }
}

static void add_axis(psplat_normal_cone *cone, const double normal[3]) {
    mad3(cone->axis, 1, normal);
}

static void widen(psplat_normal_cone *cone, const double normal[3]) {
    cone->cosine = min2(cone->cosine, dot3(cone->axis, normal));
}

psplat_normal_cone psplat_splat_extent_cone(const psplat_region *regions, const uint32_t *indices,
                                            size_t count) {
    psplat_normal_cone cone = {.cosine = 1};
    visit_normals(regions, indices, count, add_axis, &cone);
    if (!(length3(cone.axis) > 0)) return (psplat_normal_cone){.cosine = 0};
    normalize3(cone.axis);
    visit_normals(regions, indices, count, widen, &cone);
    cone.cosine -= 1e-9; /* for rounding */
    return cone;
}
