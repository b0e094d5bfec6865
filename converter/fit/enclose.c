/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * enclose.c - a candidate whose ellipse encloses given samples.
 *
 * The plane is fitted to the samples by their covariance. The outline is their minimum-area
 * enclosing ellipse. Unlike that of the covariance, it does not depend on how densely they lie.
 */
#include "fit/enclose.h"

#include "base/covariance.h"
#include "base/region.h"
#include "base/vector.h"
#include "features/neighborhood.h"
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/grow_ellipse.h"
#include "fit/surface_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The iterations after which the search for the ellipse ends, and the factor of its squared radii
 * by which it may still be too large. Both were chosen by hand. */
enum { MOST_ITERATIONS = 40 };
static const double greatest_excess_factor = 1.025;
/* The part by which the squared radii grow, so that the points on the ellipse stay inside when
 * another frame rounds them. */
static const double rounding_slack = 1e-9;

/* An ellipse in a plane: points p with (p - center)^T shape^-1 (p - center) <= 1, shape xx xy yy.
 */
typedef struct ellipse {
    double center[2], shape[3];
} ellipse;

/* Finds nearly the minimum-area ellipse around points by Titterington's (1978) multiplicative
 * weights. weights has room for count. Returns 0 where the points do not span an ellipse. */
static int least_ellipse(const double (*points)[2], size_t count, double *weights, ellipse *e) {
    for (size_t i = 0; i < count; ++i) weights[i] = 1 / (double)count;
    for (int step = 0; step < MOST_ITERATIONS; ++step) {
        double x = 0, y = 0, xx = 0, xy = 0, yy = 0, total = 0, farthest = 0;
        for (size_t i = 0; i < count; ++i) {
            const double *p = points[i], w = weights[i];
            x += w * p[0], y += w * p[1];
            xx += w * p[0] * p[0], xy += w * p[0] * p[1], yy += w * p[1] * p[1];
        }
        xx -= x * x, xy -= x * y, yy -= y * y;
        double determinant = xx * yy - xy * xy;
        if (!(determinant > 1e-9 * xx * yy)) return 0;
        for (size_t i = 0; i < count; ++i) {
            double a = points[i][0] - x, b = points[i][1] - y;
            double distance2 = (yy * a * a - 2 * xy * a * b + xx * b * b) / determinant;
            farthest = max2(farthest, distance2);
            total += weights[i] *= (1 + distance2) / 3;
        }
        double scale = farthest * (1 + rounding_slack);
        *e = (ellipse){{x, y}, {xx * scale, xy * scale, yy * scale}};
        if (farthest <= 2 * greatest_excess_factor) break;
        for (size_t i = 0; i < count; ++i) weights[i] /= total;
    }
    return 1;
}

/* Makes an ellipse in a region's plane, relative to its centre and axes, that of the region, whose
 * radii grow by the margin. The new centre is on the region's surface. */
static void set_ellipse(const ellipse *e, double margin, psplat_region *region) {
    double middle = (e->shape[0] + e->shape[2]) / 2;
    double spread = norm2((e->shape[0] - e->shape[2]) / 2, e->shape[1]);
    double angle = 0.5 * atan2(2 * e->shape[1], e->shape[0] - e->shape[2]), u[3];
    const double uv[2] = {e->center[0] / region->radius[0], e->center[1] / region->radius[1]};
    psplat_region_point(region, uv, region->center);
    for (int k = 0; k < 3; ++k) u[k] = cos(angle) * region->u[k] + sin(angle) * region->v[k];
    memcpy(region->u, u, sizeof u);
    cross3(region->v, region->n, region->u);
    region->radius[0] = sqrt(middle + spread) + margin;
    region->radius[1] = sqrt(max2(middle - spread, 0)) + margin;
}

/* The samples to enclose, and scratch memory for as many points in a plane. */
typedef struct enclosed {
    const psplat_fit_context *context;
    const double *origin;
    psplat_near_sample *samples; /* relative to origin */
    double (*points)[2], *weights;
    size_t count;
} enclosed;

/* Stores the parameters of sample i, in lengths, and its height above the surface. */
static void sample_local(const enclosed *e, size_t i, const psplat_region *region, double d[3]) {
    double p[3];
    for (int k = 0; k < 3; ++k) p[k] = e->origin[k] + e->samples[i].p[k];
    psplat_region_local(region, p, d);
    for (int k = 0; k < 2; ++k) d[k] *= region->radius[k];
}

/* Gives a region the least ellipse around the samples. Returns 0 where they lie in a row. */
static int surround(const enclosed *e, psplat_region *region) {
    ellipse least;
    for (size_t i = 0; i < e->count; ++i) {
        double d[3];
        sample_local(e, i, region, d);
        memcpy(e->points[i], d, sizeof e->points[i]);
    }
    if (!least_ellipse((const double(*)[2])e->points, e->count, e->weights, &least)) return 0;
    set_ellipse(&least, e->context->limits->margin, region);
    return 1;
}

/* Moves a region along its normal to the middle of the samples' heights, and scales its ellipse so
 * that it contains them all. Returns 0 where a sample is farther than the tolerance. */
static int settle(const enclosed *e, psplat_region *region) {
    double low = HUGE_VAL, high = -HUGE_VAL, farthest2 = 0, margin = e->context->limits->margin;
    double inner[2] = {region->radius[0] - margin, region->radius[1] - margin};
    for (size_t i = 0; i < e->count; ++i) {
        double d[3];
        sample_local(e, i, region, d);
        double x = d[0] / inner[0], y = d[1] / inner[1];
        farthest2 = max2(farthest2, x * x + y * y);
        low = min2(low, d[2]), high = max2(high, d[2]);
    }
    if (high - low > 2 * e->context->limits->tolerance || !(farthest2 < HUGE_VAL)) return 0;
    mad3(region->center, (low + high) / 2, region->n);
    double factor = sqrt(farthest2 * (1 + rounding_slack));
    for (int k = 0; k < 2 && factor > 1; ++k) region->radius[k] = inner[k] * factor + margin;
    return 1;
}

/* Finds the region that encloses the samples, given their plane. It is flat where that is near
 * enough to all of them, else curved: then frame and ellipse are found by turns. Returns 0 where
 * a sample is farther from it than the tolerance, or all lie in a row. */
static int enclose(const enclosed *e, const psplat_plane *plane, psplat_region *region) {
    *region = (psplat_region){.radius = {1, 1}};
    memcpy(region->u, plane->u, sizeof region->u);
    memcpy(region->v, plane->v, sizeof region->v);
    memcpy(region->n, plane->n, sizeof region->n);
    for (int k = 0; k < 3; ++k) region->center[k] = e->origin[k] + plane->mean[k];
    if (!surround(e, region)) return 0;
    psplat_region flat = *region;
    int curved = !e->context->limits->planar;
    for (int turn = 0; turn < 2 && curved; ++turn)
        curved = (!turn || surround(e, region)) &&
                 psplat_fit_surface(e->samples, NULL, e->count, e->origin,
                                    psplat_most_normal_pull(e->context), region);
    if (curved && psplat_surface_sagitta(region) > PSPLAT_FLAT_PART * e->context->limits->tolerance)
        return settle(e, region);
    *region = flat;
    return settle(e, region);
}

/* Gives a candidate that records what it must cover a region, and grows its ellipse. Frees the
 * candidate where the region does not keep the limits. */
static psplat_result make_candidate(const psplat_fit_context *context, const psplat_region *region,
                                    psplat_candidate *candidate) {
    const psplat_ellipse_growth growth = {.most = PSPLAT_GREATEST_NEW_GROWTH,
                                          .steps = PSPLAT_NEW_GROWTH_STEPS};
    psplat_candidate_put_nearest_first(context->samples, region->center, candidate);
    psplat_site site = psplat_site_of(region, context->samples->triangles[candidate->covered[0]]);
    psplat_fit_status status = psplat_candidate_replace(context, &site, region, 0, 0, candidate);
    if (!status && psplat_grow_ellipse_at(context, &site, &growth, candidate))
        status = PSPLAT_FIT_MEMORY;
    if (status) psplat_candidate_free(candidate);
    return status == PSPLAT_FIT_MEMORY ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* Copies the samples of a set. */
static void take_samples(const enclosed *e, const uint32_t *set) {
    const psplat_samples *samples = e->context->samples;
    for (size_t i = 0; i < e->count; ++i) {
        psplat_near_sample *sample = &e->samples[i];
        sample->index = set[i];
        sub3(sample->p, samples->positions + 3 * (size_t)set[i], e->origin);
        for (size_t k = 0; k < 3; ++k)
            sample->n[k] = (double)samples->normals[3 * (size_t)set[i] + k];
    }
}

psplat_result psplat_candidate_enclose(const psplat_fit_context *context, const uint32_t *set,
                                       size_t count, const double origin[3],
                                       const psplat_plane *plane, psplat_candidate *candidate) {
    psplat_region region;
    *candidate = (psplat_candidate){0};
    enclosed e = {.context = context,
                  .origin = origin,
                  .samples = malloc((count + 1) * sizeof *e.samples),
                  .points = malloc((count + 1) * sizeof *e.points),
                  .weights = malloc((count + 1) * sizeof *e.weights),
                  .count = count};
    uint32_t *covered = malloc((count + 1) * sizeof *covered);
    psplat_result result =
        e.samples && e.points && e.weights && covered ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    if (!result) take_samples(&e, set);
    if (!result && enclose(&e, plane, &region)) {
        memcpy(covered, set, count * sizeof *covered);
        *candidate = (psplat_candidate){.covered = covered, .covered_count = count};
        covered = NULL; /* It is the candidate's. */
        result = make_candidate(context, &region, candidate);
    }
    free(e.samples);
    free(e.points);
    free(e.weights);
    free(covered);
    return result;
}
