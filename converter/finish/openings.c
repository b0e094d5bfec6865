/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * openings.c - holes and rays that pass between splats which a step has made smaller.
 */
#include "finish/openings.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "features/surface.h"
#include "finish/rim_rays.h"
#include "fit/candidate.h"
#include "measure/holes.h"
#include "measure/ray_meeting.h"
#include "select/fill_holes.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* How far the points lie apart at which rays pass rims, in tolerances. */
static const double rim_spacing_tolerances = 1;
/* The points of the surface from which rays are cast, too, for each sample: rims alone do not tell
 * where much has been taken from a splat. */
enum { POINTS_PER_SAMPLE = 3 };
/* How often rays are cast, which pass other points each time, and how often, at most, holes are
 * looked for. */
enum { RAY_ROUNDS = 2, HOLE_ROUNDS = 4 };

psplat_result psplat_shrunk_begin(psplat_conversion *c, psplat_shrunk *shrunk) {
    size_t count = c->selection.count;
    *shrunk = (psplat_shrunk){.c = c};
    shrunk->splats = calloc(count + 1, sizeof *shrunk->splats);
    shrunk->before = (psplat_measured_splats){.count = count, .tolerance = c->limits.tolerance};
    shrunk->before.regions = malloc((count + 1) * sizeof *shrunk->before.regions);
    if (!shrunk->splats || !shrunk->before.regions) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i)
        shrunk->before.regions[i] = c->selection.candidates[i].region;
    shrunk->before.region_tree = psplat_region_tree_create_covering(
        shrunk->before.regions, count, PSPLAT_SAME_SURFACE_TOLERANCES * c->limits.tolerance);
    return shrunk->before.region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

void psplat_shrunk_free(psplat_shrunk *shrunk) {
    psplat_measured_splats_free(&shrunk->before);
    free(shrunk->splats);
}

int psplat_shrunk_is_any(const psplat_shrunk *shrunk) {
    int any = 0;
    for (size_t i = 0; i < shrunk->before.count; ++i) any |= shrunk->splats[i].is_smaller;
    return any;
}

static int compare_worth(const void *left, const void *right) {
    const psplat_smaller *const *a = left, *const *b = right;
    if ((*a)->worth != (*b)->worth) return (*a)->worth > (*b)->worth ? -1 : 1;
    return *a < *b ? -1 : *a > *b;
}

uint32_t *psplat_shrunk_order(const psplat_shrunk *shrunk) {
    size_t count = shrunk->before.count;
    const psplat_smaller **sorted = malloc((count + 1) * sizeof *sorted);
    uint32_t *order = malloc((count + 1) * sizeof *order);
    if (!sorted || !order) {
        free(sorted);
        free(order);
        return NULL;
    }
    for (size_t i = 0; i < count; ++i) sorted[i] = &shrunk->splats[i];
    qsort(sorted, count, sizeof *sorted, compare_worth);
    for (size_t i = 0; i < count; ++i) order[i] = (uint32_t)(sorted[i] - shrunk->splats);
    free(sorted);
    return order;
}

/* The search for the splat that closed an opening. */
typedef struct finder {
    const psplat_shrunk *shrunk;
    const psplat_opening *opening;
    uint32_t closing; /* PSPLAT_NONE: none yet */
    int is_closed;    /* by one that is as it was */
} finder;

/* Returns whether a splat closed an opening as it was, or hid it. */
static int closed(const psplat_measured_splats *before, uint32_t splat, const psplat_opening *o) {
    double uvh[3];
    if (o->ray)
        return psplat_ray_hole_is_hidden(o->ray, &before->regions[splat], before->tolerance,
                                         before->wall);
    psplat_region region = before->regions[splat];
    if (o->is_inside_seams) region = psplat_region_inside_seams(&region);
    const psplat_measured_splats one = {
        .regions = &region, .count = 1, .tolerance = before->tolerance};
    psplat_region_local(&region, o->point, uvh);
    return psplat_measured_splats_cover(&one, 0, o->normal, uvh);
}

static int visit_before(void *user, uint32_t splat) {
    finder *f = user;
    const psplat_smaller *splats = f->shrunk->splats;
    if (!closed(&f->shrunk->before, splat, f->opening)) return 0;
    if (!splats[splat].is_smaller)
        f->is_closed = 1;
    else if (f->closing == PSPLAT_NONE || splats[splat].worth < splats[f->closing].worth ||
             (splats[splat].worth == splats[f->closing].worth && splat < f->closing))
        f->closing = splat;
    return f->is_closed;
}

/* Gives a splat that closed an opening within reach of a point back what does. Returns whether one
 * has changed. */
static int close_opening(psplat_shrunk *shrunk, const psplat_opening *opening,
                         const double point[3], double reach) {
    finder f = {shrunk, opening, PSPLAT_NONE, 0};
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) low[k] = point[k] - reach, high[k] = point[k] + reach;
    psplat_region_tree_visit_box(shrunk->before.region_tree, low, high, visit_before, &f);
    if (f.is_closed || f.closing == PSPLAT_NONE) return 0;
    return shrunk->give_back(shrunk->user, f.closing, opening);
}

static int close_ray(psplat_shrunk *shrunk, const psplat_ray_hole *ray) {
    const psplat_opening opening = {.ray = ray};
    return close_opening(shrunk, &opening, ray->sight.point,
                         PSPLAT_HIDING_TOLERANCES * shrunk->before.tolerance /
                             PSPLAT_FLATTEST_SIGHT_COSINE);
}

static int close_hole(psplat_shrunk *shrunk, const psplat_holes *holes, size_t i,
                      int inside_seams) {
    const psplat_surface *surface = &shrunk->c->surface;
    psplat_opening opening = {.is_inside_seams = inside_seams};
    double weights[3];
    float normal[3];
    for (size_t k = 0; k < 3; ++k) opening.point[k] = holes->points[3 * i + k];
    psplat_surface_barycentric(surface, holes->triangles[i], opening.point, weights);
    psplat_surface_normal(surface, holes->triangles[i], weights, normal);
    for (int k = 0; k < 3; ++k) opening.normal[k] = (double)normal[k];
    return close_opening(shrunk, &opening, opening.point, 0);
}

/* Another hole may be found where one was in the same place. */
static psplat_result close_holes(psplat_shrunk *shrunk, int inside_seams) {
    psplat_result result = PSPLAT_OK;
    size_t changed = 1;
    for (int round = 0; round < HOLE_ROUNDS && changed && !result; ++round) {
        psplat_holes holes;
        result = psplat_find_holes(shrunk->c, inside_seams, &holes);
        changed = 0;
        for (size_t i = 0; i < holes.count; ++i)
            changed += (size_t)close_hole(shrunk, &holes, i, inside_seams);
        psplat_holes_free(&holes);
    }
    return result;
}

/* Returns a region that holds what a splat has lost: all that it was or, where it has got a line
 * and is the same but for that, what lies beyond it. */
static psplat_region lost_part(const psplat_region *before, const psplat_region *now) {
    uint32_t last = before->line_count;
    psplat_region cut = *before, lost = *before;
    if (now->line_count != last + 1 || last + before->seam_count == PSPLAT_MAX_CLIP_LINES)
        return lost;
    const double *line = now->lines[last], beyond[3] = {-line[0], -line[1], -line[2]};
    psplat_region_add_line(&cut, line, now->bends[last]);
    if (!memcmp(&cut, now, sizeof cut)) psplat_region_add_line(&lost, beyond, -now->bends[last]);
    return lost;
}

/* Makes what splats have lost, which hid the rays that have been opened. The caller frees it.
 * Returns 0 when out of memory. */
static int make_lost(const psplat_shrunk *shrunk, psplat_measured_splats *lost) {
    const psplat_candidate *candidates = shrunk->c->selection.candidates;
    const psplat_measured_splats *before = &shrunk->before;
    *lost = (psplat_measured_splats){.wall = before->wall};
    lost->regions = malloc((before->count + 1) * sizeof *lost->regions);
    if (!lost->regions) return 0;
    for (size_t i = 0; i < before->count; ++i)
        if (shrunk->splats[i].is_smaller)
            lost->regions[lost->count++] = lost_part(&before->regions[i], &candidates[i].region);
    lost->region_tree = psplat_region_tree_create(lost->regions, lost->count, 0);
    return lost->region_tree != NULL;
}

/* Casts rays where splats have lost something, and gives them back what closes these. */
static psplat_result cast_rays(psplat_shrunk *shrunk, uint64_t seed) {
    psplat_measured_splats lost, measured = {0};
    psplat_ray_holes rays = {0};
    size_t points = POINTS_PER_SAMPLE * shrunk->c->samples.count;
    psplat_result result = make_lost(shrunk, &lost) ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    if (!result)
        result = psplat_rim_rays_find(shrunk->c, rim_spacing_tolerances, points,
                                      PSPLAT_WALL_TOLERANCES, &lost, seed, &measured, &rays);
    for (size_t i = 0; i < rays.count && !result; ++i) close_ray(shrunk, &rays.holes[i]);
    psplat_ray_holes_free(&rays);
    psplat_measured_splats_free(&measured);
    psplat_measured_splats_free(&lost);
    return result;
}

static psplat_result close_rays(psplat_shrunk *shrunk) {
    psplat_result result = PSPLAT_OK;
    for (int round = 0; round < RAY_ROUNDS && !result; ++round)
        result = cast_rays(shrunk, shrunk->c->desc->seed + (uint64_t)round);
    return result;
}

static int has_seams(const psplat_shrunk *shrunk) {
    for (size_t i = 0; i < shrunk->before.count; ++i)
        if (shrunk->before.regions[i].seam_count) return 1;
    return 0;
}

psplat_result psplat_shrunk_close(psplat_shrunk *shrunk) {
    psplat_result result = close_rays(shrunk);
    if (!result) result = close_holes(shrunk, 0);
    return result || !has_seams(shrunk) ? result : close_holes(shrunk, 1);
}
