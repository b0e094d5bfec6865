/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tint.c - colours and materials of splats: least squares over what their samples look like, as
 * fit.c does for normals (spec eq. 4a, 4b). Numbers are linear light, in which splats blend.
 */
#include "stages.h"
#include "vector.h"

#include <string.h>

/* Added to the spread of parameters: few samples, or some in a row, say little about a gradient. A
 * disc full of samples has 1/4. */
static const double ridge = 0.01;
/* Corners of a region's outline at which a gradient is tried. */
enum { OUTLINE = 16 + PSPLAT_MAX_CLIP_LINES };

/* Sums over the samples that a candidate covers. */
typedef struct moments {
    double count, mean[2], spread[3]; /* of (u, v): about the mean: uu uv vv */
} moments;

static void local_of(const psplat_samples *samples, const psplat_candidate *candidate, size_t i,
                     double uvh[3]) {
    psplat_region_local(&candidate->region, samples->positions + 3 * (size_t)candidate->covered[i],
                        uvh);
}

static moments moments_of(const psplat_samples *samples, const psplat_candidate *candidate) {
    moments m = {.count = (double)candidate->covered_count};
    double uvh[3];
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        local_of(samples, candidate, i, uvh);
        for (int k = 0; k < 2; ++k) m.mean[k] += uvh[k] / m.count;
    }
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        local_of(samples, candidate, i, uvh);
        double u = uvh[0] - m.mean[0], v = uvh[1] - m.mean[1];
        m.spread[0] += u * u / m.count, m.spread[1] += u * v / m.count;
        m.spread[2] += v * v / m.count;
    }
    return m;
}

/* A value over a candidate: at[0] + u at[1] + v at[2], and the least and greatest of its samples.
 */
typedef struct fitted {
    double at[3], low, high, mean;
} fitted;

/* values: of samples, stride apart. */
static fitted fit(const psplat_samples *samples, const psplat_candidate *candidate,
                  const moments *m, const float *values, size_t stride) {
    fitted f = {.low = HUGE_VAL, .high = -HUGE_VAL};
    double along[2] = {0, 0};
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        double value = (double)values[candidate->covered[i] * stride], uvh[3];
        local_of(samples, candidate, i, uvh);
        f.mean += value / m->count;
        f.low = min2(f.low, value), f.high = max2(f.high, value);
        for (int k = 0; k < 2; ++k) along[k] += (uvh[k] - m->mean[k]) * value / m->count;
    }
    double uu = m->spread[0] + ridge, uv = m->spread[1], vv = m->spread[2] + ridge;
    double determinant = uu * vv - uv * uv;
    f.at[1] = (vv * along[0] - uv * along[1]) / determinant;
    f.at[2] = (uu * along[1] - uv * along[0]) / determinant;
    f.at[0] = f.mean - f.at[1] * m->mean[0] - f.at[2] * m->mean[1];
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

static void tint_color(const psplat_samples *samples, const moments *m, int gradients,
                       psplat_candidate *c) {
    fitted f[4];
    double outline[OUTLINE][2];
    size_t corners = psplat_region_polygon(&c->region, 1, outline, OUTLINE);
    for (size_t k = 0; k < 4; ++k) f[k] = fit(samples, c, m, samples->colors + k, 4);
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

static void tint(const psplat_samples *samples, int gradients, psplat_candidate *c) {
    for (int k = 0; k < 4; ++k) c->color[k] = 1;
    c->finish = plain;
    if (!c->covered_count) return;
    moments m = moments_of(samples, c);
    if (samples->colors) tint_color(samples, &m, gradients, c);
    if (samples->finishes) {
        c->finish.occlusion = mean_of(c, samples->finishes);
        c->finish.roughness = mean_of(c, samples->finishes + 1);
        c->finish.metallic = mean_of(c, samples->finishes + 2);
    }
    for (int k = 0; k < 3 && samples->emissive; ++k)
        c->finish.emissive[k] = mean_of(c, samples->emissive + k);
}

void psplat_tint(const psplat_samples *samples, int gradients, psplat_selection *selection) {
    long count = (long)selection->count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 64)
#endif
    for (long i = 0; i < count; ++i)
        if (selection->candidates[i].taken) tint(samples, gradients, &selection->candidates[i]);
}
