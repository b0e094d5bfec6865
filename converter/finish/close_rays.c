/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * close_rays.c - the closing of gaps that slanted rays find between splats of different heights.
 *
 * A cover of the surface along its normals leaves gaps in slanted views where one splat lies higher
 * than the next: the overlap has to grow with the step between them. How much of it there is to be
 * depends on both splats and on the view, so rays decide. A ray that meets nothing where it sees
 * the surface would meet each splat nearby if that reached farther. The one that lacks least is
 * extended, by the smallest ellipse that holds the old one and the place where the ray meets its
 * surface, if all limits allow that; else the next one. A new candidate grows where none can be
 * extended, and is worth the gaps that it closes. Those through which one sees count most: most
 * rays that pass between curved splats meet one of that place a little too high or too low, or its
 * wall.
 */
#include "finish/close_rays.h"

#include "base/angle.h"
#include "base/block_boxes.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/grow_ellipse.h"
#include "fit/quantize_candidate.h"
#include "fit/surface_fit.h"
#include "measure/measured_splats.h"
#include "measure/ray_holes.h"
#include "measure/ray_meeting.h"
#include "finish/close_cracks.h"
#include "finish/close_seams.h"
#include "select/conversion.h"
#include "select/effort.h"
#include "select/fill_holes.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* How many splats each ray may have extended in turn, the points of the surface from which rays are
 * cast for each splat on average, and the seeds of new candidates for each one that there may be.
 */
enum { CHOICES = 3, POINTS_PER_SPLAT = 100, SEEDS_PER_CANDIDATE = 5 };
/* After how many rays in a row that it cannot be extended to a candidate is left alone, in later
 * rounds too: what stopped it mostly stops it again. */
enum { FAILURES = 2 };
/* The greatest distance of a ray from the centre of a splat that is extended to it, in units of u
 * and v, and how much farther than that the ellipse then reaches, which rounding uses up. */
static const double most_distance = 2, spare = 0.03;
/* How far from the surface of an extended splat, in tolerances, samples are that a new one is
 * fitted to. */
static const double most_height = 3;
/* By how much the error of colours of an extended splat may exceed the tolerance: its colour stays
 * that of the samples it is recorded to cover, and rims weigh little, but those of another colour
 * can be seen. */
static const double color_factor = 1.5;
/* How far the points lie apart at which rays pass rims, in tolerances. */
static const double rim_spacing_tolerances = 2;
/* What closing a gap that does not show is worth, as a part of one that does. The rim that hides it
 * stands off from the surface, often beside an outline, and may be cut off once the gap is closed.
 */
static const double hidden_worth = 0.3;
/* How many candidates there may be in the end for each that there were: what gaps may cost. */
static const double most_growth = 1.1;
/* Rounds end where one leaves more than this share of its gaps open, or finds more than this share
 * of those of the round before. */
static const double stalling_share = 0.85;

/* A splat that a ray would meet if it were larger. */
typedef struct choice {
    uint32_t candidate; /* PSPLAT_NONE: there is none */
    double distance;    /* of the meeting from the centre, in units of u and v */
} choice;

/* A ray that passes between splats. */
typedef struct gap {
    psplat_ray_hole hole;
    choice choices[CHOICES]; /* nearest first */
    int closed;              /* 1: by a candidate, or to be closed by close_cracks.c */
    int shows;               /* 1: one sees through; 0: a splat or its wall hides that, too high or
                                too low as it is */
} gap;

/* The state of a round. */
typedef struct closer {
    psplat_conversion *c;
    psplat_region *regions;          /* of all candidates */
    psplat_measured_splats measured; /* of these; owned */
    gap *gaps;
    size_t count;
    psplat_block_boxes blocks; /* of the gaps' points */
    size_t most;               /* candidates that there may be */
    int turn;                  /* which choice is extended */
    uint32_t
        *order; /* gaps by the candidate of that choice; those of a candidate follow each other */
    uint32_t *first; /* candidates + 1: the first of each in order */
} closer;

/* ---- extension ------------------------------------------------------------------------------- */

/* Sets the axes of a region to those of the ellipse with these conjugate diameters, along the old
 * axes. */
static void set_axes(const double a[2], const double b[2], psplat_region *region) {
    double aa = a[0] * a[0] + a[1] * a[1], bb = b[0] * b[0] + b[1] * b[1];
    double angle = 0.5 * atan2(2 * (a[0] * b[0] + a[1] * b[1]), aa - bb);
    double x = cos(angle), y = sin(angle), axis[3] = {0, 0, 0};
    mad3(axis, x * a[0] + y * b[0], region->u);
    mad3(axis, x * a[1] + y * b[1], region->v);
    region->radius[0] = normalize3(axis);
    region->radius[1] = hypot(x * b[0] - y * a[0], x * b[1] - y * a[1]);
    memcpy(region->u, axis, sizeof axis);
    cross3(region->v, region->n, region->u);
}

/* Gives a region the surface of another one with the same centre and plane. */
static void turn_surface(const psplat_region *old, psplat_region *region) {
    double x = dot3(region->u, old->u), y = dot3(region->u, old->v);
    const double *h = old->hessian, *s = old->slope;
    region->slope[0] = x * s[0] + y * s[1];
    region->slope[1] = x * s[1] - y * s[0];
    region->hessian[0] = x * x * h[0] + 2 * x * y * h[1] + y * y * h[2];
    region->hessian[1] = (x * x - y * y) * h[1] + x * y * (h[2] - h[0]);
    region->hessian[2] = y * y * h[0] - 2 * x * y * h[1] + x * x * h[2];
}

/* Fits the surface of a region to that of another one. */
static void fit_to(const psplat_region *old, psplat_region *region) {
    enum { SIDES = 16, RINGS = 3 };
    psplat_near_sample samples[SIDES * RINGS];
    for (int i = 0; i < SIDES * RINGS; ++i) {
        double angle = 2 * PSPLAT_PI * i / SIDES, r = (1 + i / SIDES) / (double)RINGS;
        double at[3], uvh[3], p[3];
        memcpy(at, region->center, sizeof at);
        mad3(at, r * cos(angle) * region->radius[0], region->u);
        mad3(at, r * sin(angle) * region->radius[1], region->v);
        psplat_region_local(old, at, uvh);
        psplat_region_point(old, uvh, p);
        sub3(samples[i].p, p, region->center);
        psplat_region_normal(old, uvh, samples[i].n);
        samples[i].index = (uint32_t)i;
    }
    const double origin[3] = {region->center[0], region->center[1], region->center[2]};
    psplat_fit_surface(samples, NULL, SIDES * RINGS, origin, HUGE_VAL, region);
}

/* How an ellipse is extended to a place outside: about the same centre, so that its frame and its
 * surface stay; or with the centre moved that way, on the same surface or on one that is fitted to
 * the samples there. */
typedef enum extension { ABOUT_CENTER, MOVED, FITTED, NARROW, EXTENSIONS } extension;

/* Returns a region on the same surface whose ellipse holds the old one and reaches as far as
 * distance, more than 1, in the direction of uv. The smallest one reaches 1 + c along that and the
 * root of it across, c away from the old centre; the one about the centre stays as wide as it was.
 */
static psplat_region extended(const psplat_region *old, const double uv[2], double distance,
                              extension how) {
    double length = hypot(uv[0], uv[1]), w[2] = {uv[0] / length, uv[1] / length};
    double along = how == ABOUT_CENTER ? distance : (distance + 1) / 2;
    double across = how == ABOUT_CENTER || how == NARROW ? 1 : sqrt(along);
    const double a[2] = {along * w[0] * old->radius[0], along * w[1] * old->radius[1]};
    const double b[2] = {-across * w[1] * old->radius[0], across * w[0] * old->radius[1]};
    psplat_region region = *old;
    region.line_count = 0;
    if (how != ABOUT_CENTER) {
        const double middle[2] = {(distance - along) * w[0], (distance - along) * w[1]};
        psplat_region_point(old, middle, region.center);
        set_axes(a, b, &region);
        if (psplat_region_is_curved(old)) fit_to(old, &region);
        return region;
    }
    set_axes(a, b, &region);
    turn_surface(old, &region);
    return region;
}

/* Fits the surface of a region to the samples over its ellipse. Fails only with
 * PSPLAT_ERROR_MEMORY. */
static psplat_result fit_to_samples(const psplat_fit_context *context, psplat_site *site,
                                    psplat_region *region) {
    const psplat_neighborhood *near = &context->scratch->near;
    double away = sqrt(distance2_3(region->center, site->metric.center));
    psplat_result result = psplat_site_gather(context, site, psplat_region_reach(region) + away);
    if (result) return result;
    uint32_t *some = malloc((near->count + 1) * sizeof *some);
    size_t count = 0;
    if (!some) return PSPLAT_ERROR_MEMORY;
    for (uint32_t i = 0; i < near->count; ++i) {
        double p[3], uvh[3];
        along3(p, near->origin, 1, near->samples[i].p);
        psplat_region_local(region, p, uvh);
        if (uvh[0] * uvh[0] + uvh[1] * uvh[1] <= 1 &&
            fabs(uvh[2]) <= most_height * context->limits->tolerance &&
            dot3(near->samples[i].n, region->n) > PSPLAT_LEAST_COVERED_COSINE)
            some[count++] = i;
    }
    const double origin[3] = {near->origin[0], near->origin[1], near->origin[2]};
    if (count)
        psplat_fit_surface(near->samples, some, count, origin, psplat_most_normal_pull(context),
                           region);
    free(some);
    return PSPLAT_OK;
}

/* Stores whether some points of the rim of a region that the lines of an old one do not cut off are
 * near the mesh: most regions that leave the surface do so there, and few points tell sooner than
 * an evaluation. The first point is at the angle `from`, and others follow on both sides. */
static psplat_result test_rim(const psplat_limits *limits, const psplat_region *old,
                              const psplat_region *region, double from, int *near) {
    enum { SIDES = 12 };
    double points[SIDES][3];
    size_t count = 0;
    *near = 1;
    if (!limits->distance) return PSPLAT_OK;
    for (int i = 0; i < SIDES; ++i) {
        double angle = from + 2 * PSPLAT_PI * (i % 2 ? -(i + 1) / 2 : i / 2) / SIDES, uvh[3];
        const double uv[2] = {cos(angle), sin(angle)};
        psplat_region_point(region, uv, points[count]);
        psplat_region_local(old, points[count], uvh);
        count += (size_t)psplat_region_contains(old, uvh, HUGE_VAL, 0);
    }
    const psplat_distance *asked = limits->proxy ? limits->proxy : limits->distance;
    double tolerance = limits->tolerance - (limits->proxy ? limits->proxy_deviation : 0);
    return psplat_distance_within(asked, points[0], count, tolerance, near);
}

/* Replaces a candidate's region by one that a ray meets, if that keeps the limits. */
static psplat_result try_region(const psplat_fit_context *context, psplat_site *site,
                                const psplat_ray_hole *hole, const psplat_region *region,
                                psplat_candidate *candidate) {
    psplat_candidate tried;
    if (!psplat_candidate_copy(candidate, &tried)) return PSPLAT_ERROR_MEMORY;
    psplat_fit_status status = psplat_candidate_replace(context, site, region, 0, 1, &tried);
    psplat_result result = status == PSPLAT_FIT_MEMORY ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
    int fits = !status;
    if (fits && context->limits->precision)
        result = psplat_quantize_whole_candidate(context, &tried, &fits);
    if (!result && fits &&
        psplat_ray_hole_is_closed(hole, &tried.region, context->limits->tolerance)) {
        psplat_candidate old = *candidate;
        *candidate = tried;
        tried = old;
    }
    psplat_candidate_free(&tried);
    return result;
}

/* Makes a region that extends a candidate to (u, v) in one of the ways, and stores whether it is
 * worth trying. */
static psplat_result make_region(const psplat_fit_context *context, psplat_site *site,
                                 const psplat_candidate *candidate, const double uv[2],
                                 double distance, extension how, psplat_region *region,
                                 int *worth) {
    double p[3], uvh[3];
    psplat_result result = PSPLAT_OK;
    *worth = 0;
    *region = extended(&candidate->region, uv, distance, how);
    if (how >= FITTED) result = fit_to_samples(context, site, region);
    if (result) return result;
    psplat_region_point(&candidate->region, uv, p);
    psplat_region_local(region, p, uvh);
    return test_rim(context->limits, &candidate->region, region, atan2(uvh[1], uvh[0]), worth);
}

/* Extends a candidate to a ray that would meet it at (u, v), if it were larger. */
static psplat_result extend(const psplat_fit_context *context, psplat_site *site,
                            const psplat_ray_hole *hole, const double uv[2], double distance,
                            psplat_candidate *candidate) {
    psplat_result result = PSPLAT_OK;
    int ways = context->limits->planar ? FITTED : EXTENSIONS;
    for (int how = 0; how < ways && !result; ++how) {
        psplat_region region;
        int worth;
        result =
            make_region(context, site, candidate, uv, distance, (extension)how, &region, &worth);
        if (!result && worth) result = try_region(context, site, hole, &region, candidate);
        if (psplat_ray_hole_is_closed(hole, &candidate->region, context->limits->tolerance)) break;
    }
    return result;
}

/* Extends a candidate to the rays that chose it. */
static psplat_result extend_to_all(const psplat_fit_context *context, size_t index, void *user) {
    const closer *r = user;
    psplat_candidate *candidate = &r->c->selection.candidates[index];
    psplat_site site = psplat_site_of(&candidate->region, candidate->triangle);
    psplat_result result = PSPLAT_OK;
    for (uint32_t i = r->first[index];
         i < r->first[index + 1] && candidate->failed_extensions < FAILURES && !result; ++i) {
        const psplat_ray_hole *hole = &r->gaps[r->order[i]].hole;
        double height, uv[2], tolerance = context->limits->tolerance;
        if (!candidate->covered_count ||
            psplat_ray_hole_is_closed(hole, &candidate->region, tolerance) ||
            !psplat_sight_leaves(&hole->sight, &candidate->region, &height, uv))
            continue;
        double distance = hypot(uv[0], uv[1]) * (1 + spare);
        if (distance < 1 || distance > most_distance) continue;
        result = extend(context, &site, hole, uv, distance, candidate);
        if (psplat_ray_hole_is_closed(hole, &candidate->region, tolerance))
            candidate->failed_extensions = 0;
        else
            ++candidate->failed_extensions;
    }
    return result;
}

/* ---- choices --------------------------------------------------------------------------------- */

/* The search for the splats that lack least to be met by a ray. */
typedef struct chooser {
    const closer *closer;
    gap *gap;
} chooser;

static int visit_choice(void *user, uint32_t candidate) {
    chooser *s = user;
    const psplat_region *region = &s->closer->regions[candidate];
    const psplat_ray_hole *hole = &s->gap->hole;
    double height, uv[2], tolerance = s->closer->measured.tolerance;
    if (psplat_crack_width(&hole->sight, hole->cosine, region, tolerance) <=
        PSPLAT_GREATEST_CRACK * tolerance)
        s->gap->closed = 1;
    if (!psplat_sight_leaves(&hole->sight, region, &height, uv) ||
        fabs(height) * hole->cosine > tolerance ||
        !psplat_region_contains(region, uv, most_distance, 0))
        return 0;
    choice new = {candidate, hypot(uv[0], uv[1])}, *choices = s->gap->choices;
    for (int k = 0; k < CHOICES; ++k) {
        if (choices[k].candidate != PSPLAT_NONE && choices[k].distance <= new.distance) continue;
        choice old = choices[k];
        choices[k] = new;
        new = old;
    }
    return 0;
}

static void choose(const closer *r, gap *gap) {
    double low[3], high[3], reach = r->measured.tolerance / PSPLAT_FLATTEST_SIGHT_COSINE;
    chooser s = {r, gap};
    for (int k = 0; k < CHOICES; ++k) gap->choices[k] = (choice){PSPLAT_NONE, 0};
    for (int k = 0; k < 3; ++k) {
        low[k] = gap->hole.sight.point[k] - reach;
        high[k] = gap->hole.sight.point[k] + reach;
    }
    psplat_region_tree_visit_box(r->measured.region_tree, low, high, visit_choice, &s);
}

static uint32_t chosen(const closer *r, const gap *gap) {
    return gap->closed ? PSPLAT_NONE : gap->choices[r->turn].candidate;
}

/* Sorts the gaps of a candidate: those first that need least. */
static void sort_group(const closer *r, uint32_t begin, uint32_t end) {
    for (uint32_t i = begin + 1; i < end; ++i) {
        uint32_t moved = r->order[i], at = i;
        double distance = r->gaps[moved].choices[r->turn].distance;
        for (; at > begin && r->gaps[r->order[at - 1]].choices[r->turn].distance > distance; --at)
            r->order[at] = r->order[at - 1];
        r->order[at] = moved;
    }
}

/* Groups the open gaps by the candidates that they choose. */
static void group(const closer *r) {
    size_t candidates = r->c->selection.count;
    memset(r->first, 0, (candidates + 2) * sizeof *r->first);
    for (size_t i = 0; i < r->count; ++i)
        if (chosen(r, &r->gaps[i]) != PSPLAT_NONE) ++r->first[chosen(r, &r->gaps[i]) + 2];
    for (size_t i = 0; i < candidates; ++i) r->first[i + 2] += r->first[i + 1];
    for (size_t i = 0; i < r->count; ++i) {
        uint32_t candidate = chosen(r, &r->gaps[i]);
        if (candidate != PSPLAT_NONE) r->order[r->first[candidate + 1]++] = (uint32_t)i;
    }
    for (size_t i = 0; i < candidates; ++i) sort_group(r, r->first[i], r->first[i + 1]);
}

/* Marks the gaps that the candidates which they chose have closed. */
static void mark_closed(closer *r) {
    for (size_t i = 0; i < r->count; ++i) {
        uint32_t candidate = chosen(r, &r->gaps[i]);
        if (candidate != PSPLAT_NONE)
            r->gaps[i].closed = psplat_ray_hole_is_closed(
                &r->gaps[i].hole, &r->c->selection.candidates[candidate].region,
                r->measured.tolerance);
    }
}

/* ---- new candidates -------------------------------------------------------------------------- */

static size_t count_open(const closer *r) {
    size_t open = 0;
    for (size_t i = 0; i < r->count; ++i) open += !r->gaps[i].closed;
    return open;
}

/* Appends points of the gaps that are left to the samples, at most so many, spread over all gaps:
 * candidates from beside one that shows may close that, too. Stores the seeds. */
static psplat_result append_seeds(closer *r, size_t most, uint32_t **seeds, size_t *count,
                                  psplat_error *error) {
    psplat_samples *samples = &r->c->samples;
    double *points = malloc((r->count + 1) * 3 * sizeof *points);
    uint32_t *triangles = malloc((r->count + 1) * sizeof *triangles);
    *seeds = malloc((r->count + 1) * sizeof **seeds);
    psplat_result result = points && triangles && *seeds ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    size_t open = count_open(r), met = 0;
    *count = 0;
    for (size_t i = 0; !result && i < r->count; ++i) {
        const double *p = r->gaps[i].hole.sight.point;
        if (r->gaps[i].closed || *count * open > met++ * most) continue;
        memcpy(points + 3 * *count, p, 3 * sizeof *p);
        triangles[*count] = r->gaps[i].hole.triangle;
        (*seeds)[*count] = (uint32_t)(samples->count + *count);
        ++*count;
    }
    if (!result && *count)
        result = psplat_samples_append(samples, &r->c->surface, points, triangles, *count, error);
    free(points);
    free(triangles);
    return result;
}

/* Grows the ellipse of a new candidate, and moves it to the grid where the limits have a precision.
 */
static psplat_result finish_new(const psplat_fit_context *context, size_t index, void *user) {
    const psplat_selection *selection = user;
    psplat_candidate *candidate = &selection->candidates[index];
    if (candidate->taken) return PSPLAT_OK;
    psplat_result result = psplat_grow_ellipse(context, candidate);
    if (result || !context->limits->precision) return result;
    return psplat_quantize_candidate(context, candidate);
}

/* Returns what a region gains: the cosines of the open gaps that it closes, since those that are
 * seen straight on show most, and hidden_worth of it for those that do not show. Marks all that it
 * closes where mark is 1. */
static double gain_of(closer *r, const psplat_region *region, int mark) {
    double gain = 0, tolerance = r->measured.tolerance;
    double far = psplat_region_reach(region) + tolerance / PSPLAT_FLATTEST_SIGHT_COSINE;
    for (size_t i = psplat_block_boxes_next(&r->blocks, 0, region->center, far); i < r->count;
         i = psplat_block_boxes_next(&r->blocks, i + 1, region->center, far)) {
        if (r->gaps[i].closed ||
            distance2_3(r->gaps[i].hole.sight.point, region->center) > far * far ||
            !psplat_ray_hole_is_closed(&r->gaps[i].hole, region, tolerance))
            continue;
        r->gaps[i].closed = mark;
        gain += (r->gaps[i].shows ? 1 : hidden_worth) * r->gaps[i].hole.cosine;
    }
    return gain;
}

/* Takes the new candidates that gain most, in turn, and at most so many. Gains only shrink, so that
 * one that was counted before bounds what there is to gain. */
static psplat_result take_best(closer *r, size_t from, size_t most) {
    psplat_selection *s = &r->c->selection;
    size_t count = s->count - from;
    double *gains = malloc((count + 1) * sizeof *gains);
    if (!gains) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) gains[i] = gain_of(r, &s->candidates[from + i].region, 0);
    while (most) {
        size_t best = 0;
        for (size_t i = 1; i < count; ++i)
            if (gains[i] > gains[best]) best = i;
        if (!count || !(gains[best] > 0)) break;
        psplat_candidate *candidate = &s->candidates[from + best];
        double gain = gain_of(r, &candidate->region, 0);
        if (gain > 0 && gain == gains[best]) {
            gain_of(r, &candidate->region, 1);
            candidate->taken = 1;
            --most;
            gain = 0;
        }
        gains[best] = gain;
    }
    free(gains);
    return PSPLAT_OK;
}

/* Forgets the samples from index first on, which were seeds: other candidates do not know whether
 * they cover them. A candidate that covers nothing else is not taken. */
static void forget_seeds(closer *r, size_t first, size_t from) {
    psplat_selection *s = &r->c->selection;
    for (size_t i = from; i < s->count; ++i) {
        psplat_candidate *candidate = &s->candidates[i];
        size_t kept = 0;
        for (size_t k = 0; k < candidate->covered_count; ++k)
            if (candidate->covered[k] < first) candidate->covered[kept++] = candidate->covered[k];
        candidate->covered_count = kept;
    }
    psplat_samples_truncate(&r->c->samples, first);
}

static int covers_nothing(const psplat_candidate *candidate) {
    return !candidate->covered_count;
}

/* Frees the candidates from an index on that cover no sample. */
static void drop_empty(psplat_selection *s, size_t from) {
    size_t kept = from;
    for (size_t i = from; i < s->count; ++i) {
        psplat_candidate candidate = s->candidates[i];
        if (covers_nothing(&candidate))
            psplat_candidate_free(&candidate);
        else
            s->candidates[kept++] = candidate;
    }
    s->count = kept;
}

/* Drops the new candidates but those, a few more than may be taken, that gain most as they are. */
static psplat_result drop_poor(closer *r, size_t from, size_t most) {
    psplat_selection *s = &r->c->selection;
    uint8_t *closed = malloc(r->count + 1);
    if (!closed) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < r->count; ++i) closed[i] = (uint8_t)r->gaps[i].closed;
    psplat_result result = take_best(r, from, most + (most + 1) / 2);
    for (size_t i = 0; i < r->count; ++i) r->gaps[i].closed = closed[i];
    psplat_selection_drop_untaken(s);
    for (size_t i = from; i < s->count; ++i) s->candidates[i].taken = 0;
    free(closed);
    return result;
}

/* Grows candidates in the gaps that are left, and takes those that close most of them. */
static psplat_result add_candidates(closer *r, psplat_error *error) {
    uint32_t *seeds;
    psplat_selection *selection = &r->c->selection;
    size_t count, from = selection->count, first = r->c->samples.count;
    size_t most = r->most > from ? r->most - from : 0;
    if (!most) return PSPLAT_OK;
    psplat_result result = append_seeds(r, SEEDS_PER_CANDIDATE * most, &seeds, &count, error);
    const psplat_fit_context context = psplat_conversion_context(r->c);
    if (!result && count) {
        result = psplat_selection_grow(&context, seeds, count, selection);
        forget_seeds(r, first, from);
        drop_empty(selection, from);
        if (!result) result = drop_poor(r, from, most);
        if (!result) result = psplat_fit_each(&context, selection->count, finish_new, selection);
        drop_empty(selection, from);
        if (!result) result = take_best(r, from, most);
        psplat_selection_drop_untaken(selection);
    }
    free(seeds);
    return result;
}

/* ---- rounds ---------------------------------------------------------------------------------- */

/* Stores the regions that candidates will have once their seams are closed, but for the few whose
 * lines will stay since the surface is too far: proofs take long. The candidates stay as they are,
 * since lines that have been moved would be moved again. */
static psplat_result copy_closed_regions(closer *r) {
    psplat_selection closed = r->c->selection;
    psplat_fit_context context = psplat_conversion_context(r->c);
    psplat_limits unproven = *context.limits;
    unproven.distance = unproven.proxy = NULL;
    context.limits = &unproven;
    closed.candidates = malloc((closed.count + 1) * sizeof *closed.candidates);
    if (!closed.candidates) return PSPLAT_ERROR_MEMORY;
    if (closed.count)
        memcpy(closed.candidates, r->c->selection.candidates,
               closed.count * sizeof *closed.candidates);
    psplat_result result = psplat_close_seams(&context, &closed);
    for (size_t i = 0; i < closed.count; ++i) r->regions[i] = closed.candidates[i].region;
    free(closed.candidates);
    return result;
}

/* Returns the number of points from which rays are cast. They are spread over an apron, too, which
 * has no splats. */
static size_t count_points(const psplat_conversion *c) {
    const psplat_samples *samples = &c->samples;
    size_t owned = 0;
    for (size_t i = 0; i < samples->count; ++i)
        owned += (size_t)psplat_surface_owns(&c->surface, samples->positions + 3 * i);
    double share = owned ? (double)owned / (double)samples->count : 1;
    return (size_t)(POINTS_PER_SPLAT * (double)c->selection.count / share);
}

/* Finds the gaps between the candidates as they will be, and which of these each ray might meet. */
static psplat_result find_gaps(closer *r, uint64_t seed) {
    const psplat_selection *selection = &r->c->selection;
    psplat_ray_holes holes;
    r->measured =
        (psplat_measured_splats){.count = selection->count, .tolerance = r->c->limits.tolerance};
    r->measured.regions = r->regions = malloc((selection->count + 1) * sizeof *r->regions);
    if (!r->regions) return PSPLAT_ERROR_MEMORY;
    if (copy_closed_regions(r)) return PSPLAT_ERROR_MEMORY;
    r->measured.region_tree = psplat_region_tree_create(r->regions, selection->count, 0);
    if (!r->measured.region_tree) return PSPLAT_ERROR_MEMORY;
    const psplat_ray_search search = {.surface = &r->c->surface,
                                      .measured = &r->measured,
                                      .distance = r->c->distance,
                                      .points = count_points(r->c),
                                      .rim_spacing =
                                          rim_spacing_tolerances * r->c->limits.tolerance,
                                      .seed = seed};
    psplat_result result = psplat_ray_holes_find(&search, &holes);
    if (result) return result;
    psplat_measured_splats walled = r->measured;
    walled.wall = PSPLAT_WALL_TOLERANCES * walled.tolerance;
    r->gaps = calloc(holes.count + 1, sizeof *r->gaps);
    r->order = malloc((holes.count + 1) * sizeof *r->order);
    r->first = malloc((selection->count + 2) * sizeof *r->first);
    int ok = r->gaps && r->order && r->first &&
             psplat_block_boxes_create(holes.count, &r->blocks) == PSPLAT_OK;
    if (ok) r->count = holes.count;
    for (size_t i = 0; i < r->count; ++i) {
        r->gaps[i].hole = holes.holes[i];
        psplat_block_boxes_add(&r->blocks, i, holes.holes[i].sight.point);
        choose(r, &r->gaps[i]);
        r->gaps[i].shows = !r->gaps[i].closed && psplat_ray_hole_shows(&r->gaps[i].hole, &walled);
    }
    result = ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    psplat_ray_holes_free(&holes);
    return result;
}

/* Extends candidates to the rays, each in turn to those that choose it. */
static psplat_result extend_candidates(closer *r) {
    psplat_fit_context context = psplat_conversion_context(r->c);
    psplat_limits limits = *context.limits;
    psplat_result result = PSPLAT_OK;
    limits.color_tolerance *= color_factor;
    context.limits = &limits;
    for (r->turn = 0; r->turn < CHOICES && !result; ++r->turn) {
        group(r);
        result = psplat_fit_each(&context, r->c->selection.count, extend_to_all, r);
        if (!result) mark_closed(r);
    }
    return result;
}

/* Closes the gaps of a round. */
static psplat_result close_gaps(closer *r, psplat_error *error) {
    psplat_selection *selection = &r->c->selection;
    psplat_result result = extend_candidates(r);
    if (!result) result = add_candidates(r, error);
    if (!result) result = psplat_fill_last_holes(r->c, error);
    psplat_selection_drop_untaken(selection);
    return result;
}

static void free_round(closer *r) {
    psplat_measured_splats_free(&r->measured);
    psplat_block_boxes_free(&r->blocks);
    free(r->gaps);
    free(r->order);
    free(r->first);
}

/* Returns whether there are about as many gaps as before, once candidates gain by extension alone:
 * more rounds are of no use then. */
static int stalls(const psplat_conversion *c, size_t most, size_t now, size_t before) {
    return c->selection.count >= most && (double)now > stalling_share * (double)before;
}

psplat_result psplat_close_rays(psplat_conversion *c, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    int rounds = psplat_effort_of(c->desc).ray_rounds;
    size_t gaps = 1, few = c->selection.count, most = (size_t)ceil(most_growth * (double)few);
    for (int round = 0; round < rounds && gaps && !result; ++round) {
        /* New candidates of the second round know where those of the first one have left gaps. */
        int waits = !round && rounds > 1;
        closer r = {.c = c, .most = waits ? few + (most - few + 1) / 2 : most};
        if (psplat_conversion_interrupted(c->desc, "closing gaps", (double)round / rounds))
            return psplat_fail(error, PSPLAT_ERROR_INTERRUPTED, 0, "interrupted");
        result = find_gaps(&r, c->desc->seed + (uint64_t)round);
        size_t open = count_open(&r);
        gaps = stalls(c, most, open, gaps) ? 0 : open;
        if (!result && gaps) result = close_gaps(&r, error);
        if (stalls(c, most, count_open(&r), gaps))
            gaps = 0; /* The next round would find about these. */
        free_round(&r);
    }
    if (result && result != PSPLAT_ERROR_INTERRUPTED)
        psplat_fail(error, result, 0, "%s while closing gaps between splats",
                    psplat_result_text(result));
    return result;
}
