/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * quantize_candidate.c - the move of a candidate to the grid of the file's integers.
 *
 * A file holds centres, axes and radii as integers. Instead of rounding them in the end and
 * reserving a part of the tolerance for it, candidates that are taken move to the grid and are
 * evaluated there by the same limits as all others. So the promises hold for what is stored, and
 * quantization costs a few splats instead of a part of the tolerance. A splat may move little
 * across its plane but much within it: mostly one of the grid points around the centre lies close
 * to the plane. A curved splat moves along its surface: at each place it gets the normal that the
 * surface has there, and second derivatives fitted anew, so that the rounding of centre and normal
 * is made up for as far as these can.
 *
 * Where fits use much of the tolerance, that surface is not the candidate's own, which was fitted
 * to the samples that it covers, but one between that and the mesh beneath all of the ellipse, to
 * its rim: rims draw outlines. What stands off outwards goes farther than what lies inside, since
 * of all the splats of a place the outermost is seen.
 */
#include "fit/quantize_candidate.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"
#include "splats/octahedron.h"
#include "splats/quantize.h"
#include "splats/splats.h"

#include <math.h>
#include <string.h>

/* All of these were chosen by hand. */
/* The number of grid points tried, and how far from the centre they are looked for, in steps. */
enum { OPTIONS = 32, SEARCHED_STEPS = 3 };
/* The number of grid points near a curved surface that are tried with normals of the grid, and
 * every how many of the old region's points the surface is fitted to there, also where these have
 * to be found on the mesh. */
enum { PLACES = 12, FITTED_STEP = 4, PULLED_STEP = 6 };
/* The part of its way to the mesh that a point of a curved surface goes which stands off outwards,
 * and one that lies inside, where limits->mesh_pull is 1. With 0.5 for both, splats are 1 % fewer,
 * and outlines are too wide rather than too narrow, by 2 to 3 times as many pixels; with 1 and 0.3
 * they are 2 to 3 % more, and outlines gain as much again. */
static const double outer_pull = 0.7, inner_pull = 0.3;
/* What leaving the plane by the tolerance costs; moving by a radius costs 1. */
static const double plane_cost = 0.5;
/* The radii tried, in steps from those of the candidate rounded down: larger ones first. */
static const int radius_steps[][2] = {{1, 1}, {1, 0}, {0, 1}, {0, 0}, {0, -1}, {-1, 0}, {-1, -1}};
enum { RADIUS_STEPS = sizeof radius_steps / sizeof *radius_steps, ROUNDED_DOWN = 3 };
/* How often, and by which factor, a candidate shrinks that fits nowhere on the grid. */
enum { SHRINKINGS = 16 };
static const double shrink_factor = 0.9;

/* Axes and a centre on the grid, the second derivatives of the surface in these axes, which are not
 * rounded yet, and what moving there costs. */
typedef struct option {
    double axes[3][3], center[3], hessian[3], cost;
} option;

typedef struct quantizer {
    const psplat_fit_context *context;
    const psplat_precision *precision;
    psplat_precision at; /* the steps of the radii for which options are found */
    psplat_site site;
    psplat_region old;
    double points[PSPLAT_REGION_POINTS][3]; /* of the surface that it is to have, relative to the
                                               old region's centre */
    size_t point_count;
    option options[OPTIONS];
    int failed; /* 1: out of memory */
} quantizer;

/* Inserts an option into a list of the count cheapest ones, cheapest first, and drops the last. */
static void keep_cheapest(option *options, int count, const option *new) {
    for (int i = 0; i < count; ++i) {
        if (options[i].cost <= new->cost) continue;
        memmove(options + i + 1, options + i, (size_t)(count - 1 - i) * sizeof *options);
        options[i] = *new;
        return;
    }
}

/* Moves the points towards the mesh. */
static void pull_points(quantizer *q) {
    const psplat_distance *mesh = q->context->limits->distance;
    uint32_t guess = PSPLAT_NONE;
    for (size_t i = 0; i < q->point_count; ++i) {
        double point[3], nearest[3], way[3];
        uint32_t triangle;
        along3(point, q->old.center, 1, q->points[i]);
        if (psplat_distance_nearest(mesh, point, &guess, nearest, &triangle)) q->failed = 1;
        if (q->failed || triangle == PSPLAT_NONE) return;
        sub3(way, nearest, point);
        const double *normal = q->context->surface->face_normals + 3 * (size_t)triangle;
        if (!(dot3(normal, q->old.n) > 0)) continue; /* the other side of a thin wall */
        int is_outside = dot3(way, normal) < 0;
        mad3(q->points[i], q->context->limits->mesh_pull * (is_outside ? outer_pull : inner_pull),
             way);
    }
}

/* Finds points of the old region, and of the surface that a curved one is to have. */
static void find_points(quantizer *q) {
    int is_curved = psplat_region_is_curved(&q->old);
    int is_pulled = is_curved && q->context->limits->distance && q->context->limits->mesh_pull > 0;
    size_t count = 0, step = is_pulled ? PULLED_STEP : is_curved ? FITTED_STEP : 1;
    q->point_count = psplat_region_points(&q->old, q->points);
    for (size_t i = 0; i < q->point_count; i += step)
        sub3(q->points[count++], q->points[i], q->old.center);
    q->point_count = count;
    if (is_pulled) pull_points(q);
}

/* Finds the offset of the plane of this normal whose greatest distance from the old region is
 * least, and that distance. */
static double best_offset(const quantizer *q, const double n[3], double *spread) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < q->point_count; ++i) {
        double height = dot3(q->points[i], n);
        low = min2(low, height);
        high = max2(high, height);
    }
    *spread = q->point_count ? (high - low) / 2 : 0;
    return q->point_count ? (low + high) / 2 : 0;
}

/* Tries the grid points around the centre with these axes, and keeps the cheapest ones. */
static void find_centers(quantizer *q, double axes[3][3]) {
    double unit = q->precision->unit, tolerance = q->context->limits->tolerance;
    double spread, offset = best_offset(q, axes[2], &spread);
    option o = {.hessian = {0}};
    memcpy(o.axes, axes, sizeof o.axes);
    for (int i = -SEARCHED_STEPS; i <= SEARCHED_STEPS; ++i)
        for (int j = -SEARCHED_STEPS; j <= SEARCHED_STEPS; ++j)
            for (int k = -SEARCHED_STEPS; k <= SEARCHED_STEPS; ++k) {
                const int steps[3] = {i, j, k};
                double d[3];
                for (int c = 0; c < 3; ++c)
                    o.center[c] = unit * (rint(q->old.center[c] / unit) + steps[c]);
                sub3(d, o.center, q->old.center);
                o.cost = norm2(dot3(d, axes[0]) / q->old.radius[0],
                               dot3(d, axes[1]) / q->old.radius[1]) +
                         plane_cost * (fabs(dot3(d, axes[2]) - offset) + spread) / tolerance;
                keep_cheapest(q->options, OPTIONS, &o);
            }
}

/* ---- curved surfaces ------------------------------------------------------------------------ */

/* Finds the grid points nearest to the old surface and its centre. */
static void find_places(const quantizer *q, option places[PLACES]) {
    double unit = q->precision->unit, tolerance = q->context->limits->tolerance;
    option o = {.hessian = {0}};
    for (int i = 0; i < PLACES; ++i) places[i].cost = HUGE_VAL;
    for (int i = -SEARCHED_STEPS; i <= SEARCHED_STEPS; ++i)
        for (int j = -SEARCHED_STEPS; j <= SEARCHED_STEPS; ++j)
            for (int k = -SEARCHED_STEPS; k <= SEARCHED_STEPS; ++k) {
                const int steps[3] = {i, j, k};
                double uvh[3];
                for (int c = 0; c < 3; ++c)
                    o.center[c] = unit * (rint(q->old.center[c] / unit) + steps[c]);
                psplat_region_local(&q->old, o.center, uvh);
                o.cost = norm2(uvh[0], uvh[1]) + plane_cost * fabs(uvh[2]) / tolerance;
                keep_cheapest(places, PLACES, &o);
            }
}

/* Fits the second derivatives of an option to the points, with the option's centre and axes as they
 * are, and adds to the cost how far the surface leaves these. */
static void fit_option(const quantizer *q, option *o) {
    double m[3][3] = {{0}}, right[3] = {0}, shift[3], farthest = 0;
    double local[PSPLAT_REGION_POINTS][3], scale = q->old.radius[0];
    sub3(shift, q->old.center, o->center);
    for (size_t i = 0; i < q->point_count; ++i) {
        double d[3];
        for (int k = 0; k < 3; ++k) d[k] = q->points[i][k] + shift[k];
        for (int k = 0; k < 3; ++k) local[i][k] = dot3(d, o->axes[k]) / scale;
        double s = local[i][0], t = local[i][1], row[3] = {s * s / 2, s * t, t * t / 2};
        for (int k = 0; k < 3; ++k) {
            for (int l = 0; l < 3; ++l) m[k][l] += row[k] * row[l];
            right[k] += row[k] * local[i][2];
        }
    }
    for (int k = 0; k < 3; ++k) m[k][k] += 1e-12 * (double)q->point_count;
    for (int k = 0; k < 2; ++k)
        for (int l = k + 1; l < 3; ++l) {
            double factor = m[l][k] / m[k][k];
            for (int c = k; c < 3; ++c) m[l][c] -= factor * m[k][c];
            right[l] -= factor * right[k];
        }
    for (int k = 3; k-- > 0;) {
        for (int l = k + 1; l < 3; ++l) right[k] -= m[k][l] * right[l];
        right[k] /= m[k][k];
    }
    for (int k = 0; k < 3; ++k) o->hessian[k] = right[k] / scale;
    psplat_quantize_shape(q->precision, q->old.radius, o->hessian);
    for (size_t i = 0; i < q->point_count; ++i) {
        const double *h = o->hessian;
        double s = local[i][0] * scale, t = local[i][1] * scale;
        double height = (h[0] * s * s + 2 * h[1] * s * t + h[2] * t * t) / 2;
        farthest = max2(farthest, fabs(local[i][2] * scale - height));
    }
    for (int k = 0; k < 3; ++k) o->hessian[k] = right[k] / scale;
    o->cost += plane_cost * farthest / q->context->limits->tolerance;
}

/* Tries the grid points near a curved surface with the normals of the grid next to the surface's
 * own there, and keeps the cheapest pairs. */
static void find_options_on_surface(quantizer *q) {
    static const int32_t codes[][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    option places[PLACES];
    int32_t unit = 1 << q->at.normal_shift;
    find_places(q, places);
    for (int i = 0; i < PLACES; ++i) {
        double uvh[3], normal[3];
        int32_t middle[2];
        psplat_region_local(&q->old, places[i].center, uvh);
        psplat_region_normal(&q->old, uvh, normal);
        psplat_octahedron_encode_coarsely(normal, q->at.normal_bits, q->at.normal_shift, middle);
        for (size_t k = 0; k < sizeof codes / sizeof *codes; ++k) {
            const int32_t code[2] = {middle[0] + codes[k][0] * unit,
                                     middle[1] + codes[k][1] * unit};
            option o = places[i];
            if (!psplat_octahedron_is_code(code, q->at.normal_bits)) continue;
            psplat_quantized_axes(&q->at, code, q->old.u, o.axes);
            o.cost = norm2(uvh[0], uvh[1]);
            fit_option(q, &o);
            keep_cheapest(q->options, OPTIONS, &o);
        }
    }
}

/* Finds the cheapest pairs of a grid normal next to the old one and a grid point around the centre.
 * Where there are fewer than OPTIONS, what stands in place of the rest costs HUGE_VAL: it is left
 * from other steps, and is no option. */
static void find_options(quantizer *q) {
    int32_t middle[2], unit = 1 << q->at.normal_shift;
    for (int i = 0; i < OPTIONS; ++i) q->options[i].cost = HUGE_VAL;
    if (psplat_region_is_curved(&q->old)) {
        find_options_on_surface(q);
        return;
    }
    psplat_octahedron_encode_coarsely(q->old.n, q->at.normal_bits, q->at.normal_shift, middle);
    for (int32_t i = -1; i <= 1; ++i)
        for (int32_t k = -1; k <= 1; ++k) {
            const int32_t code[2] = {middle[0] + i * unit, middle[1] + k * unit};
            double axes[3][3];
            if (!psplat_octahedron_is_code(code, q->at.normal_bits)) continue;
            psplat_quantized_axes(&q->at, code, q->old.u, axes);
            find_centers(q, axes);
        }
}

/* ---- regions on the grid -------------------------------------------------------------------- */

/* Finds radii on the grid: the old ones times a factor, rounded down, plus so many steps. */
static void find_radii(const quantizer *q, double factor, const int steps[2], double radius[2]) {
    double step = q->precision->scale_step, unit = q->precision->unit;
    for (int k = 0; k < 2; ++k) {
        double down = floor(log(q->old.radius[k] * factor / unit) / step);
        radius[k] = unit * exp(step * (down + steps[k]));
    }
    if (radius[1] > radius[0]) radius[0] = radius[1];
}

/* Finds the options for radii on the grid, unless the last ones found are for such radii. */
static void find_options_for(quantizer *q, const double radius[2]) {
    psplat_precision at = psplat_precision_at(q->precision, radius);
    if (at.normal_shift == q->at.normal_shift && at.turn_step == q->at.turn_step) return;
    q->at = at;
    find_options(q);
}

/* Finds options for the old radii. */
static void begin_options(quantizer *q) {
    double radius[2];
    find_radii(q, 1, radius_steps[ROUNDED_DOWN], radius);
    q->at = psplat_precision_at(q->precision, radius);
    find_points(q);
    find_options(q);
}

/* Returns the region of an option, with such radii. */
static psplat_region region_of(const quantizer *q, const option *o, double factor,
                               const int steps[2]) {
    psplat_region r = {.line_count = 0};
    memcpy(r.center, o->center, sizeof r.center);
    memcpy(r.u, o->axes[0], sizeof r.u);
    memcpy(r.v, o->axes[1], sizeof r.v);
    memcpy(r.n, o->axes[2], sizeof r.n);
    find_radii(q, factor, steps, r.radius);
    memcpy(r.hessian, o->hessian, sizeof r.hessian);
    if (psplat_region_is_curved(&r)) psplat_quantize_shape(q->precision, r.radius, r.hessian);
    return r;
}

/* Gives the candidate the region of the first option that keeps the limits. Returns KEPT, MEMORY,
 * or why the last option does not keep them. */
static psplat_fit_status try_options(quantizer *q, double factor, const int steps[2],
                                     int keep_record, psplat_candidate *candidate) {
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    double radius[2];
    find_radii(q, factor, steps, radius);
    find_options_for(q, radius);
    for (int i = 0; i < OPTIONS && status && status != PSPLAT_FIT_MEMORY; ++i) {
        if (!(q->options[i].cost < HUGE_VAL)) break;
        psplat_region tried = region_of(q, &q->options[i], factor, steps);
        status = psplat_candidate_replace(q->context, &q->site, &tried, 0, keep_record, candidate);
    }
    return status;
}

static psplat_fit_status try_radii(quantizer *q, psplat_candidate *candidate) {
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    for (int i = 0; i < RADIUS_STEPS && status && status != PSPLAT_FIT_MEMORY; ++i)
        status = try_options(q, 1, radius_steps[i], 1, candidate);
    return status;
}

/* Shrinks a candidate until it fits. It must still cover its first sample or, where that fails, the
 * sample in its middle; which others it covers is found anew. */
static psplat_fit_status shrink(quantizer *q, psplat_candidate *candidate) {
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    size_t count = candidate->covered_count;
    for (int of_seed = 1; of_seed >= 0; --of_seed) {
        double factor = 1;
        candidate->covered_count = count;
        if (!of_seed)
            psplat_candidate_put_nearest_first(q->context->samples, q->old.center, candidate);
        for (int i = 0; i < SHRINKINGS; ++i, factor *= shrink_factor) {
            candidate->covered_count = 1;
            status = try_options(q, factor, radius_steps[ROUNDED_DOWN], 0, candidate);
            if (!status || status == PSPLAT_FIT_MEMORY) return status;
        }
    }
    return status;
}

/* Returns a region shrunk by a factor about a point of it (u, v), without lines. */
static psplat_region shrunk_about(const psplat_region *region, const double uv[2], double factor) {
    const double middle[2] = {(1 - factor) * uv[0], (1 - factor) * uv[1]};
    psplat_region shrunk = *region;
    shrunk.line_count = 0;
    psplat_region_point(region, middle, shrunk.center);
    psplat_region_slope(region, middle, shrunk.slope);
    for (int k = 0; k < 2; ++k) shrunk.radius[k] *= factor;
    return shrunk;
}

/* Shrinks a candidate about its first sample until it fits and covers that. */
static psplat_fit_status shrink_about_first(quantizer *q, psplat_candidate *candidate) {
    const psplat_region whole = q->old;
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    double uvh[3], factor = 1;
    psplat_region_local(&whole, q->context->samples->positions + 3 * (size_t)candidate->covered[0],
                        uvh);
    for (int i = 0; i < SHRINKINGS && status && status != PSPLAT_FIT_MEMORY; ++i) {
        q->old = shrunk_about(&whole, uvh, factor);
        begin_options(q);
        candidate->covered_count = 1;
        status = try_options(q, 1, radius_steps[ROUNDED_DOWN], 0, candidate);
        factor *= shrink_factor;
    }
    return status;
}

/* Puts the sample that a candidate must cover first. Returns 0 where there is none. */
static int put_needed_first(psplat_candidate *candidate) {
    uint32_t *covered = candidate->covered;
    for (size_t i = 0; candidate->needed && i < candidate->covered_count; ++i) {
        if (covered[i] != candidate->needed - 1) continue;
        covered[i] = covered[0];
        covered[0] = candidate->needed - 1;
        return 1;
    }
    return 0;
}

/* ---- the last resort ------------------------------------------------------------------------ */

/* The greatest radius of the disc of the last resort, in tolerances, unless its centre is off by
 * more than half of that. With the centre off by a part of the tolerance, too, it is near the
 * surface. */
static const double disc_radius_tolerances = 0.4;

/* Returns a small disc on the grid that covers a point. Its radius is at least twice the centre's
 * distance from the point within the plane, so that the farthest point of the disc is three times
 * as far, plus the height of the centre: that sum is what its centre is chosen by. Of the nearest
 * grid point it is sqrt(10) times half a cube's diagonal at most, which is less than the tolerance
 * for steps up to 0.36 of it; select/precision.c chooses 0.35 at most unless it is told. */
static psplat_region disc_at(quantizer *q, const double point[3], uint32_t triangle) {
    double tolerance = q->context->limits->tolerance, least = q->old.radius[1], d[3];
    const double *n = q->context->surface->face_normals + 3 * (size_t)triangle;
    double radius = tolerance / (3 * plane_cost);
    q->old = (psplat_region){.radius = {radius, radius}};
    memcpy(q->old.center, point, sizeof q->old.center);
    memcpy(q->old.n, n, sizeof q->old.n);
    perpendicular3(q->old.u, n);
    cross3(q->old.v, n, q->old.u);
    begin_options(q);
    double smallest = min2(least, disc_radius_tolerances * tolerance);
    const double radii[2] = {smallest, smallest};
    find_options_for(q, radii); /* Larger discs have such steps, too. */
    const option *o = &q->options[0];
    sub3(d, o->center, point);
    double within = norm2(dot3(d, o->axes[0]), dot3(d, o->axes[1]));
    for (int k = 0; k < 2; ++k) q->old.radius[k] = max2(2 * within, smallest);
    return region_of(q, o, 1, radius_steps[0]);
}

/* Makes the candidate a disc that covers its first sample alone. A candidate without samples
 * becomes a disc at its centre. */
static psplat_result make_disc(quantizer *q, psplat_candidate *candidate) {
    const psplat_samples *samples = q->context->samples;
    uint32_t sample = candidate->covered_count ? candidate->covered[0] : PSPLAT_NONE;
    uint32_t triangle = candidate->triangle;
    const double *point = candidate->region.center;
    if (sample != PSPLAT_NONE)
        point = samples->positions + 3 * (size_t)sample, triangle = samples->triangles[sample];
    psplat_region disc = disc_at(q, point, triangle);
    psplat_site site = psplat_site_of(&disc, triangle);
    psplat_evaluation one =
        psplat_evaluate_single_sample(q->context, &site, &disc, point, sample, 0);
    if (one.status) return PSPLAT_ERROR_MEMORY;
    return psplat_candidate_set(q->context, &site, &one, 1, candidate);
}

static quantizer quantizer_of(const psplat_fit_context *context,
                              const psplat_candidate *candidate) {
    return (quantizer){.context = context,
                       .precision = context->limits->precision,
                       .site = psplat_site_of(&candidate->region, candidate->triangle),
                       .old = candidate->region};
}

psplat_result psplat_quantize_candidate(const psplat_fit_context *context,
                                        psplat_candidate *candidate) {
    quantizer q = quantizer_of(context, candidate);
    psplat_fit_status status = PSPLAT_FIT_NO_GAIN;
    candidate->quantized = 1;
    if (candidate->covered_count) {
        int is_needed = put_needed_first(candidate);
        begin_options(&q);
        status = try_radii(&q, candidate);
        if (status && status != PSPLAT_FIT_MEMORY)
            status = is_needed ? shrink_about_first(&q, candidate) : shrink(&q, candidate);
    }
    if (status == PSPLAT_FIT_MEMORY || q.failed) return PSPLAT_ERROR_MEMORY;
    return status ? make_disc(&q, candidate) : PSPLAT_OK;
}

psplat_result psplat_quantize_whole_candidate(const psplat_fit_context *context,
                                              psplat_candidate *candidate, int *fits) {
    quantizer q = quantizer_of(context, candidate);
    put_needed_first(candidate);
    begin_options(&q);
    psplat_fit_status status = try_radii(&q, candidate);
    *fits = !status;
    candidate->quantized = 1;
    return status == PSPLAT_FIT_MEMORY || q.failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
