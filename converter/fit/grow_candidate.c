/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * grow_candidate.c - region growing of the largest splat around a sample that keeps the limits
 * (after Wu, Kobbelt 2004).
 *
 * The set of samples grows, not the ellipse: each try takes the nearest samples, whose covariance
 * gives the plane and the axes at once, and finds what the ellipse around them covers. Distances
 * are Euclidean at first. Then they are measured in the metric of the curvature found, so that
 * splats stretch along the direction in which the surface is straight. A splat may reach beyond the
 * samples that it covers, as long as all of it stays near the surface.
 */
#include "fit/grow_candidate.h"

#include "base/covariance.h"
#include "base/region.h"
#include "base/vector.h"
#include "features/neighborhood.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/grow_ellipse.h"
#include "fit/prove_candidate.h"
#include "fit/surface_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* All of these were chosen by hand. */
/* The greatest aspect ratio of the metric of the curvature, and the least one that is used. */
static const double greatest_stretch = 8, least_stretch = 1.25;
/* The reach up to which surroundings are gathered, as a multiple of the reach of the samples tried.
 */
static const double gathering_factor = 1.3;
/* The least share of the samples tried that a region without lines must cover. */
static const double least_covered_part = 0.7;
/* The first reach, in spacings, and the factor by which it grows. */
static const double first_reach_spacings = 5;
static const double reach_growth = 1.35;
/* The factor by which a candidate's radii shrink where its outline turns out to leave the mesh. */
static const double shrink_factor = 0.92;
/* The radii of discs that are tried where no fit is near enough, in spacings: that of the first,
 * and the factor of the next ones. */
static const double first_disc_spacings = 2, disc_shrink_factor = 0.7;
/* The radius of the disc of the last resort, in tolerances: small enough to be near the surface and
 * to leave no crease inside by a tolerance, whatever the surface does there. */
static const double disc_radius_tolerances = 0.4;

enum { BINS = 32 }; /* of heights */
enum { BISECTIONS = 4, HALVINGS = 8, RETREATS = 4, SHRINKINGS = 12, DISCS = 9 };
/* A plane needs three samples; a curvature needs more. */
enum { LEAST_SAMPLES = 3, LEAST_CURVED = 6 };

/* The search for the largest candidate around a sample. */
typedef struct search {
    const psplat_fit_context *context;
    psplat_site site;
    psplat_candidate *candidate; /* the best so far */
    size_t nearest;              /* samples in the surroundings of the region tried last */
    int failed;                  /* out of memory */
} search;

/* ---- fitting ------------------------------------------------------------------------------- */

/* Returns about the height that has the most of count heights within the tolerance of it. Where
 * that is possible for all, it is the middle of their range. */
static double best_height(const double *heights, size_t count, double tolerance) {
    size_t bins[BINS + 1] = {0}, within = 0, most = 0;
    double low = HUGE_VAL, high = -HUGE_VAL, best;
    for (size_t i = 0; i < count; ++i) {
        low = min2(low, heights[i]);
        high = max2(high, heights[i]);
    }
    best = (low + high) / 2;
    if (!(high - low > 2 * tolerance)) return best;
    double scale = BINS / (high - low);
    size_t window = (size_t)(2 * tolerance * scale);
    for (size_t i = 0; i < count; ++i) bins[(size_t)((heights[i] - low) * scale)]++;
    for (size_t i = 0; i <= BINS; ++i) {
        within += bins[i];
        if (i >= window) within -= bins[i - window];
        if (within <= most) continue;
        most = within;
        best = low + ((double)i + 1 - (double)window / 2) / scale;
    }
    return best;
}

/* Moves a region along its normal to where most of some samples are (indices into near; NULL: the
 * first count). Returns the greatest sum of the squares of their parameters. */
static double settle(const psplat_fit_context *context, const uint32_t *some, size_t count,
                     psplat_region *region) {
    const psplat_neighborhood *near = &context->scratch->near;
    double greatest = 0, *heights = context->scratch->heights;
    for (size_t i = 0; i < count; ++i) {
        double p[3], d[3];
        for (int k = 0; k < 3; ++k) p[k] = near->origin[k] + near->samples[some ? some[i] : i].p[k];
        psplat_region_local(region, p, d);
        greatest = max2(greatest, d[0] * d[0] + d[1] * d[1]);
        heights[i] = d[2];
    }
    mad3(region->center, best_height(heights, count, context->limits->tolerance), region->n);
    return greatest;
}

/* Gives a region the least ellipse of given variances along its axes around some samples (indices
 * into near; NULL: the first count), at the height where most of them are. */
static void surround(const psplat_fit_context *context, const double variance[2],
                     const uint32_t *some, size_t count, psplat_region *region) {
    for (int k = 0; k < 2; ++k) region->radius[k] = sqrt(variance[k]);
    double scale = settle(context, some, count, region);
    for (int k = 0; k < 2; ++k)
        region->radius[k] = sqrt(variance[k] * scale) + context->limits->margin;
}

/* Finds the ellipse of a plane's axes around some samples (indices into near; NULL: the first
 * count), at the height where most of them are, and the surface over it: the plane where that is
 * near enough. */
static void fit_ellipse(const psplat_fit_context *context, const psplat_plane *plane,
                        const uint32_t *some, size_t count, psplat_region *region) {
    const psplat_neighborhood *near = &context->scratch->near;
    /* A row of samples still gets some width. */
    double least = 0.01 * context->samples->spacing * context->samples->spacing;
    double variance[2] = {plane->variance[0] + least, plane->variance[1] + least};
    *region = (psplat_region){.line_count = 0};
    memcpy(region->u, plane->u, sizeof region->u);
    memcpy(region->v, plane->v, sizeof region->v);
    memcpy(region->n, plane->n, sizeof region->n);
    for (int k = 0; k < 3; ++k) region->center[k] = near->origin[k] + plane->mean[k];
    psplat_region flat = *region;
    if (!context->limits->planar) {
        for (int k = 0; k < 2; ++k) region->radius[k] = 2 * sqrt(variance[k]);
        if (psplat_fit_surface(near->samples, some, count, near->origin,
                               psplat_most_normal_pull(context), region)) {
            surround(context, variance, some, count, region);
            if (psplat_surface_sagitta(region) > PSPLAT_FLAT_PART * context->limits->tolerance)
                return;
        }
    }
    *region = flat;
    surround(context, variance, some, count, region);
}

/* ---- regions tried ------------------------------------------------------------------------- */

/* Evaluates a region by its samples alone. It becomes the candidate's where it covers more samples
 * than the candidate does. One that covers no more but keeps the limits counts as kept too: the
 * search may go on from there. */
static psplat_evaluation try_region(search *s, const psplat_region *region) {
    const psplat_demands demands = {.inside = s->site.metric.center,
                                    .least_area = HUGE_VAL,
                                    .more_than = s->candidate->covered_count,
                                    .skip = PSPLAT_SKIP_EXACTNESS};
    psplat_evaluation evaluation = psplat_evaluate(s->context, &s->site, region, &demands);
    if (!evaluation.status &&
        psplat_candidate_set(s->context, &s->site, &evaluation, 0, s->candidate))
        evaluation.status = PSPLAT_FIT_MEMORY;
    if (evaluation.status == PSPLAT_FIT_NO_GAIN) evaluation.status = PSPLAT_FIT_KEPT;
    if (evaluation.status == PSPLAT_FIT_MEMORY) s->failed = 1;
    s->nearest = s->context->scratch->near_count;
    return evaluation;
}

/* Tries the ellipse around the samples that are left after clip lines cut others off. */
static void try_covered(search *s, const psplat_evaluation *evaluation) {
    const psplat_neighborhood *near = &s->context->scratch->near;
    psplat_covariance covariance = {0};
    psplat_plane plane;
    psplat_region region;
    for (size_t i = 0; i < evaluation->count; ++i) {
        const psplat_near_sample *sample = &near->samples[evaluation->covered[i]];
        psplat_covariance_add(&covariance, sample->p, sample->n);
    }
    psplat_covariance_fit(&covariance, &plane);
    fit_ellipse(s->context, &plane, evaluation->covered, evaluation->count, &region);
    try_region(s, &region);
}

/* Tries the ellipse around the nearest count samples. */
static psplat_fit_status try_nearest(search *s, size_t count) {
    double tolerance = s->context->limits->tolerance;
    psplat_covariance covariance;
    psplat_plane plane;
    psplat_region region;
    psplat_neighborhood_covariance(&s->context->scratch->near, count, &covariance);
    psplat_covariance_fit(&covariance, &plane);
    if (s->context->limits->planar && plane.variance[2] > tolerance * tolerance)
        return PSPLAT_FIT_LEAVES_SURFACE;
    fit_ellipse(s->context, &plane, NULL, count, &region);
    psplat_evaluation evaluation = try_region(s, &region);
    if (evaluation.status) return evaluation.status;
    if (!evaluation.region.line_count)
        return (double)evaluation.count < least_covered_part * (double)count
                   ? PSPLAT_FIT_SAMPLES_LOST
                   : PSPLAT_FIT_KEPT;
    if (evaluation.count < count && evaluation.count >= LEAST_SAMPLES) try_covered(s, &evaluation);
    return PSPLAT_FIT_KEPT;
}

/* Tries the nearest samples within reach, at least a few; stores how many they are. */
static psplat_fit_status try_reach(search *s, double reach, size_t *count) {
    const psplat_neighborhood *near = &s->context->scratch->near;
    *count = 0;
    if (psplat_site_gather(s->context, &s->site, gathering_factor * reach)) {
        s->failed = 1;
        return PSPLAT_FIT_MEMORY;
    }
    *count = psplat_neighborhood_within(near, reach);
    if (*count < LEAST_SAMPLES) *count = near->count < LEAST_SAMPLES ? near->count : LEAST_SAMPLES;
    return *count ? try_nearest(s, *count) : PSPLAT_FIT_SAMPLES_LOST;
}

/* ---- the search ---------------------------------------------------------------------------- */

/* The reach that keeps the limits and the one that does not; 0 where none is known. */
typedef struct span {
    double kept, broken;
} span;

/* Tries a reach between those of a span, and makes it one of them. */
static void narrow_span(search *s, span *r, double reach) {
    size_t count;
    if (try_reach(s, reach, &count) == PSPLAT_FIT_KEPT)
        r->kept = reach;
    else
        r->broken = reach;
}

/* Raises the reach until the limits or the patch end; halves it where even the first is too much.
 */
static span raise_reach(search *s, double reach) {
    span r = {0, 0};
    size_t count = 0, before = 0;
    for (; !s->failed; reach *= reach_growth) {
        psplat_fit_status status = try_reach(s, reach, &count);
        if (status == PSPLAT_FIT_KEPT) r.kept = reach, r.broken = 0;
        if (status != PSPLAT_FIT_KEPT && r.broken == 0) r.broken = reach;
        /* Where four lines do not suffice, a larger region may still fit: its ellipse may leave the
         * end of the crease behind. */
        int stop = status != PSPLAT_FIT_KEPT && status != PSPLAT_FIT_TOO_MANY_LINES;
        if (stop || count == before || reach > 8 * r.broken + 8 * r.kept) break;
        before = count;
    }
    for (int step = 0; r.kept == 0 && step < HALVINGS && !s->failed; ++step)
        narrow_span(s, &r, r.broken / 2);
    return r;
}

/* Finds the greatest reach of a span that keeps the limits. */
static double bisect_reach(search *s, span r) {
    for (int step = 0; r.kept > 0 && r.broken > r.kept && step < BISECTIONS && !s->failed; ++step)
        narrow_span(s, &r, (r.kept + r.broken) / 2);
    return r.kept;
}

/* Stretches the metric along the direction of least curvature of the samples that the candidate
 * covers. Returns 0 where that would change little. */
static int adapt_metric(search *s) {
    const psplat_samples *samples = s->context->samples;
    const psplat_candidate *candidate = s->candidate;
    psplat_covariance covariance = {0};
    psplat_plane plane;
    double direction[2], curvature[2], u[3];
    if (candidate->covered_count < LEAST_CURVED) return 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        const size_t sample = candidate->covered[i];
        double p[3], n[3];
        sub3(p, samples->positions + 3 * sample, s->site.metric.center);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)samples->normals[3 * sample + k];
        psplat_covariance_add(&covariance, p, n);
    }
    psplat_covariance_fit(&covariance, &plane);
    if (!psplat_covariance_curvature(&covariance, &plane, direction, curvature)) return 0;
    double stretch = sqrt(curvature[0] / max2(curvature[1], 1e-12 * curvature[0]));
    if (stretch <= least_stretch) return 0;
    for (int k = 0; k < 3; ++k) u[k] = direction[0] * plane.u[k] + direction[1] * plane.v[k];
    psplat_site_turn(&s->site, plane.n, u, min2(stretch, greatest_stretch));
    return 1;
}

/* Fits the surface of a curved region anew to the samples that the last evaluation covered: that of
 * a larger one leaves a part of the samples by more than it has to. */
static void fit_again(const search *s, size_t covered, psplat_region *region) {
    const psplat_scratch *scratch = s->context->scratch;
    if (!psplat_region_is_curved(region) || covered < LEAST_SAMPLES) return;
    psplat_region fitted = *region;
    if (!psplat_fit_surface(scratch->near.samples, scratch->covered, covered, scratch->near.origin,
                            psplat_most_normal_pull(s->context), &fitted))
        return;
    settle(s->context, scratch->covered, covered, &fitted);
    *region = fitted;
}

/* Shrinks the candidate until all of its outline is near the mesh, and within the surroundings of
 * the region that was tried last. Returns 0 where that does not help. */
static int shrink_to_mesh(search *s) {
    for (int step = 0; step < SHRINKINGS && !s->failed; ++step) {
        const psplat_demands demands = {.nearest = s->nearest,
                                        .skip = PSPLAT_SKIP_LINES | PSPLAT_SKIP_COLORS |
                                                PSPLAT_SKIP_NORMALS};
        psplat_region region = s->candidate->region;
        psplat_evaluation evaluation = psplat_evaluate(s->context, &s->site, &region, &demands);
        if (evaluation.status == PSPLAT_FIT_MEMORY) s->failed = 1;
        if (evaluation.status == PSPLAT_FIT_KEPT) return 1;
        for (int k = 0; k < 2; ++k) region.radius[k] *= shrink_factor;
        fit_again(s, evaluation.count, &region);
        s->candidate->covered_count = 0;
        try_region(s, &region);
        if (!s->candidate->covered_count) return 0;
    }
    return 0;
}

/* Stores a disc around the seed, in the plane of its triangle. */
static void disc_around_seed(const search *s, double radius, psplat_region *disc) {
    *disc = (psplat_region){.radius = {radius, radius}};
    memcpy(disc->center, s->site.metric.center, sizeof disc->center);
    memcpy(disc->n, s->context->surface->face_normals + 3 * (size_t)s->site.triangle,
           sizeof disc->n);
    perpendicular3(disc->u, disc->n);
    cross3(disc->v, disc->n, disc->u);
}

/* Makes the candidate the largest disc in the plane of the seed's own triangle, of those tried,
 * that keeps the limits. Where the surface bends much between samples, these cannot tell how. */
static int fit_disc(search *s) {
    const psplat_demands demands = {.inside = s->site.metric.center};
    double radius = first_disc_spacings * s->context->samples->spacing;
    for (int step = 0; step < DISCS && !s->failed; ++step, radius *= disc_shrink_factor) {
        psplat_region disc;
        disc_around_seed(s, radius, &disc);
        psplat_evaluation e = psplat_evaluate(s->context, &s->site, &disc, &demands);
        if (!e.status && psplat_candidate_set(s->context, &s->site, &e, 0, s->candidate))
            e.status = PSPLAT_FIT_MEMORY;
        s->failed |= e.status == PSPLAT_FIT_MEMORY;
        if (!e.status) return 1;
    }
    return 0;
}

/* As the last resort, makes the candidate a small disc that covers the seed alone. Its deviation is
 * set to its radius, since none was measured. */
static void make_disc(search *s) {
    const double *center = s->site.metric.center;
    double radius = disc_radius_tolerances * s->context->limits->tolerance;
    psplat_region disc;
    disc_around_seed(s, radius, &disc);
    psplat_evaluation one = psplat_evaluate_single_sample(s->context, &s->site, &disc, center,
                                                          s->site.seed, PSPLAT_SKIP_EXACTNESS);
    one.deviation = radius;
    s->failed = one.status || psplat_candidate_set(s->context, &s->site, &one, 0, s->candidate);
}

/* Makes the candidate one that is near the mesh. One that has to shrink far loses its seed or fits
 * no better; then what half of its reach gives is tried. Returns 0 where nothing is near enough. */
static int settle_on_mesh(search *s, double reach) {
    size_t count;
    for (int step = 0; step <= RETREATS && !s->failed; ++step, reach /= 2) {
        if (step) {
            s->candidate->covered_count = 0;
            try_reach(s, reach, &count);
            if (count <= LEAST_SAMPLES) break;
        }
        if (s->candidate->covered_count && shrink_to_mesh(s)) return 1;
    }
    return 0;
}

/* Grows the candidate in a round metric, and then in that of its curvature. */
static void grow(search *s) {
    const psplat_ellipse_growth growth = {.most = PSPLAT_GREATEST_NEW_GROWTH,
                                          .steps = PSPLAT_NEW_GROWTH_STEPS};
    double reach =
        bisect_reach(s, raise_reach(s, first_reach_spacings * s->context->samples->spacing));
    if (s->candidate->covered_count && !s->failed && adapt_metric(s)) {
        double adapted = bisect_reach(s, raise_reach(s, reach));
        if (adapted > 0) reach = adapted;
    }
    int settled = (reach > 0 && settle_on_mesh(s, reach)) || (!s->failed && fit_disc(s));
    if (s->failed) return;
    if (settled)
        s->failed = psplat_grow_ellipse_at(s->context, &s->site, &growth, s->candidate) != 0;
    else
        make_disc(s);
}

/* Proves what has grown as a draft. Where it leaves the surface and does not shrink enough, a disc
 * takes its place, which is proven too. */
static void prove(search *s, const psplat_fit_context *context) {
    int proven = 1;
    if (s->failed || !context->limits->proven) return;
    s->failed = psplat_prove_candidate(context, s->site.seed, s->candidate, &proven) != 0;
    if (proven || s->failed) return;
    s->context = context;
    if (!fit_disc(s) && !s->failed) make_disc(s);
}

psplat_result psplat_candidate_grow(const psplat_fit_context *context, uint32_t seed,
                                    psplat_candidate *candidate) {
    const psplat_samples *samples = context->samples;
    psplat_limits limits;
    const psplat_fit_context draft = psplat_fit_draft(context, &limits);
    search s = {.context = &draft,
                .site = {.seed = seed, .triangle = samples->triangles[seed]},
                .candidate = candidate};
    const double *n = context->surface->face_normals + 3 * (size_t)s.site.triangle;
    double u[3];
    memcpy(s.site.metric.center, samples->positions + 3 * (size_t)seed,
           sizeof s.site.metric.center);
    perpendicular3(u, n);
    psplat_site_turn(&s.site, n, u, 1);
    *candidate = (psplat_candidate){0};
    grow(&s);
    prove(&s, context);
    if (context->limits->precision) candidate->needed = seed + 1;
    if (!s.failed) return PSPLAT_OK;
    psplat_candidate_free(candidate);
    return PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_candidate_cover(const psplat_fit_context *context,
                                     psplat_candidate *candidate) {
    const psplat_region *region = &candidate->region;
    const psplat_demands demands = {
        .reach = 1.01 * (psplat_region_reach(region) + context->limits->tolerance),
        .skip =
            PSPLAT_SKIP_LINES | PSPLAT_SKIP_COLORS | PSPLAT_SKIP_NEARNESS | PSPLAT_SKIP_NORMALS};
    psplat_site site = psplat_site_of(region, candidate->triangle);
    psplat_evaluation evaluation = psplat_evaluate(context, &site, region, &demands);
    if (evaluation.status == PSPLAT_FIT_MEMORY) return PSPLAT_ERROR_MEMORY;
    candidate->covered_count = 0; /* A disc of the last resort may cover nothing by this measure. */
    return evaluation.count ? psplat_candidate_record(context, &evaluation, candidate) : PSPLAT_OK;
}
