/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tint.c - colours and materials of splats: least squares over what their samples look like, as
 * fit.c does for normals (spec eq. 4a, 4b). Numbers are linear light, in which splats blend.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>

/* Added to the spread of parameters: few samples, or some in a row, say little about a gradient. A
 * disc full of samples has 1/4. */
static const double ridge = 0.001;
/* Corners of a region's outline at which a gradient is tried. */
enum { OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES };

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

/* Parameters of the samples that a candidate covers, of which most is known for the moments. */
typedef struct local {
    double (*uv)[2];
    size_t capacity;
    psplat_moments moments;
} local;

static int find_local(const psplat_samples *samples, const psplat_candidate *c, int gradients,
                      local *l) {
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

/* A value over a candidate: at[0] + u at[1] + v at[2], and the least and greatest of its samples.
 */
typedef struct fitted {
    double at[3], low, high, mean;
} fitted;

/* values: of samples, stride apart. */
static fitted fit(const psplat_candidate *c, const local *l, const float *values, size_t stride) {
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

/* Whether a fitted value stays all over the region about as far as its samples go: what a few of
 * them in a row say may be anything beside the row. */
static int is_tame(const fitted *f, double (*outline)[2], size_t corners) {
    double slack = (f->high - f->low) / 2 + 1.0 / 255;
    for (size_t i = 0; i < corners; ++i) {
        double value = f->at[0] + outline[i][0] * f->at[1] + outline[i][1] * f->at[2];
        if (value < f->low - slack || value > f->high + slack) return 0;
    }
    return f->at[0] >= 0 && f->at[0] <= 1;
}

static float unit(double value) {
    return (float)min2(max2(value, 0), 1);
}

static void tint_color(const psplat_samples *samples, const local *l, psplat_candidate *c) {
    fitted f[4];
    int gradients = l->moments.gradients;
    double outline[OUTLINE][2];
    size_t corners = psplat_region_polygon(&c->region, 1, outline, OUTLINE);
    for (size_t k = 0; k < 4; ++k) f[k] = fit(c, l, samples->colors + k, 4);
    for (int k = 0; k < 3; ++k) gradients &= is_tame(&f[k], outline, corners);
    for (int k = 0; k < 4; ++k) c->color[k] = unit(gradients && k < 3 ? f[k].at[0] : f[k].mean);
    for (int k = 0; k < 3 && gradients; ++k) {
        c->finish.color_u[k] = (float)f[k].at[1];
        c->finish.color_v[k] = (float)f[k].at[2];
    }
}

static float mean_of(const psplat_candidate *c, const float *values) {
    double sum = 0;
    for (size_t i = 0; i < c->covered_count; ++i) sum += (double)values[3 * (size_t)c->covered[i]];
    return unit(sum / (double)c->covered_count);
}

static const psplat_finish plain = {
    .occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};

/* A last resort that covers nothing by the measure of others looks like a sample of its triangle.
 */
static void tint_as_triangle(const psplat_samples *samples, psplat_candidate *c) {
    if (!samples->colors || !samples->first) return;
    uint32_t at = samples->first[c->triangle];
    if (at == samples->first[c->triangle + 1]) return;
    const float *color = samples->colors + 4 * (size_t)samples->order[at];
    for (int k = 0; k < 4; ++k) c->color[k] = unit((double)color[k]);
}

static int tint(const psplat_samples *samples, int gradients, local *l, psplat_candidate *c) {
    for (int k = 0; k < 4; ++k) c->color[k] = 1;
    c->finish = plain;
    if (!c->covered_count) {
        tint_as_triangle(samples, c);
        return 1;
    }
    if (samples->colors) {
        if (!find_local(samples, c, gradients, l)) return 0;
        tint_color(samples, l, c);
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

psplat_result psplat_tint(const psplat_samples *samples, int gradients,
                          psplat_selection *selection) {
    long count = (long)selection->count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        local l = {0};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 64)
#endif
        for (long i = 0; i < count; ++i)
            if (selection->candidates[i].taken)
                failed |= !tint(samples, gradients, &l, &selection->candidates[i]);
        free(l.uv);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
