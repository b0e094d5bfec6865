/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_fit.c - least-squares fits of colours and finishes to the samples that splats cover (spec
 * eq. 4a, 4b).
 *
 * A base colour becomes a linear function over its splat where gradients are wanted and stay
 * bounded; all other values become means over the samples. Colours are linear light, in which
 * splats blend.
 */
#include "fit/color_fit.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"

#include <math.h>
#include <stdlib.h>

/* The ridge that is added to the variance of u and v, in squared radii; that of a disc full of
 * samples is 1/4. It keeps gradients small where few samples, or some in a row, say little about
 * them. Chosen by hand. */
static const double ridge = 0.001;

/* ---- least squares --------------------------------------------------------------------------- */

void psplat_moments_of(const double (*uv)[2], size_t count, int gradients, psplat_moments *m) {
    *m = (psplat_moments){.count = (double)count, .gradients = gradients};
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k) m->mean[k] += uv[i][k] / m->count;
    for (size_t i = 0; i < count; ++i) {
        double u = uv[i][0] - m->mean[0], v = uv[i][1] - m->mean[1];
        m->spread[0] += u * u / m->count, m->spread[1] += u * v / m->count;
        m->spread[2] += v * v / m->count;
    }
}

void psplat_moments_solve(const psplat_moments *m, double mean, const double along[2],
                          double fitted[3]) {
    double uu = m->spread[0] + ridge, uv = m->spread[1], vv = m->spread[2] + ridge;
    double determinant = m->count * (uu * vv - uv * uv);
    fitted[0] = mean;
    fitted[1] = fitted[2] = 0;
    if (!m->gradients) return;
    fitted[1] = (vv * along[0] - uv * along[1]) / determinant;
    fitted[2] = (uu * along[1] - uv * along[0]) / determinant;
    fitted[0] -= fitted[1] * m->mean[0] + fitted[2] * m->mean[1];
}

/* ---- one splat ------------------------------------------------------------------------------- */

/* The parameters of the samples that a candidate covers, and their moments. */
typedef struct local_samples {
    double (*uv)[2];
    size_t capacity;
    psplat_moments moments;
} local_samples;

static int find_local_samples(const psplat_samples *samples, const psplat_candidate *c,
                              int gradients, local_samples *l) {
    if (c->covered_count > l->capacity) {
        free(l->uv);
        l->capacity = 2 * c->covered_count;
        l->uv = malloc(l->capacity * sizeof *l->uv);
        if (!l->uv) l->capacity = 0;
        if (!l->uv) return 0;
    }
    for (size_t i = 0; i < c->covered_count; ++i) {
        double uvh[3];
        psplat_region_local(&c->region, samples->positions + 3 * (size_t)c->covered[i], uvh);
        l->uv[i][0] = uvh[0], l->uv[i][1] = uvh[1];
    }
    psplat_moments_of((const double(*)[2])l->uv, c->covered_count, gradients, &l->moments);
    return 1;
}

/* A value over a candidate, at[0] + u at[1] + v at[2], and the range and mean of its samples'
 * values.
 */
typedef struct fitted {
    double at[3], low, high, mean;
} fitted;

/* Fits a linear function to values of the covered samples; those of all samples are stride apart.
 */
static fitted fit_values(const psplat_candidate *c, const local_samples *l, const float *values,
                         size_t stride) {
    fitted f = {.low = HUGE_VAL, .high = -HUGE_VAL};
    double along[2] = {0, 0};
    for (size_t i = 0; i < c->covered_count; ++i) {
        double value = (double)values[c->covered[i] * stride];
        f.mean += value / l->moments.count;
        f.low = min2(f.low, value), f.high = max2(f.high, value);
        for (int k = 0; k < 2; ++k) along[k] += (l->uv[i][k] - l->moments.mean[k]) * value;
    }
    psplat_moments_solve(&l->moments, f.mean, along, f.at);
    return f;
}

/* Returns whether a fitted value stays, all over the region, about within the range of its samples.
 * A gradient from a few samples in a row may have any slope across the row. */
static int is_bounded(const fitted *f, double (*outline)[2], size_t corners) {
    double slack = (f->high - f->low) / 2 + 1.0 / 255;
    for (size_t i = 0; i < corners; ++i) {
        double value = f->at[0] + outline[i][0] * f->at[1] + outline[i][1] * f->at[2];
        if (value < f->low - slack || value > f->high + slack) return 0;
    }
    return f->at[0] >= 0 && f->at[0] <= 1;
}

static float clamp_to_unit(double value) {
    return (float)min2(max2(value, 0), 1);
}

static void fit_color(const psplat_samples *samples, const local_samples *l, psplat_candidate *c) {
    fitted f[4];
    int gradients = l->moments.gradients;
    double outline[PSPLAT_OUTLINE][2];
    size_t corners = psplat_region_polygon(&c->region, 1, outline, PSPLAT_OUTLINE);
    for (size_t k = 0; k < 4; ++k) f[k] = fit_values(c, l, samples->colors + k, 4);
    for (int k = 0; k < 3; ++k) gradients &= is_bounded(&f[k], outline, corners);
    for (int k = 0; k < 4; ++k)
        c->color[k] = clamp_to_unit(gradients && k < 3 ? f[k].at[0] : f[k].mean);
    for (int k = 0; k < 3 && gradients; ++k) {
        c->finish.color_u[k] = (float)f[k].at[1];
        c->finish.color_v[k] = (float)f[k].at[2];
    }
}

static float mean_of(const psplat_candidate *c, const float *values) {
    double sum = 0;
    for (size_t i = 0; i < c->covered_count; ++i) sum += (double)values[3 * (size_t)c->covered[i]];
    return clamp_to_unit(sum / (double)c->covered_count);
}

static const psplat_finish neutral_finish = {
    .occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};

/* Copies the colour of a sample next to its triangle to a candidate that covers no sample: a disc
 * of the last resort. */
static void copy_triangle_color(const psplat_samples *samples, psplat_candidate *c) {
    if (!samples->colors || !samples->first) return;
    uint32_t sample = psplat_samples_near_triangle(samples, c->triangle);
    if (sample == PSPLAT_NONE) return;
    const float *color = samples->colors + 4 * (size_t)sample;
    for (int k = 0; k < 4; ++k) c->color[k] = clamp_to_unit((double)color[k]);
}

static int fit_appearance(const psplat_samples *samples, int gradients, local_samples *l,
                          psplat_candidate *c) {
    for (int k = 0; k < 4; ++k) c->color[k] = 1;
    c->finish = neutral_finish;
    if (!c->covered_count) {
        copy_triangle_color(samples, c);
        return 1;
    }
    if (samples->colors) {
        if (!find_local_samples(samples, c, gradients, l)) return 0;
        fit_color(samples, l, c);
    }
    if (samples->finishes) {
        c->finish.occlusion = mean_of(c, samples->finishes);
        c->finish.roughness = mean_of(c, samples->finishes + 1);
        c->finish.metallic = mean_of(c, samples->finishes + 2);
    }
    for (int k = 0; k < 3 && samples->emissive; ++k)
        c->finish.emissive[k] = mean_of(c, samples->emissive + k);
    return 1;
}

psplat_result psplat_fit_colors(const psplat_samples *samples, int gradients,
                                psplat_candidate *candidates, size_t count) {
    long end = (long)count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        local_samples l = {0};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 64)
#endif
        for (long i = 0; i < end; ++i)
            if (candidates[i].taken)
                failed |= !fit_appearance(samples, gradients, &l, &candidates[i]);
        free(l.uv);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
