/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * join.c - clip lines that meet across a crease.
 *
 * A clip line stands where the crease is, but the plane of a splat may pass the crease at a small
 * height, and so may that of the splat on the other side: a crack opens between the two. As Pauly
 * et al. (2003) cut two splats where their planes intersect, each line is moved out until it meets,
 * all along the crease, the nearest plane from across it. Lines are never moved in: a splat that
 * reaches a little behind its neighbour is hidden, a crack is seen.
 */
#include "encoding.h"
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

enum { STEPS = 4 };

/* Planes closer than this (sine) are one smooth surface, not two sides of a crease. */
static const double least_sine = 0.1;
/* Farthest move in tolerances, so that shallow creases grow no fins and no splat crosses a crease
 * by a tolerance. */
static const double greatest_move = 0.5;
/* How far outside its own region a splat still counts as lying at a crease point. */
static const double region_slack = 0.005;
/* By how much creases are looked for beyond a line (of the unit ellipse): the crease lies on the
 * line, and rounding puts it on either side. */
static const double line_slack = 1e-6;

/* One point of a crease, seen from a candidate whose line runs there. */
typedef struct crease_point {
    const psplat_surface *surface;
    const psplat_candidate *candidates;
    uint32_t patch; /* across the crease */
    double tolerance;
    double point[3], foot[3]; /* on the crease; the same in the candidate's plane */
    double outward[3];        /* unit, in that plane */
    double move;              /* nearest intersection found; HUGE_VAL: none */
} crease_point;

static int visit_neighbor(void *user, uint32_t index) {
    crease_point *c = user;
    const psplat_region *other = &c->candidates[index].region;
    if (c->surface->patches[c->candidates[index].triangle] != c->patch) return 0;
    double uvh[3], sine = dot3(other->n, c->outward), d[3];
    psplat_region_local(other, c->point, uvh);
    if (fabs(uvh[2]) > c->tolerance || fabs(sine) < least_sine) return 0;
    if (!psplat_region_contains(other, uvh, 1 + region_slack, region_slack)) return 0;
    sub3(d, other->center, c->foot);
    c->move = min2(c->move, max2(dot3(other->n, d) / sine, 0));
    return c->move == 0;
}

/* The line of the region that passes nearest to (u, v). */
static uint32_t nearest_line(const psplat_region *region, const double uv[2]) {
    uint32_t best = 0;
    double least = HUGE_VAL;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        double distance = fabs(line[0] * uv[0] + line[1] * uv[1] + line[2]);
        if (distance < least) least = distance, best = i;
    }
    return best;
}

/* Outward direction of a line in space, and the line's change per unit of length along it. */
static double line_outward(const psplat_region *region, const double line[3], double outward[3]) {
    double a = line[0] / region->radius[0], b = line[1] / region->radius[1];
    for (int k = 0; k < 3; ++k) outward[k] = -a * region->u[k] - b * region->v[k];
    return normalize3(outward);
}

/* What one candidate's joining works with. */
typedef struct joiner {
    const psplat_surface *surface;
    const psplat_limits *limits;
    const psplat_selection *selection;
    const psplat_locator *locator;
    psplat_neighborhood near;
    psplat_segment *segments;
    size_t segment_capacity;
} joiner;

/* How far the line at a crease point, given in the region's parameters, has to move. */
static void consider_point(const joiner *j, const psplat_region *region, const double uvh[3],
                           uint32_t across, double moves[]) {
    crease_point c = {.surface = j->surface,
                      .candidates = j->selection->candidates,
                      .patch = j->surface->patches[across],
                      .move = HUGE_VAL,
                      .tolerance = j->limits->tolerance};
    uint32_t i = nearest_line(region, uvh);
    const double *line = region->lines[i];
    double rate = line_outward(region, line, c.outward);
    memcpy(c.foot, region->center, sizeof c.foot);
    mad3(c.foot, uvh[0] * region->radius[0], region->u);
    mad3(c.foot, uvh[1] * region->radius[1], region->v);
    memcpy(c.point, c.foot, sizeof c.point);
    mad3(c.point, uvh[2], region->n);
    psplat_locator_visit(j->locator, c.point, visit_neighbor, &c);
    /* The line may already reach beyond this point. */
    double reach = (line[0] * uvh[0] + line[1] * uvh[1] + line[2]) / rate;
    if (c.move < HUGE_VAL)
        moves[i] = max2(moves[i], min2(c.move, greatest_move * c.tolerance) - reach);
}

/* The creases inside a candidate's region, into joiner->segments. 0 when out of memory. */
static int find_segments(joiner *j, const psplat_candidate *candidate, size_t *count) {
    psplat_region wider = candidate->region;
    psplat_metric metric;
    memcpy(metric.center, wider.center, sizeof metric.center);
    memcpy(metric.rows[0], wider.u, sizeof wider.u);
    memcpy(metric.rows[1], wider.v, sizeof wider.v);
    memcpy(metric.rows[2], wider.n, sizeof wider.n);
    double reach = hypot(wider.radius[0], j->limits->tolerance);
    if (!psplat_neighborhood_gather(&j->near, j->surface, NULL, &metric, candidate->triangle,
                                    reach))
        return 0;
    if (j->near.crease_count > j->segment_capacity) {
        free(j->segments);
        j->segment_capacity = 2 * j->near.crease_count;
        j->segments = malloc(j->segment_capacity * sizeof *j->segments);
        if (!j->segments) return 0;
    }
    for (uint32_t i = 0; i < wider.line_count; ++i) wider.lines[i][2] += line_slack;
    *count = psplat_segments_find(j->surface, j->near.creases, j->near.crease_count, &wider,
                                  j->limits->tolerance, j->segments);
    return 1;
}

static int join_candidate(joiner *j, const psplat_candidate *candidate, double moves[]) {
    size_t count;
    if (!find_segments(j, candidate, &count)) return 0;
    for (size_t i = 0; i < count; ++i) {
        const psplat_segment *s = &j->segments[i];
        if (s->across == PSPLAT_NONE) continue;
        for (int step = 0; step <= STEPS; ++step) {
            double uvh[3];
            for (int k = 0; k < 3; ++k) uvh[k] = s->a[k] + (s->b[k] - s->a[k]) * step / STEPS;
            consider_point(j, &candidate->region, uvh, s->across, moves);
        }
    }
    return 1;
}

/* Moves a region's lines, unless its outline then leaves the surface, as at acute corners. */
static psplat_result move_lines(const psplat_limits *limits, psplat_region *region,
                                const double moves[]) {
    psplat_region moved = *region;
    double most = 0, outward[3];
    int near;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        most = max2(most, moves[i]);
        moved.lines[i][2] += moves[i] * line_outward(region, region->lines[i], outward);
    }
    if (most == 0) return PSPLAT_OK;
    for (uint32_t i = 0; limits->precision && i < moved.line_count; ++i)
        psplat_code_line(limits->precision, moved.lines[i]);
    psplat_result result = psplat_region_near(&moved, limits->distance, limits->tolerance, &near);
    if (!result && near) *region = moved;
    return result;
}

/* All moves are found before any line moves, so that their order does not matter. */
static psplat_result join_all(joiner *j, double (*moves)[PSPLAT_MAX_CLIP_LINES],
                              psplat_selection *selection) {
    for (size_t i = 0; i < selection->count; ++i)
        if (selection->candidates[i].region.line_count &&
            !join_candidate(j, &selection->candidates[i], moves[i]))
            return PSPLAT_ERROR_MEMORY;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < selection->count && !result; ++i)
        result = move_lines(j->limits, &selection->candidates[i].region, moves[i]);
    return result;
}

psplat_result psplat_join_lines(const psplat_surface *surface, const psplat_limits *limits,
                                psplat_selection *selection) {
    size_t count = selection->count;
    psplat_region *regions = malloc((count + 1) * sizeof *regions);
    double(*moves)[PSPLAT_MAX_CLIP_LINES] = calloc(count + 1, sizeof *moves);
    psplat_locator *locator = NULL;
    for (size_t i = 0; regions && i < count; ++i) regions[i] = selection->candidates[i].region;
    if (regions) locator = psplat_locator_create(regions, count, limits->tolerance);
    joiner j = {.surface = surface, .limits = limits, .selection = selection, .locator = locator};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (locator && moves) result = join_all(&j, moves, selection);
    psplat_neighborhood_free(&j.near);
    free(j.segments);
    psplat_locator_destroy(locator);
    free(regions);
    free(moves);
    return result;
}
