/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate_texcoord.c - the check how far a texture slides over a region whose texture coordinates
 * are fitted to the samples in it.
 *
 * The samples are those that the region covers and those that lie a little beyond its rim, on the
 * same chart: coordinates that are interpolated at the rim do not fly off there. The flood that
 * gathered them crosses no border of charts, but it may go around the end of one, or once around
 * the neck of a vase, and come to its other side: what lies behind such a border does not count
 * in the last fit. On trial, what lies farther inside than a splat may reach over a crease does
 * count, so that a region that reaches over a border is found too large; lines on the grid of a
 * file leave their borders a little.
 * Coordinates of curved splats are of the second order: on a surface that bends coordinates mostly
 * do, too, and of linear ones up to twice as many splats are needed.
 */
#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "fit/crease_segments.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/texcoord_fit.h"
#include "mesh/mesh.h"
#include "splats/splat_texcoord.h"

#include <math.h>

/* How far beyond the rim, in spacings, and beyond the tolerance from the surface samples count.
 * Chosen by hand. */
static const double rim_spacings = 0.75, greatest_height_tolerances = 1.5;

/* How far beside a border, as a part of the way to the middle of its triangle, a sample counts that
 * lies on it: enough for rounding. */
static const double beside_border = 1e-3;

/* ---- what is behind a border ----------------------------------------------------------------- */

/* What of a region's surroundings is seen from a point inside, between the creases and borders of
 * charts that the flood met on both sides (walls). A splat that needs what lies around a bulge of
 * its own border loses those samples beyond its rim, which it can spare. */
typedef struct walled {
    const psplat_fit_context *context;
    const psplat_region *region;
    double depth;      /* inside lines, up to which what is behind a wall does not count */
    uint32_t inside;   /* a covered sample */
    double from[2];    /* (u, v) of a point at that */
    size_t wall_count; /* in scratch->segments, in (u, v) of the region */
} walled;

/* Returns whether the last gathering met a triangle. */
static int was_met(const psplat_fit_context *context, uint32_t triangle) {
    const psplat_neighborhood *near = &context->scratch->near;
    if (triangle == PSPLAT_NONE) return 0;
    return near->stamps[context->samples->clusters.of_triangles[triangle]] == near->stamp;
}

/* Finds the walls within a length of a region. */
static size_t find_walls(const psplat_fit_context *context, const psplat_region *region,
                         double beyond) {
    psplat_scratch *s = context->scratch;
    psplat_region grown = *region;
    size_t count, kept = 0;
    int met = 0;
    for (size_t i = 0; i < s->near.crease_count && !met; ++i)
        met = was_met(context, context->surface->neighbors[s->near.creases[i]]);
    if (!met) return 0;
    grown.line_count = 0;
    for (int k = 0; k < 2; ++k) grown.radius[k] += beyond;
    count = psplat_segments_find_near(context->surface, &s->near, &grown,
                                      2 * context->limits->tolerance, s->segments);
    for (size_t i = 0; i < count; ++i) {
        if (!was_met(context, s->segments[i].across)) continue;
        psplat_segment wall = s->segments[i];
        for (int k = 0; k < 2; ++k) {
            wall.a[k] *= grown.radius[k] / region->radius[k];
            wall.b[k] *= grown.radius[k] / region->radius[k];
        }
        s->segments[kept++] = wall;
    }
    return kept;
}

/* Stores where a sample lies in (u, v), a little towards the middle of its triangle. */
static void place_beside(const walled *w, uint32_t sample, double uv[2]) {
    const psplat_samples *samples = w->context->samples;
    const psplat_mesh *mesh = w->context->surface->mesh;
    double point[3], uvh[3];
    along3(point, samples->positions + 3 * (size_t)sample, -beside_border,
           samples->positions + 3 * (size_t)sample);
    for (int k = 0; k < 3; ++k)
        mad3(point, beside_border / 3, psplat_mesh_corner(mesh, samples->triangles[sample], k));
    psplat_region_local(w->region, point, uvh);
    uv[0] = uvh[0], uv[1] = uvh[1];
}

/* Returns whether a wall stands between the point inside and a sample. */
static int is_behind_wall(const walled *w, uint32_t sample) {
    const psplat_segment *walls = w->context->scratch->segments;
    double to[2];
    if (w->wall_count) place_beside(w, sample, to);
    for (size_t i = 0; i < w->wall_count; ++i)
        if (segments_cross2(w->from, to, walls[i].a, walls[i].b)) return 1;
    return 0;
}

/* Returns how far parameters lie inside a region's lines, in its smaller radius. */
static double depth_inside_lines(const psplat_region *region, const double uv[2]) {
    double depth = HUGE_VAL;
    for (uint32_t line = 0; line < region->line_count; ++line)
        depth = min2(depth, psplat_region_line_value(region, line, uv));
    return depth;
}

/* Returns whether parameters lie inside the region, and so far from its lines that it reaches over
 * the border of a chart there. */
static int is_deep_inside(const walled *w, const double uv[2]) {
    return uv[0] * uv[0] + uv[1] * uv[1] <= 1 &&
           depth_inside_lines(w->region, uv) * w->region->radius[1] >= w->depth;
}

/* Returns whether a sample, whose parameters are given, is not to count. */
static int is_across(const walled *w, uint32_t sample, const double uv[2]) {
    return is_behind_wall(w, sample) && !is_deep_inside(w, uv);
}

/* The same of a sample that a candidate is recorded to cover: another gathering than the last may
 * have met it, around a border. */
static int is_recorded_across(const walled *w, uint32_t sample, const double uv[2]) {
    return !was_met(w->context, w->context->samples->triangles[sample]) || is_across(w, sample, uv);
}

/* Offers a covered sample as the point inside: that which is farthest inside the rim and the lines
 * is taken, since others may lie on the border of a chart, or across. */
static void offer_inside(walled *w, uint32_t sample, const double uv[2], double *depth) {
    double own = min2(1 - norm2(uv[0], uv[1]), depth_inside_lines(w->region, uv));
    if (own > *depth) *depth = own, w->inside = sample;
}

/* Finds what stands around the point inside. */
static void find_surroundings(walled *w, double beyond) {
    w->wall_count = find_walls(w->context, w->region, beyond);
    if (w->wall_count) place_beside(w, w->inside, w->from);
}

/* ---- samples --------------------------------------------------------------------------------- */

/* Returns whether the sample i of the neighbourhood, whose parameters are in the scratch, lies
 * within a length of the region. */
static int counts(const psplat_fit_context *context, const psplat_region *region, double beyond,
                  size_t i) {
    const psplat_scratch *s = context->scratch;
    const double *uvh = s->uvh[i];
    double squares = 0;
    for (int k = 0; k < 2; ++k) {
        double scaled = uvh[k] * region->radius[k] / (region->radius[k] + beyond);
        squares += scaled * scaled;
    }
    if (squares > 1 || fabs(uvh[2]) > greatest_height_tolerances * context->limits->tolerance)
        return 0;
    for (uint32_t line = 0; line < region->line_count; ++line)
        if (psplat_region_line_value(region, line, uvh) < -beyond / region->radius[1]) return 0;
    return dot3(s->near.samples[i].n, region->n) >= PSPLAT_LEAST_COVERED_COSINE;
}

static void add_sample(const psplat_fit_context *context, uint32_t sample, const double uv[2],
                       psplat_texcoord_sums *sums) {
    uint32_t triangle = context->samples->triangles[sample];
    psplat_texcoord_sums_add(sums, uv, context->samples->texcoords + 2 * (size_t)sample,
                             context->surface->texcoord_slopes + 6 * (size_t)triangle);
}

/* Returns the greatest slide of fitted coordinates over the samples that a candidate is recorded to
 * cover on its side, in parts of what is allowed. */
static double greatest_slide(const walled *inside, const psplat_candidate *candidate,
                             const psplat_texcoord *fitted) {
    const psplat_fit_context *context = inside->context;
    const psplat_samples *samples = context->samples;
    const psplat_limits *limits = context->limits;
    const psplat_kept_textures *kept =
        psplat_surface_kept_textures(context->surface, samples->triangles[inside->inside]);
    double texels = limits->texture_tolerance_texels, greatest = 0, uvh[3], error[2];
    if (!kept || !(texels > 0 || limits->texture_tolerance > 0)) return 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint32_t sample = candidate->covered[i];
        const float *given = samples->texcoords + 2 * (size_t)sample;
        psplat_region_local(inside->region, samples->positions + 3 * (size_t)sample, uvh);
        if (is_recorded_across(inside, sample, uvh)) continue;
        psplat_texcoord_at(fitted, uvh, error);
        for (int k = 0; k < 2; ++k) error[k] -= (double)given[k];
        psplat_slide slide =
            psplat_texcoord_slide(fitted, inside->region, uvh, kept->texels, error);
        double part = texels > 0 ? slide.texels / texels : slide.length / limits->texture_tolerance;
        greatest = max2(greatest, part);
    }
    return greatest;
}

/* Adds the samples that a candidate is recorded to cover on its side. */
static void add_recorded(const walled *inside, const psplat_candidate *candidate,
                         psplat_texcoord_sums *sums) {
    const psplat_fit_context *context = inside->context;
    double uvh[3];
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint32_t sample = candidate->covered[i];
        psplat_region_local(inside->region, context->samples->positions + 3 * (size_t)sample, uvh);
        if (sample == inside->inside || !is_recorded_across(inside, sample, uvh))
            add_sample(context, sample, uvh, sums);
    }
}

/* Adds the samples beyond the rim. */
static void add_rim(const walled *inside, double rim, psplat_texcoord_sums *sums) {
    const psplat_fit_context *context = inside->context;
    const psplat_scratch *s = context->scratch;
    for (size_t i = 0; i < s->near_count; ++i) {
        uint32_t sample = s->near.samples[i].index;
        if (counts(context, inside->region, rim, i) && !counts(context, inside->region, 0, i) &&
            !is_across(inside, sample, s->uvh[i]))
            add_sample(context, sample, s->uvh[i], sums);
    }
}

void psplat_evaluate_fit_texcoords(const psplat_fit_context *context, const psplat_region *region,
                                   const psplat_candidate *candidate, psplat_texcoord *fitted) {
    double rim = rim_spacings * context->samples->spacing, uvh[3], depth = -HUGE_VAL;
    int is_curved = psplat_region_is_curved(region);
    walled inside = {
        .context = context, .region = region, .depth = HUGE_VAL, .inside = candidate->covered[0]};
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint32_t sample = candidate->covered[i];
        if (!was_met(context, context->samples->triangles[sample])) continue;
        psplat_region_local(region, context->samples->positions + 3 * (size_t)sample, uvh);
        offer_inside(&inside, sample, uvh, &depth);
    }
    find_surroundings(&inside, rim);
    psplat_texcoord_sums own = {.weight = 0};
    add_recorded(&inside, candidate, &own);
    psplat_texcoord_sums sums = own;
    add_rim(&inside, rim, &sums);
    psplat_texcoord_sums_fit(&sums, region, is_curved, fitted);
    double slide = greatest_slide(&inside, candidate, fitted);
    if (slide <= 1) return;
    /* What lies beyond the rim may be of another layer, or across a border that ends there. */
    psplat_texcoord without_rim;
    psplat_texcoord_sums_fit(&own, region, is_curved, &without_rim);
    if (greatest_slide(&inside, candidate, &without_rim) < slide) *fitted = without_rim;
}

/* Fits coordinates to the samples of the last evaluation. */
static void fit_evaluated(const walled *inside, double rim, psplat_texcoord *fitted) {
    const psplat_fit_context *context = inside->context;
    const psplat_scratch *s = context->scratch;
    psplat_texcoord_sums sums = {.weight = 0};
    for (size_t i = 0; i < s->near_count; ++i) {
        uint32_t sample = s->near.samples[i].index;
        if (counts(context, inside->region, rim, i) && !is_across(inside, sample, s->uvh[i]))
            add_sample(context, sample, s->uvh[i], &sums);
    }
    psplat_texcoord_sums_fit(&sums, inside->region, psplat_region_is_curved(inside->region),
                             fitted);
}

psplat_fit_status psplat_evaluate_texcoords(const psplat_fit_context *context,
                                            const psplat_region *region, size_t count) {
    const psplat_limits *limits = context->limits;
    const psplat_scratch *s = context->scratch;
    if (!context->samples->texcoords ||
        !(limits->texture_tolerance > 0 || limits->texture_tolerance_texels > 0))
        return PSPLAT_FIT_KEPT;
    uint32_t first = s->near.samples[s->covered[0]].index;
    const psplat_kept_textures *kept =
        psplat_surface_kept_textures(context->surface, context->samples->triangles[first]);
    if (!kept) return PSPLAT_FIT_KEPT;
    double rim = rim_spacings * context->samples->spacing, depth = -HUGE_VAL;
    walled inside = {.context = context, .region = region, .depth = limits->crease_slack};
    for (size_t i = 0; i < count; ++i)
        offer_inside(&inside, s->near.samples[s->covered[i]].index, s->uvh[s->covered[i]], &depth);
    find_surroundings(&inside, rim);
    psplat_texcoord fitted;
    fit_evaluated(&inside, rim, &fitted);
    for (size_t i = 0; i < s->near_count; ++i) {
        uint32_t sample = s->near.samples[i].index;
        const float *given = context->samples->texcoords + 2 * (size_t)sample;
        double error[2];
        if (!counts(context, region, 0, i) || is_across(&inside, sample, s->uvh[i])) continue;
        psplat_texcoord_at(&fitted, s->uvh[i], error);
        for (int k = 0; k < 2; ++k) error[k] -= (double)given[k];
        psplat_slide slide = psplat_texcoord_slide(&fitted, region, s->uvh[i], kept->texels, error);
        if (!psplat_slide_is_kept(&slide, limits->texture_tolerance,
                                  limits->texture_tolerance_texels))
            return PSPLAT_FIT_TEXTURE_SLIDES;
    }
    return PSPLAT_FIT_KEPT;
}
