/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * trim_splats.c - the shrinking of splats whose rims stand off more than they have to.
 *
 * A splat grows until some point of it is the tolerance away from the surface, and that is a point
 * of its rim. Seen from the side, such rims make the outline too wide and ragged. But most splats
 * reach over samples that others cover, too, in the end. So the one that stands off most shrinks to
 * the samples for which it is needed, and then the next one. Where that opens a hole or lets a ray
 * through, a splat that closes it gets its old size back.
 */
#include "finish/trim_splats.h"

#include "base/angle.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/quantize_candidate.h"
#include "measure/holes.h"
#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "select/fill_holes.h"
#include "finish/rim_rays.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* All of these were chosen by hand. */
/* How far a rim has to stand off for its splat to shrink, in tolerances. */
static const double least_stand_off = 0.5;
/* The least part of its radii that a splat shrinks to. With 0.8, normals of the Duck err by 3 %
 * more, and outlines are hardly narrower. */
static const double least_scale = 0.9;
/* How far beyond the samples that it is needed for a splat reaches, in their spacings. */
static const double margin_spacings = 0.5;
/* How far the points lie apart at which rays pass rims, in tolerances. */
static const double rim_spacing_tolerances = 1;
/* How far down walls under rims reach, which stop rays (spec 5.1), in tolerances: a quarter of the
 * depth tolerance, and that mostly is two (depth_tolerance.h). */
static const double wall_tolerances = 0.5;
/* What rounding may put a point of the rim beyond it, in units of u and v. */
static const double rim_slack = 1e-9;
/* The points of a rim at which it is measured how far it stands off. */
enum { SIDES = 16 };
/* How often splats get their size back for rays and, at most, for holes. */
enum { RAY_ROUNDS = 2, HOLE_ROUNDS = 4 };

/* A candidate as it was, and what is known of it. */
typedef struct trimmed {
    psplat_candidate whole; /* empty unless is_trimmed */
    double stand_off;       /* the greatest of its rim, a length, outwards */
    double scale;           /* of its radii, 1 at most */
    int is_trimmed;
} trimmed;

typedef struct trimmer {
    psplat_conversion *c;
    trimmed *splats; /* count: of the candidates */
    size_t count;
    uint32_t *covers; /* of each sample: how many candidates are recorded to cover it */
    psplat_measured_splats before; /* the regions of all candidates as they were; no fields */
} trimmer;

static void trimmer_free(trimmer *t) {
    for (size_t i = 0; t->splats && i < t->count; ++i) psplat_candidate_free(&t->splats[i].whole);
    psplat_measured_splats_free(&t->before);
    free(t->splats);
    free(t->covers);
}

/* ---- what splats are needed for -------------------------------------------------------------- */

/* Returns how far the rim of a region stands off outwards where it is the region's end, a length.
 */
static psplat_result find_stand_off(const psplat_fit_context *context, const psplat_region *region,
                                    double *stand_off) {
    *stand_off = 0;
    for (int i = 0; i < SIDES; ++i) {
        double angle = 2 * PSPLAT_PI * i / SIDES, point[3], nearest[3], away[3];
        const double uv[2] = {cos(angle), sin(angle)};
        uint32_t triangle;
        if (!psplat_region_contains(region, uv, 1 + rim_slack, 0)) continue;
        psplat_region_point(region, uv, point);
        psplat_result result =
            psplat_distance_nearest(context->limits->distance, point, nearest, &triangle);
        if (result) return result;
        if (triangle == PSPLAT_NONE) continue;
        sub3(away, point, nearest);
        if (dot3(away, context->surface->face_normals + 3 * (size_t)triangle) > 0)
            *stand_off = max2(*stand_off, length3(away));
    }
    return PSPLAT_OK;
}

static psplat_result measure(const psplat_fit_context *context, size_t index, void *user) {
    trimmer *t = user;
    t->splats[index].scale = 1;
    return find_stand_off(context, &t->before.regions[index], &t->splats[index].stand_off);
}

static int compare_order(const void *left, const void *right) {
    const trimmed *const *a = left, *const *b = right;
    if ((*a)->stand_off != (*b)->stand_off) return (*a)->stand_off > (*b)->stand_off ? -1 : 1;
    return *a < *b ? -1 : *a > *b;
}

/* Returns how far a sample is from the centre of a region, in radii. */
static double radius_of(const psplat_samples *samples, const psplat_region *region,
                        uint32_t sample) {
    double uvh[3];
    psplat_region_local(region, samples->positions + 3 * (size_t)sample, uvh);
    return hypot(uvh[0], uvh[1]);
}

/* Chooses the scale of a candidate: it leaves samples that others are recorded to cover, too. */
static void choose_scale(trimmer *t, size_t index) {
    const psplat_samples *samples = &t->c->samples;
    const psplat_region *region = &t->before.regions[index];
    const psplat_candidate *candidate = &t->c->selection.candidates[index];
    double needed = 0, scale;
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (t->covers[candidate->covered[i]] == 1)
            needed = max2(needed, radius_of(samples, region, candidate->covered[i]));
    needed += margin_spacings * samples->spacing / min2(region->radius[0], region->radius[1]);
    scale = min2(max2(needed, least_scale), 1);
    for (size_t i = 0; i < candidate->covered_count && scale < 1; ++i)
        t->covers[candidate->covered[i]] -=
            radius_of(samples, region, candidate->covered[i]) > scale;
    t->splats[index].scale = scale;
}

/* Chooses the scales of all candidates, those first that stand off most. Returns 0 when out of
 * memory. */
static int choose_scales(trimmer *t) {
    const psplat_candidate *candidates = t->c->selection.candidates;
    const trimmed **order = malloc((t->count + 1) * sizeof *order);
    t->covers = calloc(t->c->samples.count + 1, sizeof *t->covers);
    int ok = order && t->covers;
    for (size_t i = 0; i < t->count && ok; ++i) {
        order[i] = &t->splats[i];
        for (size_t k = 0; k < candidates[i].covered_count; ++k)
            ++t->covers[candidates[i].covered[k]];
    }
    if (ok) qsort(order, t->count, sizeof *order, compare_order);
    for (size_t i = 0; i < t->count && ok; ++i)
        if (order[i]->stand_off >= least_stand_off * t->c->limits.tolerance)
            choose_scale(t, (size_t)(order[i] - t->splats));
    free(order);
    return ok;
}

/* ---- smaller splats -------------------------------------------------------------------------- */

/* Drops the samples beyond a scale from what a candidate is recorded to cover. */
static void leave(const psplat_samples *samples, double scale, psplat_candidate *candidate) {
    size_t kept = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (radius_of(samples, &candidate->region, candidate->covered[i]) <= scale)
            candidate->covered[kept++] = candidate->covered[i];
    candidate->covered_count = kept;
}

/* Shrinks a candidate around its centre, and stores whether it keeps the limits and covers what it
 * does not leave, on the grid if there is one. */
static psplat_result shrink(const psplat_fit_context *context, double scale,
                            psplat_candidate *candidate, int *fits) {
    psplat_region region = candidate->region;
    psplat_site site = psplat_site_of(&region, candidate->triangle);
    *fits = 0;
    leave(context->samples, scale, candidate);
    if (!candidate->covered_count) return PSPLAT_OK;
    psplat_candidate_put_nearest_first(context->samples, region.center, candidate);
    for (int k = 0; k < 2; ++k) region.radius[k] *= scale;
    psplat_fit_status status = psplat_candidate_replace(context, &site, &region, 0, 1, candidate);
    if (status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    *fits = !status;
    if (!*fits || !context->limits->precision) return PSPLAT_OK;
    return psplat_quantize_whole_candidate(context, candidate, fits);
}

/* Replaces a candidate by a smaller one, if that keeps the limits. */
static psplat_result trim(const psplat_fit_context *context, size_t index, void *user) {
    trimmer *t = user;
    trimmed *splat = &t->splats[index];
    psplat_candidate *candidate = &t->c->selection.candidates[index], smaller;
    int fits;
    if (splat->scale == 1) return PSPLAT_OK;
    if (!psplat_candidate_copy(candidate, &smaller)) return PSPLAT_ERROR_MEMORY;
    psplat_result result = shrink(context, splat->scale, &smaller, &fits);
    splat->is_trimmed =
        !result && fits &&
        psplat_region_ellipse(&smaller.region) < psplat_region_ellipse(&candidate->region);
    if (splat->is_trimmed) {
        splat->whole = *candidate;
        *candidate = smaller;
    } else {
        psplat_candidate_free(&smaller);
    }
    return result;
}

/* ---- what was needed after all --------------------------------------------------------------- */

/* Gives a candidate its old size. */
static void restore(trimmer *t, uint32_t index) {
    trimmed *splat = &t->splats[index];
    psplat_candidate *candidate = &t->c->selection.candidates[index];
    psplat_candidate_free(candidate);
    *candidate = splat->whole;
    splat->whole = (psplat_candidate){0};
    splat->is_trimmed = 0;
}

/* A hole, or a ray that meets nothing, and the splat that would close it at its old size. */
typedef struct opening {
    const trimmer *t;
    const psplat_ray_hole *ray; /* NULL: it is a hole */
    double point[3], normal[3]; /* of the hole */
    uint32_t closing;           /* of several the one that stands off least; PSPLAT_NONE: none */
    int is_closed;              /* by one that has its old size */
} opening;

/* Returns whether a splat closes an opening at its old size. */
static int closes(const opening *o, uint32_t index) {
    const psplat_measured_splats *before = &o->t->before;
    double uvh[3];
    if (o->ray)
        return psplat_ray_hole_is_closed(o->ray, &before->regions[index], before->tolerance);
    psplat_region_local(&before->regions[index], o->point, uvh);
    return psplat_measured_splats_cover(before, index, o->normal, uvh);
}

static int visit_before(void *user, uint32_t index) {
    opening *o = user;
    const trimmed *splats = o->t->splats;
    if (!closes(o, index)) return 0;
    if (!splats[index].is_trimmed)
        o->is_closed = 1;
    else if (o->closing == PSPLAT_NONE || splats[index].stand_off < splats[o->closing].stand_off ||
             (splats[index].stand_off == splats[o->closing].stand_off && index < o->closing))
        o->closing = index;
    return o->is_closed;
}

/* Gives a splat its old size that closes an opening within reach of a point by that. Returns
 * whether one does. */
static int close_opening(trimmer *t, opening *o, const double point[3], double reach) {
    double low[3], high[3];
    o->t = t;
    o->closing = PSPLAT_NONE;
    for (int k = 0; k < 3; ++k) low[k] = point[k] - reach, high[k] = point[k] + reach;
    psplat_region_tree_visit_box(t->before.region_tree, low, high, visit_before, o);
    if (o->is_closed || o->closing == PSPLAT_NONE) return 0;
    restore(t, o->closing);
    return 1;
}

static int close_ray(trimmer *t, const psplat_ray_hole *ray) {
    opening o = {.ray = ray};
    return close_opening(t, &o, ray->sight.point,
                         t->before.tolerance / PSPLAT_FLATTEST_SIGHT_COSINE);
}

static int close_hole(trimmer *t, const psplat_holes *holes, size_t i) {
    const psplat_surface *surface = &t->c->surface;
    opening o = {.ray = NULL};
    double weights[3];
    float normal[3];
    for (size_t k = 0; k < 3; ++k) o.point[k] = holes->points[3 * i + k];
    psplat_surface_barycentric(surface, holes->triangles[i], o.point, weights);
    psplat_surface_normal(surface, holes->triangles[i], weights, normal);
    for (int k = 0; k < 3; ++k) o.normal[k] = (double)normal[k];
    return close_opening(t, &o, o.point, 0);
}

/* Restores what closed holes. Another hole may be found then, where one was in the same place. */
static psplat_result restore_for_holes(trimmer *t) {
    psplat_result result = PSPLAT_OK;
    size_t restored = 1;
    for (int round = 0; round < HOLE_ROUNDS && restored && !result; ++round) {
        psplat_holes holes;
        result = psplat_find_holes(t->c, &holes);
        restored = 0;
        for (size_t i = 0; i < holes.count; ++i) restored += (size_t)close_hole(t, &holes, i);
        psplat_holes_free(&holes);
    }
    return result;
}

/* Restores what rays met. Those of another round pass other points. */
static psplat_result restore_for_rays(trimmer *t) {
    psplat_result result = PSPLAT_OK;
    for (int round = 0; round < RAY_ROUNDS && !result; ++round) {
        psplat_measured_splats measured;
        psplat_ray_holes rays;
        result = psplat_rim_rays_find(t->c, rim_spacing_tolerances, wall_tolerances,
                                      t->c->desc->seed + (uint64_t)round, &measured, &rays);
        for (size_t i = 0; i < rays.count && !result; ++i) close_ray(t, &rays.holes[i]);
        psplat_ray_holes_free(&rays);
        psplat_measured_splats_free(&measured);
    }
    return result;
}

/* ---- all ------------------------------------------------------------------------------------- */

static psplat_result begin(trimmer *t, psplat_conversion *c) {
    *t = (trimmer){.c = c, .count = c->selection.count};
    t->splats = calloc(t->count + 1, sizeof *t->splats);
    t->before = (psplat_measured_splats){.count = t->count, .tolerance = c->limits.tolerance};
    t->before.regions = malloc((t->count + 1) * sizeof *t->before.regions);
    if (!t->splats || !t->before.regions) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < t->count; ++i) t->before.regions[i] = c->selection.candidates[i].region;
    t->before.region_tree = psplat_region_tree_create(t->before.regions, t->count,
                                                      PSPLAT_STEEPEST_REACH * c->limits.tolerance);
    return t->before.region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

static int is_any_trimmed(const trimmer *t) {
    int any = 0;
    for (size_t i = 0; i < t->count; ++i) any |= t->splats[i].is_trimmed;
    return any;
}

psplat_result psplat_trim_splats(psplat_conversion *c, psplat_error *error) {
    trimmer t;
    int any = 0;
    const psplat_fit_context context = psplat_conversion_context(c);
    if (!c->limits.distance) return PSPLAT_OK;
    psplat_result result = begin(&t, c);
    if (!result) result = psplat_fit_each(&context, t.count, measure, &t);
    if (!result && !choose_scales(&t)) result = PSPLAT_ERROR_MEMORY;
    if (!result) result = psplat_fit_each(&context, t.count, trim, &t);
    if (!result) any = is_any_trimmed(&t);
    if (any) result = restore_for_rays(&t);
    if (any && !result) result = restore_for_holes(&t);
    if (result) psplat_fail(error, result, 0, "out of memory while trimming splats");
    trimmer_free(&t);
    if (!result && any) result = psplat_fill_last_holes(c, error);
    psplat_selection_drop_untaken(&c->selection);
    return result;
}
