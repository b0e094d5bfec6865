/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * snap.c - candidates on the grid of the file.
 *
 * A file holds centres, axes and radii as integers. Instead of rounding them in the end and leaving
 * room for what that does, candidates that are taken move to the grid and are judged there by the
 * same limits as everything else: so promises hold of what is stored, and quantisation costs a few
 * splats instead of a part of the tolerance. Across its plane a splat may move little, within it
 * much: of the grid's points near the centre one mostly lies close to the plane.
 */
#include "encoding.h"
#include "trial.h"
#include "vector.h"

#include <string.h>

/* Grid points tried, and how far from the centre they are looked for, in steps. */
enum { OPTIONS = 3, REACH = 3 };
/* Cost of leaving the plane by the tolerance beside that of moving by a radius. */
static const double plane_cost = 0.5;

/* Radii tried, in steps from those of the candidate rounded down: larger ones first. */
static const int growths[][2] = {{1, 1}, {0, 0}, {-1, -1}};
enum { GROWTHS = sizeof growths / sizeof *growths, SHRINKINGS = 8 };
static const double shrinking = 0.8;

/* Axes and a centre on the grid. */
typedef struct option {
    double axes[3][3], center[3], cost;
} option;

typedef struct snapping {
    const psplat_precision *precision;
    psplat_seedling seedling;
    psplat_region old;
    double points[PSPLAT_REGION_POINTS][3]; /* of the old region, relative to its centre */
    size_t point_count;
    option options[OPTIONS];
} snapping;

static void insert_option(option *options, const option *new) {
    for (int i = 0; i < OPTIONS; ++i) {
        if (options[i].cost <= new->cost) continue;
        memmove(options + i + 1, options + i, (size_t)(OPTIONS - 1 - i) * sizeof *options);
        options[i] = *new;
        return;
    }
}

/* The offset of a plane of this normal that leaves the old region by the least, and by how much it
 * does. */
static double best_offset(const snapping *s, const double n[3], double *spread) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < s->point_count; ++i) {
        double height = dot3(s->points[i], n);
        low = min2(low, height);
        high = max2(high, height);
    }
    *spread = s->point_count ? (high - low) / 2 : 0;
    return s->point_count ? (low + high) / 2 : 0;
}

/* The grid points around the centre that suit a plane best. */
static void find_centers(snapping *s, double axes[3][3]) {
    double unit = s->precision->unit, tolerance = s->seedling.limits->tolerance;
    double spread, offset = best_offset(s, axes[2], &spread);
    option o;
    memcpy(o.axes, axes, sizeof o.axes);
    for (int i = -REACH; i <= REACH; ++i)
        for (int j = -REACH; j <= REACH; ++j)
            for (int k = -REACH; k <= REACH; ++k) {
                const int steps[3] = {i, j, k};
                double d[3];
                for (int c = 0; c < 3; ++c)
                    o.center[c] = unit * (rint(s->old.center[c] / unit) + steps[c]);
                sub3(d, o.center, s->old.center);
                o.cost = hypot(dot3(d, axes[0]) / s->old.radius[0],
                               dot3(d, axes[1]) / s->old.radius[1]) +
                         plane_cost * (fabs(dot3(d, axes[2]) - offset) + spread) / tolerance;
                insert_option(s->options, &o);
            }
}

/* Of all grid normals next to the old one and all centres. */
static void find_options(snapping *s) {
    int32_t middle[2];
    s->point_count = psplat_region_points(&s->old, s->points);
    for (size_t i = 0; i < s->point_count; ++i) sub3(s->points[i], s->points[i], s->old.center);
    for (int i = 0; i < OPTIONS; ++i) s->options[i].cost = HUGE_VAL;
    psplat_octahedron_encode(s->old.n, s->precision->normal_bits, middle);
    for (int32_t i = -1; i <= 1; ++i)
        for (int32_t k = -1; k <= 1; ++k) {
            const int32_t code[2] = {middle[0] + i, middle[1] + k};
            double axes[3][3];
            if (!psplat_octahedron_is_code(code, s->precision->normal_bits)) continue;
            psplat_code_axes(s->precision, code, s->old.u, axes);
            find_centers(s, axes);
        }
}

/* ---- trials --------------------------------------------------------------------------------- */

/* The option's region, its radii the old ones times a factor, rounded down, and so many steps. */
static psplat_region region_of(const snapping *s, const option *o, double factor,
                               const int growth[2]) {
    double step = s->precision->scale_step, unit = s->precision->unit;
    psplat_region r = {.line_count = 0};
    memcpy(r.center, o->center, sizeof r.center);
    memcpy(r.u, o->axes[0], sizeof r.u);
    memcpy(r.v, o->axes[1], sizeof r.v);
    memcpy(r.n, o->axes[2], sizeof r.n);
    for (int k = 0; k < 2; ++k) {
        double steps = log(s->old.radius[k] * factor / unit) / step;
        r.radius[k] = unit * exp(step * (floor(steps) + growth[k]));
    }
    if (r.radius[1] > r.radius[0]) r.radius[0] = r.radius[1];
    return r;
}

static int try_options(snapping *s, double factor, const int growth[2],
                       psplat_candidate *candidate) {
    for (int i = 0; i < OPTIONS && !s->seedling.failed; ++i) {
        psplat_region tried = region_of(s, &s->options[i], factor, growth);
        if (psplat_trial_accept(&s->seedling, &tried, 0, candidate)) return 1;
    }
    return 0;
}

/* Moves the sample nearest to the centre to the front of those covered. */
static void middle_first(const snapping *s, psplat_candidate *candidate) {
    const double *positions = s->seedling.samples->positions;
    uint32_t *covered = candidate->covered, first = covered[0];
    double least = HUGE_VAL;
    size_t nearest = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        double d = distance2_3(positions + 3 * (size_t)covered[i], s->old.center);
        if (d < least) least = d, nearest = i;
    }
    covered[0] = covered[nearest];
    covered[nearest] = first;
}

/* As small as it must be: what it then covers, beside its seed or else what is in its middle, is
 * asked anew. */
static int shrink(snapping *s, psplat_candidate *candidate) {
    size_t count = candidate->covered_count;
    s->seedling.recorded = 0;
    for (int of_seed = 1; of_seed >= 0; --of_seed) {
        double factor = 1;
        candidate->covered_count = count;
        if (!of_seed) middle_first(s, candidate);
        for (int i = 0; i < SHRINKINGS && !s->seedling.failed; ++i, factor *= shrinking) {
            candidate->covered_count = 1;
            if (try_options(s, factor, growths[1], candidate)) return 1;
        }
    }
    return 0;
}

/* ---- the last resort ------------------------------------------------------------------------ */

/* A disc on the grid that covers a point near its middle, as near to it as may be: from there, what
 * is farthest on the disc is three times as far as its middle is within the plane, plus its height.
 */
static psplat_region disc_at(snapping *s, const double point[3], uint32_t triangle) {
    double tolerance = s->seedling.limits->tolerance, least = s->old.radius[1], d[3];
    const double *n = s->seedling.surface->face_normals + 3 * (size_t)triangle;
    s->old =
        (psplat_region){.radius = {plane_cost / 1.5 * tolerance, plane_cost / 1.5 * tolerance}};
    memcpy(s->old.center, point, sizeof s->old.center);
    memcpy(s->old.n, n, sizeof s->old.n);
    perpendicular3(s->old.u, n);
    cross3(s->old.v, n, s->old.u);
    find_options(s);
    const option *o = &s->options[0];
    sub3(d, o->center, point);
    double within = hypot(dot3(d, o->axes[0]), dot3(d, o->axes[1]));
    for (int k = 0; k < 2; ++k) s->old.radius[k] = max2(2 * within, min2(least, tolerance / 16));
    return region_of(s, o, 1, growths[0]);
}

/* The disc's lines and normals, as those of a splat that covers its one sample. */
static void force(snapping *s, uint32_t sample, uint32_t triangle, psplat_candidate *candidate) {
    const psplat_precision *precision = s->seedling.limits->precision;
    const double *point = sample == PSPLAT_NONE
                              ? candidate->region.center
                              : s->seedling.samples->positions + 3 * (size_t)sample;
    double place[3] = {point[0], point[1], point[2]}, local[3], height, field[5] = {0};
    psplat_region disc = disc_at(s, place, triangle);
    psplat_seedling at = psplat_trial_at(s->seedling.surface, s->seedling.samples,
                                         s->seedling.limits, s->seedling.growth, &disc, triangle);
    psplat_growth *g = at.growth;
    at.recorded = 1;
    psplat_region_local(&disc, place, local);
    s->seedling.failed = !psplat_trial_gather(&at, 2 * disc.radius[0] + fabs(local[2]));
    if (s->seedling.failed) return;
    size_t segments = psplat_trial_segments(&at, &disc, &height), count = 0;
    psplat_clip_choose(&disc, g->segments, segments, local, s->seedling.limits->crease_slack);
    for (uint32_t i = 0; i < disc.line_count; ++i) psplat_code_line(precision, disc.lines[i]);
    for (uint32_t i = 0; i < g->near.count && !count; ++i)
        if (g->near.samples[i].index == sample) g->chosen[count++] = i;
    memcpy(g->local[0], local, sizeof g->local[0]);
    if (count) memcpy(g->uvh[g->chosen[0]], local, sizeof local);
    if (count) psplat_trial_field(&at, &disc, count, field);
    psplat_trial_adopt(&at, &disc, field, count, candidate);
}

psplat_result psplat_candidate_snap(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, psplat_growth *growth,
                                    psplat_candidate *candidate) {
    snapping s = {.precision = limits->precision, .old = candidate->region};
    int kept = 0;
    s.seedling = psplat_trial_at(surface, samples, limits, growth, &s.old, candidate->triangle);
    s.seedling.recorded = 1;
    candidate->snapped = 1;
    if (candidate->covered_count) {
        find_options(&s);
        for (int i = 0; i < GROWTHS && !kept; ++i) kept = try_options(&s, 1, growths[i], candidate);
        if (!kept) kept = shrink(&s, candidate);
    }
    if (!kept && !s.seedling.failed) {
        uint32_t sample = candidate->covered_count ? candidate->covered[0] : PSPLAT_NONE;
        force(&s, sample,
              candidate->covered_count ? samples->triangles[sample] : candidate->triangle,
              candidate);
    }
    return s.seedling.failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
