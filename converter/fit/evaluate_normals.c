/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * evaluate_normals.c - the fit of a normal field to the samples of a region, and its error.
 */
#include "base/region.h"
#include "base/vector.h"
#include "features/neighborhood.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "fit/normal_field.h"
#include "splats/quantize.h"

#include <math.h>
#include <string.h>

/* The greatest slope of the field at the centre, so that its cosine stays twice above the least
 * that spec 3.5 allows. Lines may cut the centre off, far from all samples. */
static const double greatest_center_slope = 9.9;
/* The change of slope that a field may always make over its region, and the factor of the samples'
 * own spread that it may make besides. Both were chosen by hand. */
static const double harmless_change = 0.05;
static const double greatest_spread_factor = 2;

/* Finds the local normals (x, y) with third coordinate 1 of covered samples, into
 * scratch->slopes. */
static void find_slopes(const psplat_fit_context *context, const psplat_region *region,
                        size_t count) {
    psplat_scratch *s = context->scratch;
    const float *turned = context->samples->turned;
    for (size_t i = 0; i < count; ++i) {
        const psplat_near_sample *sample = &s->near.samples[s->covered[i]];
        double n[3];
        for (size_t k = 0; k < 3; ++k)
            n[k] = turned ? (double)turned[3 * (size_t)sample->index + k] : sample->n[k];
        double height = max2(dot3(n, region->n), PSPLAT_LEAST_COVERED_COSINE);
        s->slopes[i][0] = dot3(n, region->u) / height;
        s->slopes[i][1] = dot3(n, region->v) / height;
    }
}

/* Returns the greatest angle between the field and the normals of covered samples, in radians. */
static double greatest_error(const psplat_scratch *s, const psplat_evaluation *e) {
    double greatest = 0;
    for (size_t i = 0; i < e->count; ++i) {
        double a[3] = {s->slopes[i][0], s->slopes[i][1], 1}, b[3] = {0, 0, 1}, c[3];
        psplat_normal_field_at(e->field, e->region.radius, s->uv[i], b);
        cross3(c, a, b);
        greatest = max2(greatest, atan2(length3(c), dot3(a, b)));
    }
    return greatest;
}

/* Returns whether the field stays near the samples' mean all over the region. A gradient from a few
 * samples in a row may have any slope across the row. */
static int is_bounded(const psplat_scratch *s, const psplat_evaluation *e, const double mean[2]) {
    double spread = 0, outline[PSPLAT_OUTLINE][2];
    for (size_t i = 0; i < e->count; ++i)
        spread = max2(spread, norm2(s->slopes[i][0] - mean[0], s->slopes[i][1] - mean[1]));
    size_t corners = psplat_region_polygon(&e->region, 1, outline, PSPLAT_OUTLINE);
    for (size_t i = 0; i < corners; ++i) {
        double xy[2];
        psplat_normal_field_at(e->field, e->region.radius, outline[i], xy);
        if (norm2(xy[0] - mean[0], xy[1] - mean[1]) >
            greatest_spread_factor * spread + harmless_change)
            return 0;
    }
    return 1;
}

/* Sets the field to the normals of the region's surface (spec 3.4). */
static void set_field_of_surface(psplat_evaluation *e) {
    const psplat_region *r = &e->region;
    const double field[5] = {-r->slope[0], -r->slope[1], -r->hessian[0] * r->radius[0],
                             -r->hessian[2] * r->radius[1], -r->hessian[1] * r->radius[0]};
    memcpy(e->field, field, sizeof field);
}

static void fit_field(const psplat_fit_context *context, psplat_evaluation *e) {
    const psplat_scratch *s = context->scratch;
    const psplat_limits *limits = context->limits;
    double mean[2] = {0, 0};
    for (size_t i = 0; i < e->count; ++i)
        for (int k = 0; k < 2; ++k) mean[k] += s->slopes[i][k] / (double)e->count;
    if (!limits->constant_normals)
        psplat_fit_normal_field((const double(*)[2])s->uv, (const double(*)[2])s->slopes, e->count,
                                e->region.radius, e->field);
    if (limits->constant_normals || !is_bounded(s, e, mean)) {
        e->field[0] = mean[0], e->field[1] = mean[1];
        e->field[2] = e->field[3] = e->field[4] = 0;
    }
    if (limits->precision) psplat_quantize_field(limits->precision, e->field);
}

psplat_fit_status psplat_evaluate_normals(const psplat_fit_context *context, psplat_evaluation *e) {
    double tolerance = context->limits->normal_tolerance;
    find_slopes(context, &e->region, e->count);
    if (psplat_region_is_curved(&e->region) && !context->samples->turned)
        set_field_of_surface(e);
    else
        fit_field(context, e);
    if (norm2(e->field[0], e->field[1]) > greatest_center_slope) return PSPLAT_FIT_NORMALS_DIFFER;
    if (!(tolerance > 0)) return PSPLAT_FIT_KEPT;
    e->normal_error = greatest_error(context->scratch, e);
    return e->normal_error <= tolerance ? PSPLAT_FIT_KEPT : PSPLAT_FIT_NORMALS_DIFFER;
}
