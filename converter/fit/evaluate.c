/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate.c - the evaluation of a region as a splat: its clip lines, the samples that it covers,
 * and whether it keeps the limits.
 */
#include "fit/evaluate.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/neighborhood.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/clip_lines.h"
#include "fit/crease_segments.h"
#include "fit/fit_context.h"
#include "fit/surface_fit.h"
#include "mesh/mesh.h"
#include "splats/quantize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The least factor by which the reach grows when more samples are gathered around a site, so that
 * this is seldom needed. Chosen by hand. */
static const double least_gathering_growth = 1.6;
/* How far behind a line (of the unit ellipse) a sample still counts as inside, to allow for
 * rounding.
 */
static const double line_slack = 1e-7;

/* The part of the tolerance by which a corner is farther from the mesh where no rounding matters.
 */
static const double certain_excess = 1e-3;

/* The samples that are turned into the parameters of a region in one go. */
enum { LOCAL_BLOCK = 64 };

/* The most steps of the grid by which a rounded line is moved out to keep a point. A step is a
 * twentieth of the tolerance at most, and the slack of creases has room for some. */
enum { MOST_RAISING_STEPS = 3 };

/* ---- sites --------------------------------------------------------------------------------- */

psplat_result psplat_site_gather(const psplat_fit_context *context, psplat_site *site,
                                 double reach) {
    psplat_scratch *scratch = context->scratch;
    if (scratch->site != site) site->gathered = 0; /* Another site has used the scratch since. */
    if (reach <= site->gathered || (site->gathered > 0 && scratch->near.whole)) return PSPLAT_OK;
    if (site->gathered > 0) reach = max2(reach, least_gathering_growth * site->gathered);
    site->gathered = 0;
    if (!psplat_neighborhood_gather(&scratch->near, context->surface, context->samples,
                                    &site->metric, site->triangle, reach, 0) ||
        psplat_scratch_reserve(scratch))
        return PSPLAT_ERROR_MEMORY;
    scratch->site = site;
    site->gathered = reach;
    return PSPLAT_OK;
}

void psplat_site_turn(psplat_site *site, const double n[3], const double u[3], double stretch) {
    psplat_metric *metric = &site->metric;
    double v[3];
    cross3(v, n, u);
    memcpy(metric->rows[0], u, sizeof metric->rows[0]);
    memcpy(metric->rows[2], n, sizeof metric->rows[2]);
    for (int k = 0; k < 3; ++k) metric->rows[1][k] = v[k] / stretch;
    site->gathered = 0;
}

psplat_site psplat_site_of(const psplat_region *region, uint32_t triangle) {
    psplat_site site = {.seed = PSPLAT_NONE, .triangle = triangle};
    memcpy(site.metric.center, region->center, sizeof site.metric.center);
    psplat_site_turn(&site, region->n, region->u, 1);
    return site;
}

/* Returns how far a region's surface reaches from the metric's centre, in the metric. */
static double region_reach(const psplat_metric *metric, const psplat_region *region) {
    double corners[PSPLAT_OUTLINE][2], farthest = 0;
    size_t count = psplat_region_polygon(region, 0, corners, PSPLAT_OUTLINE);
    for (size_t i = 0; i < count; ++i) {
        double p[3], w[3];
        psplat_region_point(region, corners[i], p);
        psplat_metric_coordinates(metric, p, w);
        farthest = max2(farthest, length3(w));
    }
    return farthest;
}

/* Gathers the surroundings of a region, and counts the samples that lie in them. */
static psplat_result gather_surroundings(const psplat_fit_context *context, psplat_site *site,
                                         const psplat_demands *demands,
                                         const psplat_region *region) {
    psplat_scratch *scratch = context->scratch;
    double reach = demands->reach;
    if (demands->nearest && scratch->site == site && site->gathered > 0) {
        scratch->near_count = demands->nearest;
        if (scratch->near_count > scratch->near.count) scratch->near_count = scratch->near.count;
        return PSPLAT_OK;
    }
    if (!(reach > 0))
        reach =
            region_reach(&site->metric, region) + PSPLAT_GREATEST_GAP * context->samples->spacing;
    if (psplat_site_gather(context, site, reach)) return PSPLAT_ERROR_MEMORY;
    scratch->near_count = psplat_neighborhood_within(&scratch->near, reach);
    return PSPLAT_OK;
}

/* ---- lines --------------------------------------------------------------------------------- */

static double segment_height(const psplat_segment *segment) {
    return max2(fabs(segment->a[2]), fabs(segment->b[2]));
}

/* Finds the creases inside the ellipse, on the side of the surface that the splat lies on, into
 * scratch->segments, and how far they leave the plane. Returns their number. In a region no larger
 * than the tolerance no crease lies deep. There, those that leave the plane are left out: they
 * belong to the other edge of a low step, say. */
static size_t find_segments(const psplat_fit_context *context, const psplat_region *region,
                            double *height) {
    psplat_scratch *scratch = context->scratch;
    const psplat_neighborhood *near = &scratch->near;
    const psplat_limits *limits = context->limits;
    int is_small = max2(region->radius[0], region->radius[1]) <= limits->tolerance;
    /* Creases that are farther from the plane belong to another part of a bent surface. */
    size_t count = psplat_segments_find_near(context->surface, near, region, 2 * limits->tolerance,
                                             scratch->segments);
    size_t kept = 0;
    *height = 0;
    for (size_t i = 0; i < count; ++i) {
        double leaves = segment_height(&scratch->segments[i]);
        if (is_small && leaves > limits->crease_tolerance) continue;
        scratch->segments[kept++] = scratch->segments[i];
        *height = max2(*height, leaves);
    }
    return kept;
}

/* Rounds line i of a region, so that it still keeps its point inside (u, v): rounding its direction
 * may have cut that off. */
static void round_line(const psplat_precision *precision, const double inside[2], uint32_t i,
                       psplat_region *region) {
    const psplat_precision at = psplat_precision_at(precision, region->radius);
    psplat_quantize_line(&at, region->lines[i], &region->bends[i]);
    double lack = -psplat_region_line_value(region, i, inside) / at.line_step;
    if (lack > 0 && lack <= MOST_RAISING_STEPS) region->lines[i][2] += ceil(lack) * at.line_step;
}

/* Gives a region clip lines that cut the segments found away and keep its point inside (u, v).
 * Returns 0 where that takes too many. */
static int choose_lines(const psplat_fit_context *context, size_t segments, const double inside[2],
                        int exact, psplat_region *region) {
    const psplat_limits *limits = context->limits;
    int chosen = psplat_clip_choose(region, context->scratch->segments, segments, inside,
                                    limits->crease_slack, !limits->planar);
    for (uint32_t i = 0; exact && limits->precision && i < region->line_count; ++i)
        round_line(limits->precision, inside, i, region);
    return chosen;
}

/* ---- coverage ------------------------------------------------------------------------------ */

/* Returns whether a sample's normal faces the way of the region's surface at (u, v). */
static int faces(const psplat_region *region, int curved, const double uv[2], const double n[3]) {
    double slope[2], along = dot3(n, region->n);
    if (along < PSPLAT_LEAST_COVERED_COSINE) return 0;
    if (!curved) return 1;
    psplat_region_slope(region, uv, slope);
    along -= slope[0] * dot3(n, region->u) + slope[1] * dot3(n, region->v);
    return along > 0 && along * along >= PSPLAT_LEAST_SURFACE_COSINE * PSPLAT_LEAST_SURFACE_COSINE *
                                             (1 + slope[0] * slope[0] + slope[1] * slope[1]);
}

/* Samples in a region's parameters, and how far they are above its surface. */
typedef struct local_block {
    double u[LOCAL_BLOCK], v[LOCAL_BLOCK], h[LOCAL_BLOCK];
} local_block;

/* Stores some samples as psplat_region_local would, with positions by axis, relative to the
 * neighbourhood's origin as the centre is. Compilers turn these loops into ones over several
 * samples at once. */
static void find_local(const psplat_region *region, int curved, const double center[3],
                       const double *x, const double *y, const double *z, size_t count,
                       local_block *restrict b) {
    const psplat_region r = *region;
    for (size_t i = 0; i < count; ++i) {
        const double d[3] = {x[i] - center[0], y[i] - center[1], z[i] - center[2]};
        b->u[i] = dot3(d, r.u) / r.radius[0];
        b->v[i] = dot3(d, r.v) / r.radius[1];
        b->h[i] = dot3(d, r.n);
    }
    for (size_t i = 0; curved && i < count; ++i) {
        const double uv[2] = {b->u[i], b->v[i]};
        double slope[2];
        psplat_region_slope(&r, uv, slope);
        b->h[i] = (b->h[i] - psplat_region_height(&r, uv)) /
                  sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
    }
}

/* Returns by which factors parameters grow where the margin is taken off the radii. */
static void margin_factors(const psplat_limits *limits, const psplat_region *region,
                           double inner[2]) {
    for (int k = 0; k < 2; ++k)
        inner[k] =
            region->radius[k] / (region->radius[k] - min2(limits->margin, 0.5 * region->radius[k]));
}

/* Finds the samples that a region covers, into scratch->covered and scratch->uv, and the parameters
 * of all that lie in its surroundings. Returns their number; 0 where the seed is not among them. */
static size_t cover(const psplat_fit_context *context, const psplat_region *region, uint32_t seed) {
    psplat_scratch *s = context->scratch;
    double inner[2], center[3], tolerance = context->limits->tolerance;
    size_t count = 0;
    int curved = psplat_region_is_curved(region), seed_met = seed == PSPLAT_NONE;
    local_block b;
    margin_factors(context->limits, region, inner);
    sub3(center, region->center, s->near.origin);
    for (size_t i = 0; i < s->near_count; ++i) {
        size_t k = i % LOCAL_BLOCK, left = s->near_count - i;
        if (!k)
            find_local(region, curved, center, s->near.along[0] + i, s->near.along[1] + i,
                       s->near.along[2] + i, left < LOCAL_BLOCK ? left : LOCAL_BLOCK, &b);
        double *uvh = s->uvh[i], x = b.u[k] * inner[0], y = b.v[k] * inner[1];
        uvh[0] = b.u[k], uvh[1] = b.v[k], uvh[2] = b.h[k];
        if ((fabs(uvh[2]) > tolerance) | (x * x + y * y > 1)) continue;
        if (!psplat_region_contains(region, uvh, 1, line_slack)) continue;
        if (!faces(region, curved, uvh, s->near.samples[i].n)) continue;
        seed_met |= s->near.samples[i].index == seed;
        memcpy(s->uv[count], uvh, sizeof s->uv[count]);
        s->covered[count++] = (uint32_t)i;
    }
    return seed_met ? count : 0;
}

/* Returns whether all samples that a candidate covers lie inside a region, near its surface, and
 * face its way. */
static int holds(const psplat_fit_context *context, const psplat_region *region,
                 const psplat_candidate *held) {
    int curved = psplat_region_is_curved(region);
    for (size_t i = held->covered_count;
         i-- > 0;) { /* The outer ones, which come last, fail first. */
        size_t at = 3 * (size_t)held->covered[i];
        double uvh[3], n[3];
        psplat_region_local(region, context->samples->positions + at, uvh);
        for (size_t k = 0; k < 3; ++k) n[k] = (double)context->samples->normals[at + k];
        if (fabs(uvh[2]) > context->limits->tolerance ||
            !psplat_region_contains(region, uvh, 1, line_slack) || !faces(region, curved, uvh, n))
            return 0;
    }
    return 1;
}

static double greatest_height(const psplat_scratch *scratch, size_t count) {
    double greatest = 0;
    for (size_t i = 0; i < count; ++i)
        greatest = max2(greatest, fabs(scratch->uvh[scratch->covered[i]][2]));
    return greatest;
}

/* ---- evaluation ---------------------------------------------------------------------------- */

/* Gathers the surroundings of a region and gives it its lines, where they are wanted. */
static psplat_fit_status find_lines(const psplat_fit_context *context, psplat_site *site,
                                    const psplat_demands *demands, psplat_region *region) {
    double inside[3], height;
    int exact = !(demands->skip & PSPLAT_SKIP_EXACTNESS), given = demands->skip & PSPLAT_SKIP_LINES;
    if (!given) region->line_count = 0;
    if (gather_surroundings(context, site, demands, region)) return PSPLAT_FIT_MEMORY;
    if (given) return PSPLAT_FIT_KEPT;
    psplat_region_local(region, demands->inside, inside);
    size_t segments = find_segments(context, region, &height);
    if (height > context->limits->crease_tolerance) return PSPLAT_FIT_CREASE_TOO_FAR;
    return choose_lines(context, segments, inside, exact, region) ? PSPLAT_FIT_KEPT
                                                                  : PSPLAT_FIT_TOO_MANY_LINES;
}

static int is_large(const psplat_demands *demands, const psplat_region *region) {
    if (!(demands->least_area > 0)) return 1;
    return demands->least_area < HUGE_VAL && psplat_region_area(region) >= demands->least_area;
}

/* Checks the limits that are not skipped. A region that does not gain will not be used, so it need
 * not be near the surface, and its normals matter only where a limit bounds them. */
static psplat_fit_status check_limits(const psplat_fit_context *context, int skip, int gains,
                                      psplat_evaluation *e) {
    psplat_fit_status status = PSPLAT_FIT_KEPT;
    if (!(skip & PSPLAT_SKIP_COLORS)) status = psplat_evaluate_colors(context, e->count);
    if (!status && !(skip & PSPLAT_SKIP_COLORS))
        status = psplat_evaluate_texcoords(context, &e->region, e->count);
    if (!status && gains && !(skip & PSPLAT_SKIP_NEARNESS))
        status = psplat_evaluate_nearness(context, &e->region, !(skip & PSPLAT_SKIP_EXACTNESS));
    if (!status && (gains || context->limits->normal_tolerance > 0) &&
        !(skip & PSPLAT_SKIP_NORMALS))
        status = psplat_evaluate_normals(context, e);
    return status || gains ? status : PSPLAT_FIT_NO_GAIN;
}

/* Returns whether a corner of a region is so far from the mesh that the check of the distance bound
 * is certain to fail, whatever samples and triangles that asks first: all of these lie on the mesh
 * but for rounding, and what is near its proxy is near the mesh. Stores that in *far. */
static psplat_result find_far_corner(const psplat_limits *limits, const psplat_region *region,
                                     int *far) {
    double polygon[PSPLAT_OUTLINE][2], point[3];
    double certain = (1 + certain_excess) * limits->tolerance;
    uint32_t guess = PSPLAT_NONE;
    *far = 0;
    size_t count = limits->distance ? psplat_region_polygon(region, 1, polygon, PSPLAT_OUTLINE) : 0;
    for (size_t i = 0; i < count && !*far; ++i) {
        int within;
        psplat_region_point(region, polygon[i], point);
        psplat_result result =
            psplat_distance_is_within(limits->distance, point, certain, &guess, &within);
        if (result) return result;
        *far = !within;
    }
    return PSPLAT_OK;
}

static psplat_fit_status evaluate(const psplat_fit_context *context, psplat_site *site,
                                  const psplat_demands *demands, psplat_evaluation *e) {
    if (!(psplat_surface_slope_bound(&e->region) <= PSPLAT_GREATEST_SURFACE_SLOPE)) /* or NaN */
        return PSPLAT_FIT_LEAVES_SURFACE;
    psplat_fit_status status = find_lines(context, site, demands, &e->region);
    if (status) return status;
    int large = is_large(demands, &e->region);
    if (!large && demands->more_than == SIZE_MAX) return PSPLAT_FIT_NO_GAIN;
    if (demands->held && !holds(context, &e->region, demands->held)) return PSPLAT_FIT_SAMPLES_LOST;
    if (demands->any_reason) {
        int far;
        if (find_far_corner(context->limits, &e->region, &far)) return PSPLAT_FIT_MEMORY;
        if (far) return PSPLAT_FIT_LEAVES_SURFACE;
    }
    e->count = cover(context, &e->region, site->seed);
    if (!e->count) return PSPLAT_FIT_SAMPLES_LOST;
    return check_limits(context, demands->skip, large || e->count > demands->more_than, e);
}

psplat_evaluation psplat_evaluate(const psplat_fit_context *context, psplat_site *site,
                                  const psplat_region *region, const psplat_demands *demands) {
    psplat_evaluation e = {.region = *region};
    e.status = evaluate(context, site, demands, &e);
    e.covered = context->scratch->covered; /* The array may have moved. */
    if (e.status == PSPLAT_FIT_KEPT) e.deviation = greatest_height(context->scratch, e.count);
    return e;
}

psplat_evaluation psplat_evaluate_single_sample(const psplat_fit_context *context,
                                                psplat_site *site, const psplat_region *region,
                                                const double point[3], uint32_t sample, int skip) {
    psplat_scratch *s = context->scratch;
    psplat_evaluation e = {.region = *region};
    double uvh[3], height;
    psplat_region_local(region, point, uvh);
    e.region.line_count = 0;
    if (psplat_site_gather(context, site, 2 * region->radius[0] + fabs(uvh[2]))) {
        e.status = PSPLAT_FIT_MEMORY;
        return e;
    }
    size_t segments = find_segments(context, &e.region, &height);
    choose_lines(context, segments, uvh, !(skip & PSPLAT_SKIP_EXACTNESS), &e.region);
    for (uint32_t i = 0; i < s->near.count && !e.count; ++i)
        if (s->near.samples[i].index == sample) s->covered[e.count++] = i;
    e.covered = s->covered;
    if (!e.count) return e;
    memcpy(s->uv[0], uvh, sizeof s->uv[0]);
    e.deviation = fabs(uvh[2]);
    psplat_evaluate_normals(context, &e); /* It is the best field, whatever its error. */
    return e;
}

/* ---- candidates of evaluations ------------------------------------------------------------- */

psplat_result psplat_candidate_record(const psplat_fit_context *context,
                                      const psplat_evaluation *evaluation,
                                      psplat_candidate *candidate) {
    size_t count = evaluation->count;
    uint32_t *covered = realloc(candidate->covered, (count + 1) * sizeof *covered);
    if (!covered) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i)
        covered[i] = context->scratch->near.samples[evaluation->covered[i]].index;
    candidate->covered = covered;
    candidate->covered_count = count;
    return PSPLAT_OK;
}

psplat_result psplat_candidate_set(const psplat_fit_context *context, const psplat_site *site,
                                   const psplat_evaluation *evaluation, int keep_record,
                                   psplat_candidate *candidate) {
    if (!keep_record && psplat_candidate_record(context, evaluation, candidate))
        return PSPLAT_ERROR_MEMORY;
    candidate->region = evaluation->region;
    candidate->deviation = evaluation->deviation;
    candidate->triangle = site->triangle;
    candidate->is_within_creases = 0;
    memcpy(candidate->field, evaluation->field, sizeof candidate->field);
    return PSPLAT_OK;
}

psplat_fit_status psplat_candidate_replace(const psplat_fit_context *context, psplat_site *site,
                                           const psplat_region *region, double least_area,
                                           int keep_record, psplat_candidate *candidate) {
    const psplat_demands demands = {.inside = context->samples->positions +
                                              3 * (size_t)candidate->covered[0],
                                    .held = candidate,
                                    .any_reason = site->seed == PSPLAT_NONE || least_area > 0,
                                    .least_area = least_area,
                                    .more_than = keep_record ? SIZE_MAX : candidate->covered_count};
    psplat_evaluation evaluation = psplat_evaluate(context, site, region, &demands);
    if (!evaluation.status &&
        psplat_candidate_set(context, site, &evaluation, keep_record, candidate))
        return PSPLAT_FIT_MEMORY;
    return evaluation.status;
}

void psplat_candidate_put_nearest_first(const psplat_samples *samples, const double point[3],
                                        psplat_candidate *candidate) {
    uint32_t *covered = candidate->covered, first = covered[0];
    double least = HUGE_VAL;
    size_t nearest = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        double d = distance2_3(samples->positions + 3 * (size_t)covered[i], point);
        if (d < least) least = d, nearest = i;
    }
    covered[0] = covered[nearest];
    covered[nearest] = first;
}
