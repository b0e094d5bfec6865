/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * candidate.c - the largest splat around a sample that keeps the limits (after Wu, Kobbelt 2004).
 *
 * The set of samples grows, not the ellipse: each trial takes the nearest samples, whose covariance
 * gives plane and axes at once, and asks what the ellipse around them covers. Near is first
 * Euclidean, then by the metric of the curvature found, so that splats stretch along the direction
 * in which the surface is straight. What a splat covers and where it leaves the surface are two
 * questions: it may reach beyond what it covers, as long as all of it stays near the surface.
 */
#include "trial.h"

#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Aspect ratio up to which the curvature's metric stretches. */
static const double greatest_stretch = 8;
/* Seed's surroundings known beyond the samples of a trial, in reaches. */
static const double gathered_part = 1.3;
/* Part of the samples of a trial that must come to be covered. */
static const double least_covered = 0.7;
/* The first reach, in spacings, and the steps in which it grows. */
static const double first_reach = 5;
static const double growing = 1.35;
/* How far an ellipse widens at most after its samples were found, and the steps in which it narrows
 * where its outline turns out to leave the surface. */
static const double greatest_widening = 1.4;
static const double narrowing = 0.92;

enum { BINS = 32 }; /* of heights */
enum { BISECTIONS = 4, STEPS_DOWN = 8, WIDENINGS = 3, NARROWINGS = 12, LEAST_PREFIX = 3 };

typedef enum trial_result { TRIAL_KEPT, TRIAL_TOO_FAR, TRIAL_TOO_MANY_LINES } trial_result;

void psplat_candidate_free(psplat_candidate *candidate) {
    free(candidate->covered);
    *candidate = (psplat_candidate){0};
}

/* ---- fitting ------------------------------------------------------------------------------- */

/* The height about which most of count heights lie within the tolerance; where all of them do, the
 * middle of their range. */
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

/* The ellipse of a plane's axes around chosen samples (indices into near; NULL: the first count),
 * at the height where most of them are. */
static void fit_ellipse(const psplat_seedling *s, const psplat_plane *plane, const uint32_t *chosen,
                        size_t count, psplat_region *region) {
    const psplat_near_sample *near = s->growth->near.samples;
    double scale = 0, *heights = &s->growth->plane[0][0];
    /* A row of samples still gets some width. */
    double least = 0.01 * s->samples->spacing * s->samples->spacing;
    double variance[2] = {plane->variance[0] + least, plane->variance[1] + least};
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, near[chosen ? chosen[i] : i].p, plane->mean);
        double x = dot3(d, plane->u), y = dot3(d, plane->v);
        scale = max2(scale, x * x / variance[0] + y * y / variance[1]);
        heights[i] = dot3(d, plane->n);
    }
    memcpy(region->u, plane->u, sizeof region->u);
    memcpy(region->v, plane->v, sizeof region->v);
    memcpy(region->n, plane->n, sizeof region->n);
    for (int k = 0; k < 3; ++k) region->center[k] = s->growth->near.origin[k] + plane->mean[k];
    mad3(region->center, best_height(heights, count, s->limits->tolerance), plane->n);
    for (int k = 0; k < 2; ++k) region->radius[k] = sqrt(variance[k] * scale) + s->limits->margin;
    region->line_count = 0;
}

/* ---- trials -------------------------------------------------------------------------------- */

/* Gives a region its lines and asks what it covers; where it keeps the limits and covers more than
 * the candidate does, it becomes the candidate's. Stores how many samples it covers. */
static trial_result judge(psplat_seedling *s, psplat_region *region, psplat_candidate *candidate,
                          size_t *covered) {
    psplat_growth *g = s->growth;
    double seed[3], height, field[5];
    *covered = 0;
    if (!psplat_trial_surround(s, region)) return TRIAL_TOO_FAR;
    size_t segments = psplat_trial_segments(s, region, &height);
    psplat_region_local(region, s->metric.center, seed);
    if (height > s->limits->crease_tolerance) return TRIAL_TOO_FAR;
    if (!psplat_clip_choose(region, g->segments, segments, seed, s->limits->crease_slack))
        return TRIAL_TOO_MANY_LINES;
    *covered = psplat_trial_cover(s, region);
    if (!*covered) return TRIAL_TOO_FAR;
    int better = *covered > candidate->covered_count;
    if (!psplat_trial_tint(s, *covered)) return TRIAL_TOO_FAR;
    if (better && !psplat_trial_outline_near(s, region)) return TRIAL_TOO_FAR;
    if (!better && !(s->limits->normal_tolerance > 0)) return TRIAL_KEPT;
    if (!psplat_trial_field(s, region, *covered, field)) return TRIAL_TOO_FAR;
    if (!better) return TRIAL_KEPT;
    psplat_trial_adopt(s, region, field, *covered, candidate);
    return TRIAL_KEPT;
}

/* One trial with the nearest count samples. What lines leave of them is fitted once more. */
static trial_result try_prefix(psplat_seedling *s, size_t count, psplat_candidate *candidate) {
    psplat_growth *g = s->growth;
    psplat_covariance covariance;
    psplat_plane plane;
    psplat_region region;
    size_t covered;
    psplat_neighborhood_covariance(&g->near, count, &covariance);
    psplat_covariance_fit(&covariance, &plane);
    double tolerance = s->limits->tolerance;
    if (plane.variance[2] > tolerance * tolerance) return TRIAL_TOO_FAR;
    fit_ellipse(s, &plane, NULL, count, &region);
    trial_result result = judge(s, &region, candidate, &covered);
    if (!result && !region.line_count && (double)covered < least_covered * (double)count)
        return TRIAL_TOO_FAR;
    if (result || !region.line_count || covered >= count || covered < LEAST_PREFIX) return result;
    covariance = (psplat_covariance){0};
    for (size_t i = 0; i < covered; ++i)
        psplat_covariance_add(&covariance, g->near.samples[g->chosen[i]].p,
                              g->near.samples[g->chosen[i]].n);
    psplat_covariance_fit(&covariance, &plane);
    fit_ellipse(s, &plane, g->chosen, covered, &region);
    judge(s, &region, candidate, &covered);
    return TRIAL_KEPT;
}

/* The nearest samples within reach; at least a few. */
static trial_result try_reach(psplat_seedling *s, double reach, psplat_candidate *candidate,
                              size_t *count) {
    *count = 0;
    if (!psplat_trial_gather(s, gathered_part * reach)) return TRIAL_TOO_FAR;
    *count = psplat_neighborhood_within(&s->growth->near, reach);
    if (*count < LEAST_PREFIX)
        *count = s->growth->near.count < LEAST_PREFIX ? s->growth->near.count : LEAST_PREFIX;
    return *count ? try_prefix(s, *count, candidate) : TRIAL_TOO_FAR;
}

/* Reaches that keep the limits and that do not; 0: none known. */
typedef struct span {
    double kept, broken;
} span;

/* Raises the reach until the limits or the patch end; halves it where even the first is too much.
 */
static span raise_reach(psplat_seedling *s, double reach, psplat_candidate *candidate) {
    span r = {0, 0};
    size_t count = 0, before = 0;
    for (; !s->failed; reach *= growing) {
        trial_result result = try_reach(s, reach, candidate, &count);
        if (result == TRIAL_KEPT) r.kept = reach, r.broken = 0;
        if (result != TRIAL_KEPT && r.broken == 0) r.broken = reach;
        /* Lines that do not suffice may yet: a larger region may leave the crease's end behind. */
        if (result == TRIAL_TOO_FAR || count == before || reach > 8 * r.broken + 8 * r.kept) break;
        before = count;
    }
    for (int step = 0; r.kept == 0 && step < STEPS_DOWN && !s->failed; ++step) {
        double half = r.broken / 2;
        if (try_reach(s, half, candidate, &count) == TRIAL_KEPT)
            r.kept = half;
        else
            r.broken = half;
    }
    return r;
}

static double bisect_reach(psplat_seedling *s, span r, psplat_candidate *candidate) {
    size_t count;
    for (int step = 0; r.kept > 0 && r.broken > r.kept && step < BISECTIONS && !s->failed; ++step) {
        double middle = (r.kept + r.broken) / 2;
        if (try_reach(s, middle, candidate, &count) == TRIAL_KEPT)
            r.kept = middle;
        else
            r.broken = middle;
    }
    return r.kept;
}

/* Turns the metric to the curvature of the samples that the candidate covers. Returns 0 where that
 * changes little. */
static int adapt_metric(psplat_seedling *s, const psplat_candidate *candidate) {
    psplat_covariance covariance = {0};
    psplat_plane plane;
    double direction[2], curvature[2], u[3];
    if (candidate->covered_count < 6) return 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        const size_t sample = candidate->covered[i];
        double p[3], n[3];
        sub3(p, s->samples->positions + 3 * sample, s->metric.center);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)s->samples->normals[3 * sample + k];
        psplat_covariance_add(&covariance, p, n);
    }
    psplat_covariance_fit(&covariance, &plane);
    if (!psplat_covariance_curvature(&covariance, &plane, direction, curvature)) return 0;
    double stretch = sqrt(curvature[0] / max2(curvature[1], 1e-12 * curvature[0]));
    if (stretch <= 1.25) return 0;
    for (int k = 0; k < 3; ++k) u[k] = direction[0] * plane.u[k] + direction[1] * plane.v[k];
    psplat_trial_turn(s, plane.n, u, min2(stretch, greatest_stretch));
    return 1;
}

/* Narrows a candidate whose outline leaves the mesh between samples. Returns 0 where that does not
 * help. */
static int keep_near(psplat_seedling *s, psplat_candidate *candidate) {
    for (int step = 0; step < NARROWINGS && !s->failed; ++step) {
        size_t covered;
        if (psplat_trial_near_mesh(s, &candidate->region)) return 1;
        psplat_region region = candidate->region;
        for (int k = 0; k < 2; ++k) region.radius[k] *= narrowing;
        region.line_count = 0;
        candidate->covered_count = 0;
        judge(s, &region, candidate, &covered);
        if (!candidate->covered_count) return 0;
    }
    return 0;
}

/* The last resort: a disc on the seed's own triangle that covers the seed alone. */
static void force(psplat_seedling *s, double radius, psplat_candidate *candidate) {
    psplat_growth *g = s->growth;
    psplat_region region = {.radius = {radius, radius}};
    double field[5], height, seed[3] = {0, 0, 0};
    memcpy(region.center, s->metric.center, sizeof region.center);
    memcpy(region.n, s->surface->face_normals + 3 * (size_t)s->triangle, sizeof region.n);
    perpendicular3(region.u, region.n);
    cross3(region.v, region.n, region.u);
    if (!psplat_trial_gather(s, 2 * radius)) return;
    size_t segments = psplat_trial_segments(s, &region, &height);
    psplat_clip_choose(&region, g->segments, segments, seed, s->limits->crease_slack);
    g->chosen[0] = 0;
    while (g->near.samples[g->chosen[0]].index != s->seed) ++g->chosen[0];
    g->local[0][0] = g->local[0][1] = 0;
    psplat_trial_field(s, &region, 1, field);
    g->uvh[g->chosen[0]][2] = radius;
    psplat_trial_adopt(s, &region, field, 1, candidate);
}

psplat_result psplat_candidate_grow(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, uint32_t seed,
                                    psplat_growth *growth, psplat_candidate *candidate) {
    psplat_seedling s = {.surface = surface,
                         .samples = samples,
                         .limits = limits,
                         .growth = growth,
                         .seed = seed,
                         .triangle = samples->triangles[seed]};
    const double *n = surface->face_normals + 3 * (size_t)s.triangle;
    double u[3];
    memcpy(s.metric.center, samples->positions + 3 * (size_t)seed, sizeof s.metric.center);
    perpendicular3(u, n);
    psplat_trial_turn(&s, n, u, 1);
    *candidate = (psplat_candidate){0};
    span first = raise_reach(&s, first_reach * samples->spacing, candidate);
    double reach = bisect_reach(&s, first, candidate);
    if (candidate->covered_count && !s.failed && adapt_metric(&s, candidate))
        bisect_reach(&s, raise_reach(&s, reach, candidate), candidate);
    if (candidate->covered_count && !s.failed) {
        if (!keep_near(&s, candidate))
            candidate->covered_count = 0;
        else
            psplat_trial_widen(&s, candidate, greatest_widening, WIDENINGS);
    }
    if (!candidate->covered_count && !s.failed) force(&s, samples->spacing / 16, candidate);
    if (!s.failed) return PSPLAT_OK;
    psplat_candidate_free(candidate);
    return PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_candidate_cover(const psplat_surface *surface, const psplat_samples *samples,
                                     const psplat_limits *limits, psplat_growth *growth,
                                     psplat_candidate *candidate) {
    const psplat_region *region = &candidate->region;
    psplat_seedling s =
        psplat_trial_at(surface, samples, limits, growth, region, candidate->triangle);
    if (!psplat_trial_gather(&s, 1.01 * (region->radius[0] + limits->tolerance)))
        return PSPLAT_ERROR_MEMORY;
    s.relevant = growth->near.count;
    size_t count = psplat_trial_cover(&s, region);
    candidate->covered_count = 0; /* a forced candidate may cover nothing by this measure */
    if (!count) return PSPLAT_OK;
    uint32_t *covered = realloc(candidate->covered, count * sizeof *covered);
    if (!covered) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) covered[i] = growth->near.samples[growth->chosen[i]].index;
    candidate->covered = covered;
    candidate->covered_count = count;
    return PSPLAT_OK;
}
