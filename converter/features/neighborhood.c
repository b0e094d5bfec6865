/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * neighborhood.c - the samples connected with a seed on the surface, nearest first.
 *
 * A flood fill over the triangles within reach of the seed, which crosses no crease, collects their
 * samples and the creases that stop it. The sums over the nearest samples are kept at every BLOCK
 * of them, so that the covariance of any number of nearest samples takes fewer than BLOCK
 * additions.
 */
#include "features/neighborhood.h"

#include "base/covariance.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 16 };

/* The digits of the radix sort. The keys are positive floats, whose bits other than the sign
 * are 31. */
enum { DIGITS = 4, DIGIT_BITS = 8 };

void psplat_neighborhood_free(psplat_neighborhood *n) {
    free(n->stamps);
    free(n->triangles);
    free(n->samples);
    free(n->order);
    free(n->sorted);
    free(n->blocks);
    free(n->creases);
    *n = (psplat_neighborhood){0};
}

/* Makes room for one more than count things of this size. Returns 0 when out of memory. */
static int reserve(void **things, size_t *capacity, size_t count, size_t size) {
    if (count < *capacity) return 1;
    size_t grown = 2 * count + 64;
    void *moved = realloc(*things, grown * size);
    if (!moved) return 0;
    *things = moved;
    *capacity = grown;
    return 1;
}

static void to_metric(const psplat_metric *m, const double p[3], double w[3]) {
    double d[3];
    sub3(d, p, m->center);
    for (int k = 0; k < 3; ++k) w[k] = dot3(m->rows[k], d);
}

/* Returns whether a triangle comes within reach of the metric's centre. Mostly its first corner
 * does. */
static int triangle_near(const psplat_surface *surface, const psplat_metric *metric,
                         uint32_t triangle, double reach) {
    double corners[3][3];
    const double origin[3] = {0, 0, 0};
    for (size_t k = 0; k < 3; ++k) {
        uint32_t v = surface->mesh->triangles[3 * (size_t)triangle + k];
        to_metric(metric, surface->mesh->positions + 3 * (size_t)v, corners[k]);
        if (dot3(corners[k], corners[k]) <= reach * reach) return 1;
    }
    for (int k = 0; k < 3; ++k) {
        double low = min2(corners[0][k], min2(corners[1][k], corners[2][k]));
        double high = max2(corners[0][k], max2(corners[1][k], corners[2][k]));
        if (low > reach || high < -reach) return 0;
    }
    return point_triangle_distance2(origin, corners[0], corners[1], corners[2]) <= reach * reach;
}

static int push_crease(psplat_neighborhood *n, uint32_t edge) {
    if (!reserve((void **)&n->creases, &n->crease_capacity, n->crease_count, sizeof *n->creases))
        return 0;
    n->creases[n->crease_count++] = edge;
    return 1;
}

static int push_triangle(psplat_neighborhood *n, uint32_t triangle) {
    n->stamps[triangle] = n->stamp;
    if (!reserve((void **)&n->triangles, &n->triangle_capacity, n->triangle_count,
                 sizeof *n->triangles))
        return 0;
    n->triangles[n->triangle_count++] = triangle;
    return 1;
}

/* Returns a key that sorts as a squared distance does: the bits of a positive float do. */
static uint32_t rank(double distance2) {
    float value = (float)distance2;
    uint32_t key;
    memcpy(&key, &value, sizeof key);
    return key;
}

/* Takes the samples of a triangle that lie within reach. */
static int push_samples(psplat_neighborhood *n, const psplat_samples *samples,
                        const psplat_metric *metric, uint32_t triangle, double reach) {
    for (uint32_t at = samples->first[triangle]; at < samples->first[triangle + 1]; ++at) {
        uint32_t i = samples->order[at];
        double w[3];
        to_metric(metric, samples->positions + 3 * (size_t)i, w);
        double distance2 = dot3(w, w);
        if (distance2 > reach * reach) { /* The triangle is partly outside the reach. */
            n->whole = 0;
            continue;
        }
        if (!reserve((void **)&n->order, &n->order_capacity, n->count, sizeof *n->order)) return 0;
        n->order[n->count++] = (psplat_ranked){rank(distance2), i};
    }
    return 1;
}

/* Takes the samples of a triangle and queues its neighbours, where it is within reach. */
static int visit(psplat_neighborhood *n, const psplat_surface *surface,
                 const psplat_samples *samples, const psplat_metric *metric, uint32_t triangle,
                 double reach) {
    if (!triangle_near(surface, metric, triangle, reach)) {
        n->whole = 0;
        return 1;
    }
    if (samples && !push_samples(n, samples, metric, triangle, reach)) return 0;
    for (uint32_t k = 0; k < 3; ++k) {
        uint32_t edge = 3 * triangle + k, next = surface->neighbors[edge];
        if (surface->creases[edge]) {
            if (!push_crease(n, edge)) return 0;
        } else if (n->stamps[next] != n->stamp) {
            if (!push_triangle(n, next)) return 0;
        }
    }
    return 1;
}

static int begin(psplat_neighborhood *n, const psplat_surface *surface, uint32_t triangle) {
    if (!n->stamps) n->stamps = calloc(surface->mesh->triangle_count, sizeof *n->stamps);
    if (!n->stamps) return 0;
    if (++n->stamp == 0) { /* The stamp wrapped around: all old ones are cleared. */
        memset(n->stamps, 0, surface->mesh->triangle_count * sizeof *n->stamps);
        n->stamp = 1;
    }
    n->triangle_count = n->count = n->crease_count = 0;
    n->whole = 1;
    return push_triangle(n, triangle);
}

/* Sorts samples by distance: a radix sort from the least significant digit, so that samples at
 * equal distances keep the order of the flood. */
static int sort_ranked(psplat_neighborhood *n) {
    if (n->count > n->sorted_capacity) {
        free(n->sorted);
        n->sorted = malloc(2 * n->count * sizeof *n->sorted);
        n->sorted_capacity = n->sorted ? 2 * n->count : 0;
        if (!n->sorted) return 0;
    }
    for (int shift = 0; n->count && shift < DIGITS * DIGIT_BITS; shift += DIGIT_BITS) {
        size_t starts[(1 << DIGIT_BITS) + 1] = {0};
        const uint32_t mask = (1u << DIGIT_BITS) - 1;
        for (size_t i = 0; i < n->count; ++i) starts[(n->order[i].key >> shift & mask) + 1]++;
        for (uint32_t digit = 0; digit < mask; ++digit) starts[digit + 1] += starts[digit];
        for (size_t i = 0; i < n->count; ++i)
            n->sorted[starts[n->order[i].key >> shift & mask]++] = n->order[i];
        memcpy(n->order, n->sorted, n->count * sizeof *n->order);
    }
    return 1;
}

/* Copies the sorted samples, relative to the centre, and keeps their sums at every BLOCK. */
static int sum_up(psplat_neighborhood *n, const psplat_samples *samples, const double origin[3]) {
    size_t blocks = n->count / BLOCK + 1;
    if (n->count > n->sample_capacity || !n->samples) {
        size_t capacity = 2 * n->count + 64;
        free(n->samples);
        free(n->blocks);
        n->samples = malloc(capacity * sizeof *n->samples);
        n->blocks = malloc((capacity / BLOCK + 2) * sizeof *n->blocks);
        n->sample_capacity = n->samples && n->blocks ? capacity : 0;
        if (!n->sample_capacity) return 0;
    }
    psplat_covariance sum = {0};
    n->blocks[0] = sum;
    for (size_t i = 0; i < n->count; ++i) {
        psplat_near_sample *s = &n->samples[i];
        s->index = n->order[i].index;
        sub3(s->p, samples->positions + 3 * (size_t)s->index, origin);
        for (size_t k = 0; k < 3; ++k) s->n[k] = (double)samples->normals[3 * (size_t)s->index + k];
        psplat_covariance_add(&sum, s->p, s->n);
        if ((i + 1) % BLOCK == 0 && (i + 1) / BLOCK < blocks) n->blocks[(i + 1) / BLOCK] = sum;
    }
    return 1;
}

int psplat_neighborhood_gather(psplat_neighborhood *n, const psplat_surface *surface,
                               const psplat_samples *samples, const psplat_metric *metric,
                               uint32_t triangle, double reach) {
    int ok = begin(n, surface, triangle);
    for (size_t i = 0; ok && i < n->triangle_count; ++i)
        ok = visit(n, surface, samples, metric, n->triangles[i], reach);
    if (!ok) return 0;
    memcpy(n->origin, metric->center, sizeof n->origin);
    return !samples || (sort_ranked(n) && sum_up(n, samples, metric->center));
}

size_t psplat_neighborhood_within(const psplat_neighborhood *n, double reach) {
    size_t low = 0, high = n->count;
    uint32_t key = rank(reach * reach);
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (n->order[middle].key <= key)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

void psplat_neighborhood_covariance(const psplat_neighborhood *n, size_t count,
                                    psplat_covariance *covariance) {
    *covariance = n->blocks[count / BLOCK];
    for (size_t i = count / BLOCK * BLOCK; i < count; ++i)
        psplat_covariance_add(covariance, n->samples[i].p, n->samples[i].n);
}
