/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * close_seams.c - the closing of cracks between splats on both sides of a crease.
 *
 * A clip line stands where the crease is, but the surface of a splat may pass the crease at a small
 * height. So may that of the splat on the other side, and then a crack opens between the two. Pauly
 * et al. (2003) cut two splats where their planes intersect. Likewise each line is moved out until
 * it reaches, all along the crease, the nearest surface from the other side; of curved splats the
 * tangent planes at the crease are taken. Lines are never moved in: a splat that reaches a little
 * behind its neighbour is hidden, but a crack is seen.
 *
 * Where a splat ends at a border of charts or at a tangent edge the surface goes on, so that planes
 * do not cut there: two splats overlap instead, as they do elsewhere. At the tangent edges of
 * bevels of few facets, whose triangles are folded, they are cut where they meet, as at creases.
 */
#include "finish/close_seams.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/neighborhood.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/crease_segments.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/nearness.h"
#include "mesh/mesh.h"
#include "select/selection.h"
#include "splats/quantize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* The number of steps in which the points of a crease segment are tested. */
enum { SEGMENT_STEPS = 4 };
/* The sine of the angle between two planes below which they count as one smooth surface, and not as
 * the two sides of a crease. */
static const double least_crease_sine = 0.1;
/* The farthest move of a line, in tolerances. It keeps splats from growing fins at shallow creases,
 * and from reaching over a crease by a whole tolerance. */
static const double greatest_move_tolerances = 0.5;
/* The same of bent lines, whose moves are longer at other places along them. */
static const double greatest_bent_move_tolerances = 0.2;
/* How far a line may reach beyond any point of its crease once it is moved, in tolerances. The
 * value of a bent line changes at another rate at each of its points. */
static const double greatest_reach_tolerances = 0.8;
/* How far a splat reaches beyond a border where the surface goes on, in tolerances: slanted views
 * see no crack then, and the strip where the texture of the wrong chart is mixed in is narrow. */
static const double smooth_reach_tolerances = 0.4;
/* The same at a tangent edge, where the surface goes on and no texture jumps. */
static const double tangent_reach_tolerances = 2;
/* The cosine of the angle between its triangles, of 11.5 degrees, below which that is as a crease:
 * splats would stand off by 0.4 tolerances, and outlines would get as much wider. */
static const double least_tangent_cosine = 0.98;
/* How far outside its own region (of the unit ellipse) a splat still counts as lying at a crease
 * point. */
static const double region_slack = 0.005;
/* How far beyond a line (of the unit ellipse) creases are still found. They lie on the line, and
 * rounding puts them on either side of it. */
static const double line_slack = 1e-6;

/* One point of a crease where a candidate has a clip line, and the surfaces across from there. */
typedef struct crease_point {
    const psplat_region *regions;
    const uint32_t *patches; /* of each region */
    uint32_t patch;          /* across the crease */
    double tolerance;
    double point[3];   /* on the crease */
    double foot[3];    /* the point of the candidate's surface next to it */
    double outward[3]; /* unit, tangent to the surface there, away from what the line keeps */
    double move;       /* distance to the nearest surface found across; HUGE_VAL: none */
} crease_point;

static int visit_neighbor(void *user, uint32_t index) {
    crease_point *c = user;
    const psplat_region *other = &c->regions[index];
    if (c->patches[index] != c->patch) return 0;
    double uvh[3], d[3], normal[3];
    psplat_region_local(other, c->point, uvh);
    psplat_region_normal(other, uvh, normal);
    double sine = dot3(normal, c->outward);
    if (fabs(uvh[2]) > c->tolerance || fabs(sine) < least_crease_sine) return 0;
    if (!psplat_region_contains(other, uvh, 1 + region_slack, region_slack)) return 0;
    psplat_region_point(other, uvh, d);
    sub3(d, d, c->foot);
    c->move = min2(c->move, max2(dot3(normal, d) / sine, 0));
    return c->move == 0;
}

/* Returns the index of the region's line that passes nearest to (u, v). */
static uint32_t nearest_line(const psplat_region *region, const double uv[2]) {
    uint32_t best = 0;
    double least = HUGE_VAL;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        double distance = fabs(psplat_region_line_value(region, i, uv));
        if (distance < least) least = distance, best = i;
    }
    return best;
}

/* Finds the unit direction, tangent to the surface at (u, v), in which line i cuts off. Returns by
 * how much the line's value decreases for each unit of length in that direction. */
static double line_outward(const psplat_region *region, uint32_t i, const double uv[2],
                           double outward[3]) {
    const double *line = region->lines[i];
    double turn = region->bends[i] * (line[0] * uv[1] - line[1] * uv[0]), slope[2];
    double a = (line[0] - turn * line[1]) / region->radius[0];
    double b = (line[1] + turn * line[0]) / region->radius[1], rate = hypot(a, b);
    psplat_region_slope(region, uv, slope);
    double rise = -(a * slope[0] + b * slope[1]);
    for (int k = 0; k < 3; ++k)
        outward[k] = -a * region->u[k] - b * region->v[k] + rise * region->n[k];
    return rate * rate / normalize3(outward);
}

/* What the threads need for each candidate. */
typedef struct closer {
    psplat_selection *selection;
    psplat_region *regions; /* of the candidates, as they were */
    uint32_t *patches;      /* that these lie on */
    psplat_region_tree *region_tree;
    double (*moves)[PSPLAT_MAX_CLIP_LINES]; /* of the lines of each candidate */
} closer;

/* Returns how far a splat reaches over an edge where the surface goes on, in tolerances; 0 where
 * its line ends at the surface across, as at a crease and at the edge of a facet. */
static double reach_over(const psplat_surface *surface, const psplat_segment *segment) {
    if (segment->is_facet) return 0;
    if (!segment->is_tangent) return segment->is_smooth ? smooth_reach_tolerances : 0;
    const double *left = surface->face_normals + 3 * (size_t)segment->triangle;
    const double *right = surface->face_normals + 3 * (size_t)segment->across;
    return dot3(left, right) >= least_tangent_cosine ? tangent_reach_tolerances : 0;
}

/* Raises the move of the line at a crease point (u, v, height in the region), in units of the
 * line's value, to that at which it meets the nearest surface across the crease there, if there is
 * a triangle across, and at a smooth border to the reach over it. Lowers the line's limit to the
 * move that reaches as far over the crease there as it may. */
static void find_move_at_point(const psplat_fit_context *context, const closer *closer,
                               const psplat_region *region, const double uvh[3],
                               const psplat_segment *segment, double moves[], double limits[]) {
    uint32_t across = segment->across;
    const psplat_surface *surface = context->surface;
    crease_point c = {.regions = closer->regions,
                      .patches = closer->patches,
                      .patch = across == PSPLAT_NONE ? PSPLAT_NONE : surface->patches[across],
                      .move = HUGE_VAL,
                      .tolerance = context->limits->tolerance};
    uint32_t i = nearest_line(region, uvh);
    double rate = line_outward(region, i, uvh, c.outward), normal[3];
    /* The line may already reach beyond this point. */
    double reach = psplat_region_line_value(region, i, uvh);
    double over = across == PSPLAT_NONE ? 0 : reach_over(surface, segment);
    double farthest = max2(over, greatest_reach_tolerances);
    limits[i] = min2(limits[i], farthest * c.tolerance * rate - reach);
    if (across == PSPLAT_NONE) return;
    if (over > 0) moves[i] = max2(moves[i], over * c.tolerance * rate - reach);
    psplat_region_point(region, uvh, c.foot);
    psplat_region_normal(region, uvh, normal);
    memcpy(c.point, c.foot, sizeof c.point);
    mad3(c.point, uvh[2], normal);
    psplat_region_tree_visit(closer->region_tree, c.point, visit_neighbor, &c);
    double most = region->bends[i] != 0 ? greatest_bent_move_tolerances : greatest_move_tolerances;
    /* The splat of a round bevel may be about tangent to that of the flat side. */
    if (segment->is_tangent && over == 0 && !(c.move < HUGE_VAL))
        moves[i] = max2(moves[i], smooth_reach_tolerances * c.tolerance * rate - reach);
    if (c.move < HUGE_VAL)
        moves[i] = max2(moves[i], min2(c.move, most * c.tolerance) * rate - reach);
}

/* Finds the crease segments inside a candidate's region, and stores them in the scratch. Returns 0
 * when out of memory. */
static int find_segments(const psplat_fit_context *context, const psplat_candidate *candidate,
                         size_t *count) {
    const psplat_surface *surface = context->surface;
    psplat_neighborhood *near = &context->scratch->near;
    psplat_region wider = candidate->region;
    const psplat_site site = psplat_site_of(&wider, candidate->triangle);
    double tolerance = context->limits->tolerance, reach = psplat_region_reach(&wider) + tolerance;
    if (!psplat_neighborhood_gather(near, surface, context->samples, &site.metric, site.triangle,
                                    reach, 1) ||
        psplat_scratch_reserve(context->scratch))
        return 0;
    for (uint32_t i = 0; i < wider.line_count; ++i) wider.lines[i][2] += line_slack;
    *count =
        psplat_segments_find_near(surface, near, &wider, tolerance, context->scratch->segments);
    return 1;
}

/* Finds by how much the value of each line of a candidate has to rise. */
static psplat_result find_moves(const psplat_fit_context *context, size_t index, void *user) {
    const closer *c = user;
    const psplat_candidate *candidate = &c->selection->candidates[index];
    size_t count;
    double limits[PSPLAT_MAX_CLIP_LINES], *moves = c->moves[index];
    if (!candidate->region.line_count) return PSPLAT_OK;
    for (int i = 0; i < PSPLAT_MAX_CLIP_LINES; ++i) limits[i] = HUGE_VAL;
    if (!find_segments(context, candidate, &count)) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) {
        const psplat_segment *s = &context->scratch->segments[i];
        for (int step = 0; step <= SEGMENT_STEPS; ++step) {
            double uvh[3];
            for (int k = 0; k < 3; ++k)
                uvh[k] = s->a[k] + (s->b[k] - s->a[k]) * step / SEGMENT_STEPS;
            find_move_at_point(context, c, &candidate->region, uvh, s, moves, limits);
        }
    }
    for (int i = 0; i < PSPLAT_MAX_CLIP_LINES; ++i) moves[i] = max2(min2(moves[i], limits[i]), 0);
    return PSPLAT_OK;
}

/* Moves a candidate's lines, unless its region would then leave the surface, as at acute corners.
 */
static psplat_result move_lines(const psplat_fit_context *context, size_t index, void *user) {
    const closer *c = user;
    const psplat_limits *limits = context->limits;
    psplat_region *region = &c->selection->candidates[index].region, moved = *region;
    double most = 0;
    int near;
    for (uint32_t i = 0; i < region->line_count; ++i) {
        most = max2(most, c->moves[index][i]);
        moved.lines[i][2] += c->moves[index][i];
    }
    if (most == 0) return PSPLAT_OK;
    for (uint32_t i = 0; limits->precision && i < moved.line_count; ++i) {
        const psplat_precision at = psplat_precision_at(limits->precision, moved.radius);
        psplat_quantize_line(&at, moved.lines[i], &moved.bends[i]);
    }
    psplat_result result = psplat_limits_region_near(limits, &moved, &near);
    if (!result && near) *region = moved;
    return result;
}

psplat_result psplat_close_seams(const psplat_fit_context *context, psplat_selection *selection) {
    size_t count = selection->count;
    closer c = {.selection = selection,
                .regions = malloc((count + 1) * sizeof *c.regions),
                .patches = malloc((count + 1) * sizeof *c.patches),
                .moves = calloc(count + 1, sizeof *c.moves)};
    psplat_result result = PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; c.regions && c.patches && i < count; ++i) {
        c.regions[i] = selection->candidates[i].region;
        c.patches[i] = context->surface->patches[selection->candidates[i].triangle];
    }
    if (c.regions && c.patches && c.moves)
        c.region_tree = psplat_region_tree_create(c.regions, count, context->limits->tolerance);
    /* All moves are found before any line moves, so that the order of candidates does not matter.
     */
    if (c.region_tree) result = psplat_fit_each(context, count, find_moves, &c);
    if (!result) result = psplat_fit_each(context, count, move_lines, &c);
    psplat_region_tree_destroy(c.region_tree);
    free(c.regions);
    free(c.patches);
    free(c.moves);
    return result;
}
