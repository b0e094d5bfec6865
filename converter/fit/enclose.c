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
#include "fit/candidate.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/grow_ellipse.h"

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

/* Makes the region of an ellipse in a plane, whose radii grow by the margin. */
static void set_region(const psplat_plane *plane, const double origin[3], const ellipse *e,
                       double height, double margin, psplat_region *region) {
    double middle = (e->shape[0] + e->shape[2]) / 2;
    double spread = hypot((e->shape[0] - e->shape[2]) / 2, e->shape[1]);
    double angle = 0.5 * atan2(2 * e->shape[1], e->shape[0] - e->shape[2]);
    *region = (psplat_region){
        .radius = {sqrt(middle + spread) + margin, sqrt(max2(middle - spread, 0)) + margin}};
    for (int k = 0; k < 3; ++k) {
        region->center[k] = origin[k] + plane->mean[k] + e->center[0] * plane->u[k] +
                            e->center[1] * plane->v[k] + height * plane->n[k];
        region->u[k] = cos(angle) * plane->u[k] + sin(angle) * plane->v[k];
    }
    memcpy(region->n, plane->n, sizeof region->n);
    cross3(region->v, region->n, region->u);
}

/* Finds the region that encloses the samples of a set, given their plane relative to origin. points
 * and weights have room for count. Returns 0 where a sample is farther from the plane than the
 * tolerance, or all lie in a row. */
static int enclose(const psplat_fit_context *context, const double *origin, const uint32_t *set,
                   size_t count, const psplat_plane *plane, double (*points)[2], double *weights,
                   psplat_region *region) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    ellipse e;
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, context->samples->positions + 3 * (size_t)set[i], origin);
        sub3(d, d, plane->mean);
        points[i][0] = dot3(d, plane->u), points[i][1] = dot3(d, plane->v);
        low = min2(low, dot3(d, plane->n));
        high = max2(high, dot3(d, plane->n));
    }
    if (high - low > 2 * context->limits->tolerance) return 0;
    if (!least_ellipse((const double(*)[2])points, count, weights, &e)) return 0;
    set_region(plane, origin, &e, (low + high) / 2, context->limits->margin, region);
    return 1;
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

psplat_result psplat_candidate_enclose(const psplat_fit_context *context, const uint32_t *set,
                                       size_t count, const double origin[3],
                                       const psplat_plane *plane, psplat_candidate *candidate) {
    psplat_region region;
    *candidate = (psplat_candidate){0};
    double(*points)[2] = malloc((count + 1) * sizeof *points);
    double *weights = malloc((count + 1) * sizeof *weights);
    uint32_t *covered = malloc((count + 1) * sizeof *covered);
    psplat_result result = points && weights && covered ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    if (!result && enclose(context, origin, set, count, plane, points, weights, &region)) {
        memcpy(covered, set, count * sizeof *covered);
        *candidate = (psplat_candidate){.covered = covered, .covered_count = count};
        covered = NULL; /* It is the candidate's. */
        result = make_candidate(context, &region, candidate);
    }
    free(points);
    free(weights);
    free(covered);
    return result;
}
