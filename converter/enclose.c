/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * enclose.c - a candidate around given samples.
 *
 * Plane from their covariance, outline from their least enclosing ellipse, which unlike that of the
 * covariance does not ask how many of them are where.
 */
#include "trial.h"

#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Of the least ellipse: steps, and how much farther than it may the farthest point lie (squared).
 */
enum { STEPS = 40, WIDENINGS = 3 };
static const double excess = 1.025;
/* The farthest points lie on the ellipse: so much more keeps them inside in any frame. */
static const double rounding = 1e-9;

/* How far an ellipse widens at most. */
static const double greatest_widening = 1.4;

/* An ellipse in a plane: points p with (p - center)^T shape^-1 (p - center) <= 1, shape xx xy yy.
 */
typedef struct ellipse {
    double center[2], shape[3];
} ellipse;

/* The least ellipse around points, nearly: Titterington's (1978) multiplicative weights. weights
 * has room for count. Returns 0 where the points do not span one. */
static int least_ellipse(const double (*points)[2], size_t count, double *weights, ellipse *e) {
    for (size_t i = 0; i < count; ++i) weights[i] = 1 / (double)count;
    for (int step = 0; step < STEPS; ++step) {
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
        double scale = farthest * (1 + rounding);
        *e = (ellipse){{x, y}, {xx * scale, xy * scale, yy * scale}};
        if (farthest <= 2 * excess) break;
        for (size_t i = 0; i < count; ++i) weights[i] /= total;
    }
    return 1;
}

/* A plane's frame turned to an ellipse, which is made larger by a margin. */
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

/* The region around samples, relative to origin; points and weights have room for them. Returns 0
 * where the tolerance does not hold them, or they lie in a row. */
static int enclose(const psplat_samples *samples, const psplat_limits *limits, const double *origin,
                   const uint32_t *set, size_t count, const psplat_plane *plane,
                   double (*points)[2], double *weights, psplat_region *region) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    ellipse e;
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, samples->positions + 3 * (size_t)set[i], origin);
        sub3(d, d, plane->mean);
        points[i][0] = dot3(d, plane->u), points[i][1] = dot3(d, plane->v);
        low = min2(low, dot3(d, plane->n));
        high = max2(high, dot3(d, plane->n));
    }
    if (high - low > 2 * limits->tolerance) return 0;
    if (!least_ellipse((const double(*)[2])points, count, weights, &e)) return 0;
    set_region(plane, origin, &e, (low + high) / 2, limits->margin, region);
    return 1;
}

/* Moves the sample nearest to the middle of the region to the front of the set. */
static void middle_first(const psplat_samples *samples, const psplat_region *region, uint32_t *set,
                         size_t count) {
    double least = HUGE_VAL;
    size_t nearest = 0;
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, samples->positions + 3 * (size_t)set[i], region->center);
        if (dot3(d, d) < least) least = dot3(d, d), nearest = i;
    }
    uint32_t first = set[0];
    set[0] = set[nearest];
    set[nearest] = first;
}

psplat_result psplat_candidate_enclose(const psplat_surface *surface, const psplat_samples *samples,
                                       const psplat_limits *limits, const uint32_t *set,
                                       size_t count, const double origin[3],
                                       const psplat_plane *plane, psplat_growth *growth,
                                       psplat_candidate *candidate) {
    psplat_region region;
    *candidate = (psplat_candidate){0};
    double(*points)[2] = malloc((count + 1) * sizeof *points);
    double *weights = malloc((count + 1) * sizeof *weights);
    uint32_t *covered = malloc((count + 1) * sizeof *covered);
    int failed = !points || !weights || !covered;
    int kept =
        !failed && enclose(samples, limits, origin, set, count, plane, points, weights, &region);
    if (kept) {
        memcpy(covered, set, count * sizeof *covered);
        middle_first(samples, &region, covered, count);
        *candidate = (psplat_candidate){.covered = covered, .covered_count = count};
        psplat_seedling s = psplat_trial_at(surface, samples, limits, growth, &region,
                                            samples->triangles[covered[0]]);
        kept = psplat_trial_accept(&s, &region, 0, candidate);
        if (kept) psplat_trial_widen(&s, candidate, greatest_widening, WIDENINGS);
        failed = s.failed;
        covered = NULL;
    }
    if (!kept || failed) psplat_candidate_free(candidate);
    free(points);
    free(weights);
    free(covered);
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
