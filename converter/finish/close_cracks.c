/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * close_cracks.c - the closing of cracks that clip lines leave between splats.
 *
 * Creases are chains of short edges, and clip lines follow them by straight lines and parabolas
 * that may stand a part of the tolerance behind them. Where those on both sides of a crease stand
 * back, or where the surfaces on both sides pass it at different heights, one sees through. To move
 * all lines out to all of their crease would make convex creases ragged. So rays past the lines
 * find where there is a crack, and the line that lacks least is moved out to the ray.
 */
#include "finish/close_cracks.h"

#include "base/region_tree.h"
#include "base/vector.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/nearness.h"
#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "mesh/mesh.h"
#include "finish/rim_rays.h"
#include "select/selection.h"
#include "splats/quantize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* How often rays are cast. */
enum { ROUNDS = 2 };
/* How far the points lie apart at which rays pass the lines, in tolerances. */
static const double rim_spacing_tolerances = 1;
/* How much farther than to the ray a line is moved, in tolerances, for rays beside it. */
static const double spare_tolerances = 0.02;
/* How far beside a triangle a point that a ray sees on its plane still is one of it, in tolerances.
 */
static const double beside_tolerances = 0.01;

/* A ray through a crack, and the candidate whose lines lack least. */
typedef struct crack {
    psplat_ray_hole hole;
    uint32_t candidate; /* PSPLAT_NONE: lines alone close it nowhere */
    double width;
} crack;

typedef struct closer {
    psplat_conversion *c;
    psplat_region *regions; /* as they were before any crack was closed */
    crack *cracks;
    size_t count;
    uint32_t *first; /* candidates + 1: the first crack of each */
} closer;

/* Returns how fast the value of a line changes along the plane, for each unit of length. */
static double line_rate(const psplat_region *region, uint32_t i, const double uv[2]) {
    const double *line = region->lines[i];
    double turn = region->bends[i] * (line[0] * uv[1] - line[1] * uv[0]);
    return hypot((line[0] - turn * line[1]) / region->radius[0],
                 (line[1] + turn * line[0]) / region->radius[1]);
}

double psplat_crack_width(const psplat_sight *sight, double cosine, const psplat_region *region,
                          double tolerance) {
    double height, uv[2], width = 0;
    if (!region->line_count || !psplat_sight_leaves(sight, region, &height, uv) ||
        fabs(height) * cosine > tolerance || uv[0] * uv[0] + uv[1] * uv[1] > 1)
        return HUGE_VAL;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        double value = psplat_region_line_value(region, i, uv);
        if (value < 0) width = max2(width, -value / line_rate(region, i, uv));
    }
    return width > 0 ? width : HUGE_VAL;
}

/* Returns how wide, a length, a crack may be that a candidate closes. */
static double greatest_width(const closer *r, const psplat_ray_hole *hole, size_t candidate) {
    const psplat_surface *surface = &r->c->surface;
    double tolerance = r->c->tolerance, beside = beside_tolerances * tolerance;
    const double *corners[3];
    for (int k = 0; k < 3; ++k) corners[k] = psplat_mesh_corner(surface->mesh, hole->triangle, k);
    int is_own = surface->patches[hole->triangle] ==
                     surface->patches[r->c->selection.candidates[candidate].triangle] &&
                 point_triangle_distance2(hole->sight.point, corners[0], corners[1], corners[2]) <=
                     beside * beside;
    return (is_own ? PSPLAT_GREATEST_OWN_CRACK : PSPLAT_GREATEST_CRACK) * tolerance;
}

/* ---- cracks ---------------------------------------------------------------------------------- */

typedef struct chooser {
    const closer *closer;
    const psplat_region *regions;
    crack *crack;
    double tolerance;
} chooser;

static int visit_region(void *user, uint32_t index) {
    chooser *s = user;
    double width = psplat_crack_width(&s->crack->hole.sight, s->crack->hole.cosine,
                                      &s->regions[index], s->tolerance);
    if (width == HUGE_VAL || width > greatest_width(s->closer, &s->crack->hole, index)) return 0;
    if (width < s->crack->width || (width == s->crack->width && index < s->crack->candidate)) {
        s->crack->width = width;
        s->crack->candidate = index;
    }
    return 0;
}

static int compare_cracks(const void *a, const void *b) {
    const crack *x = a, *y = b;
    if (x->candidate != y->candidate) return x->candidate < y->candidate ? -1 : 1;
    return (x->width > y->width) - (x->width < y->width);
}

/* Chooses the candidate of each crack, and sorts the cracks by it: those that lack least first. */
static void choose(closer *r, const psplat_measured_splats *measured) {
    double reach = measured->tolerance / PSPLAT_FLATTEST_SIGHT_COSINE;
    size_t kept = 0;
    for (size_t i = 0; i < r->count; ++i) {
        crack *at = &r->cracks[i];
        double low[3], high[3];
        chooser s = {r, measured->regions, at, measured->tolerance};
        at->candidate = PSPLAT_NONE;
        at->width = HUGE_VAL;
        for (int k = 0; k < 3; ++k) {
            low[k] = at->hole.sight.point[k] - reach;
            high[k] = at->hole.sight.point[k] + reach;
        }
        psplat_region_tree_visit_box(measured->region_tree, low, high, visit_region, &s);
        if (at->candidate != PSPLAT_NONE) r->cracks[kept++] = *at;
    }
    r->count = kept;
    qsort(r->cracks, kept, sizeof *r->cracks, compare_cracks);
    memset(r->first, 0, (measured->count + 1) * sizeof *r->first);
    for (size_t i = 0; i < kept; ++i) ++r->first[r->cracks[i].candidate + 1];
    for (size_t i = 0; i < measured->count; ++i) r->first[i + 1] += r->first[i];
}

/* Makes the regions that lines cut, but whole: what they hide, lines that are moved out may close.
 * The caller frees them. Returns 0 when out of memory. */
static int make_whole(const closer *r, psplat_measured_splats *whole) {
    *whole = (psplat_measured_splats){0};
    whole->regions = malloc((r->c->selection.count + 1) * sizeof *whole->regions);
    if (!whole->regions) return 0;
    for (size_t i = 0; i < r->c->selection.count; ++i) {
        if (!r->regions[i].line_count) continue;
        whole->regions[whole->count] = r->regions[i];
        whole->regions[whole->count++].line_count = 0;
    }
    whole->region_tree = psplat_region_tree_create(whole->regions, whole->count, 0);
    return whole->region_tree != NULL;
}

/* Finds the cracks between the candidates. */
static psplat_result find_cracks(closer *r, const psplat_measured_splats *whole, uint64_t seed) {
    psplat_measured_splats measured;
    psplat_ray_holes rays;
    psplat_result result =
        psplat_rim_rays_find(r->c, rim_spacing_tolerances, 0, 0, whole, seed, &measured, &rays);
    r->count = rays.count;
    r->cracks = malloc((rays.count + 1) * sizeof *r->cracks);
    if (!r->cracks) result = PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; r->cracks && i < r->count; ++i) r->cracks[i].hole = rays.holes[i];
    if (!result) choose(r, &measured);
    psplat_ray_holes_free(&rays);
    psplat_measured_splats_free(&measured);
    return result;
}

/* ---- lines ----------------------------------------------------------------------------------- */

/* Moves the lines of a candidate's region out to a ray, with some to spare, but none farther in all
 * from that of the old region than its cracks may be wide. */
static void move_to(const closer *r, size_t candidate, const psplat_ray_hole *hole,
                    psplat_region *region) {
    const psplat_region *old = &r->regions[candidate];
    double height, uv[2], spare = spare_tolerances * r->c->limits.tolerance;
    if (!psplat_sight_leaves(&hole->sight, region, &height, uv)) return;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        double value = psplat_region_line_value(region, i, uv), rate = line_rate(region, i, uv);
        double most = old->lines[i][2] + greatest_width(r, hole, candidate) * rate;
        double moved = region->lines[i][2] - value + spare * rate;
        if (value < 0) region->lines[i][2] = max2(region->lines[i][2], min2(moved, most));
    }
}

/* Moves the lines of a candidate out to so many of its rays, if it then stays near the surface. */
static psplat_result move_to_some(const psplat_fit_context *context, const closer *r, size_t index,
                                  uint32_t count, int *near) {
    const psplat_limits *limits = context->limits;
    psplat_region *region = &r->c->selection.candidates[index].region, moved = *region;
    for (uint32_t i = 0; i < count; ++i)
        move_to(r, index, &r->cracks[r->first[index] + i].hole, &moved);
    for (uint32_t i = 0; limits->precision && i < moved.line_count; ++i) {
        const psplat_precision at = psplat_precision_at(limits->precision, moved.radius);
        psplat_quantize_line(&at, moved.lines[i], &moved.bends[i]);
    }
    psplat_result result = psplat_limits_region_near(limits, &moved, near);
    if (!result && *near) *region = moved;
    return result;
}

/* Moves the lines of a candidate out to as many of its rays as it can follow: all, or else those
 * half that lack least, and so on. */
static psplat_result move_lines(const psplat_fit_context *context, size_t index, void *user) {
    const closer *r = user;
    psplat_result result = PSPLAT_OK;
    int near = 0;
    for (uint32_t count = r->first[index + 1] - r->first[index]; count && !near && !result;
         count /= 2)
        result = move_to_some(context, r, index, count, &near);
    return result;
}

/* ---- rounds ---------------------------------------------------------------------------------- */

psplat_result psplat_close_cracks(psplat_conversion *c) {
    const psplat_fit_context context = psplat_conversion_context(c);
    size_t count = c->selection.count;
    closer r = {.c = c, .count = 1};
    r.regions = malloc((count + 1) * sizeof *r.regions);
    r.first = malloc((count + 1) * sizeof *r.first);
    psplat_result result = r.regions && r.first ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; !result && i < count; ++i) r.regions[i] = c->selection.candidates[i].region;
    psplat_measured_splats whole = {0};
    if (!result && !make_whole(&r, &whole)) result = PSPLAT_ERROR_MEMORY;
    for (int round = 0; round < ROUNDS && r.count && !result; ++round) {
        result = find_cracks(&r, &whole, c->desc->seed + (uint64_t)round);
        if (!result) result = psplat_fit_each(&context, count, move_lines, &r);
        free(r.cracks);
    }
    psplat_measured_splats_free(&whole);
    free(r.regions);
    free(r.first);
    return result;
}
