/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_segments.c - crease edges clipped to the ellipse and the lines of a region.
 */
#include "fit/crease_segments.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

/* Keeps the part of a segment between two places along it, which are 0 and 1 at its ends. */
static void keep_between(psplat_segment *s, double from, double to) {
    double d[3], start[3];
    sub3(d, s->b, s->a);
    memcpy(start, s->a, sizeof start);
    along3(s->a, start, from, d);
    along3(s->b, start, to, d);
}

/* Takes the height of the surface off that over the plane at an end of a segment. */
static void take_height(const psplat_region *region, double end[3]) {
    double slope[2];
    psplat_region_slope(region, end, slope);
    end[2] = (end[2] - psplat_region_height(region, end)) /
             sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

/* Stores the parameters of a point and its height over the plane, which along a straight edge
 * changes linearly. */
static void plane_local(const psplat_region *region, const double point[3], double uvh[3]) {
    double d[3];
    sub3(d, point, region->center);
    uvh[0] = dot3(d, region->u) / region->radius[0];
    uvh[1] = dot3(d, region->v) / region->radius[1];
    uvh[2] = dot3(d, region->n);
}

/* Narrows a range of places along a segment, from a on by d, to the longest part that a bent line
 * keeps. */
static void keep_inside_bent(const psplat_region *region, uint32_t i, const double a[3],
                             const double d[3], double *from, double *to) {
    const double *line = region->lines[i];
    double along = line[0] * a[1] - line[1] * a[0], rate = line[0] * d[1] - line[1] * d[0];
    double bend = region->bends[i];
    /* The value at t is c + b t + e t^2. */
    double c = line[0] * a[0] + line[1] * a[1] + line[2] + bend * along * along / 2;
    double b = line[0] * d[0] + line[1] * d[1] + bend * along * rate, e = bend * rate * rate / 2;
    double cuts[4] = {*from, *from, *to, *to}, root = b * b - 4 * e * c, longest = 0;
    if (root > 0) {
        double q = -(b + copysign(sqrt(root), b)) / 2;
        double first = c / q, second = e != 0 ? q / e : HUGE_VAL;
        cuts[1] = min2(max2(min2(first, second), *from), *to);
        cuts[2] = min2(max2(max2(first, second), *from), *to);
    }
    *to = *from;
    for (int k = 0; k < 3; ++k) {
        double middle = (cuts[k] + cuts[k + 1]) / 2, length = cuts[k + 1] - cuts[k];
        if (!(length > longest) || c + (b + e * middle) * middle < 0) continue;
        longest = length;
        *from = cuts[k], *to = cuts[k + 1];
    }
}

/* Returns whether a segment lies on one side of the square around the unit circle, as most do. */
static int is_beside_disc(const psplat_segment *s) {
    for (int k = 0; k < 2; ++k)
        if (min2(s->a[k], s->b[k]) > 1 || max2(s->a[k], s->b[k]) < -1) return 1;
    return 0;
}

/* Clips a segment to the unit circle and the lines. Returns 0 where nothing is left. */
static int clip_segment(psplat_segment *s, const psplat_region *region) {
    double d[3];
    sub3(d, s->b, s->a);
    double aa = d[0] * d[0] + d[1] * d[1], ab = s->a[0] * d[0] + s->a[1] * d[1];
    double root = ab * ab - aa * (s->a[0] * s->a[0] + s->a[1] * s->a[1] - 1);
    if (!(aa > 0) || !(root > 0)) return 0;
    double from = max2((-ab - sqrt(root)) / aa, 0), to = min2((-ab + sqrt(root)) / aa, 1);
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        if (region->bends[i] != 0) {
            keep_inside_bent(region, i, s->a, d, &from, &to);
            continue;
        }
        double inside = line[0] * s->a[0] + line[1] * s->a[1] + line[2];
        double rate = line[0] * d[0] + line[1] * d[1];
        if (rate > 0) from = max2(from, -inside / rate);
        if (rate < 0) to = min2(to, -inside / rate);
        if (rate == 0 && inside < 0) return 0;
    }
    if (!(from < to)) return 0;
    keep_between(s, from, to);
    return 1;
}

size_t psplat_segments_find(const psplat_surface *surface, const uint32_t *creases,
                            size_t crease_count, const psplat_region *region, double height,
                            psplat_segment *segments) {
    const psplat_mesh *mesh = surface->mesh;
    size_t count = 0;
    for (size_t i = 0; i < crease_count; ++i) {
        uint32_t edge = creases[i], next = edge % 3 == 2 ? edge - 2 : edge + 1;
        if (dot3(surface->face_normals + 3 * (size_t)(edge / 3), region->n) <= 0) continue;
        psplat_segment *s = &segments[count];
        s->vertex[0] = mesh->triangles[edge], s->vertex[1] = mesh->triangles[next];
        s->triangle = edge / 3, s->across = surface->neighbors[edge];
        s->is_smooth = !(surface->creases[edge] & PSPLAT_BOUND_CREASE);
        s->is_chart = surface->creases[edge] == PSPLAT_BOUND_CHART;
        s->is_tangent = surface->creases[edge] == PSPLAT_BOUND_TANGENT;
        s->is_facet = surface->creases[edge] == PSPLAT_BOUND_FACET;
        plane_local(region, mesh->positions + 3 * (size_t)s->vertex[0], s->a);
        plane_local(region, mesh->positions + 3 * (size_t)s->vertex[1], s->b);
        if (is_beside_disc(s) || !clip_segment(s, region)) continue;
        take_height(region, s->a);
        take_height(region, s->b);
        count += min2(fabs(s->a[2]), fabs(s->b[2])) <= height;
    }
    return count;
}

/* ---- neighbourhoods -------------------------------------------------------------------------- */

/* What rounding may make of lengths, in parts of them: differences of squares lose half of their
 * digits. */
static const double rounding = 1e-7;

/* Finds a box around the surface over the ellipse, and what is no farther from it than height along
 * its normals there. */
static void find_box(const psplat_region *region, double height, psplat_crease_box *box) {
    const double *r = region->radius;
    double widest = max2(r[0], r[1]), reach = psplat_region_reach(region);
    double steepest =
        norm2(region->slope[0], region->slope[1]) + psplat_region_bend(region) * widest;
    double over = sqrt(max2(reach * reach - widest * widest, 0)) + height * norm2(1, steepest);
    for (int k = 0; k < 3; ++k) {
        double far = norm2(r[0] * region->u[k], r[1] * region->v[k]) + over * fabs(region->n[k]);
        far += rounding * (widest + over + fabs(region->center[k]));
        box->low[k] = region->center[k] - far, box->high[k] = region->center[k] + far;
    }
}

static int boxes_meet(const psplat_crease_box *a, const psplat_crease_box *b) {
    for (int k = 0; k < 3; ++k)
        if (a->low[k] > b->high[k] || a->high[k] < b->low[k]) return 0;
    return 1;
}

size_t psplat_segments_find_near(const psplat_surface *surface, const psplat_neighborhood *near,
                                 const psplat_region *region, double height,
                                 psplat_segment *segments) {
    psplat_crease_box box;
    size_t count = 0;
    find_box(region, height, &box);
    for (size_t begin = 0; begin < near->crease_count; begin += PSPLAT_CREASE_BLOCK) {
        size_t left = near->crease_count - begin;
        if (boxes_meet(&near->crease_boxes[begin / PSPLAT_CREASE_BLOCK], &box))
            count += psplat_segments_find(surface, near->creases + begin,
                                          left < PSPLAT_CREASE_BLOCK ? left : PSPLAT_CREASE_BLOCK,
                                          region, height, segments + count);
    }
    return count;
}
