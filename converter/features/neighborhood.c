/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * neighborhood.c - the samples connected with a seed on the surface, nearest first.
 *
 * A flood fill over the clusters of triangles within reach of the seed, which crosses no crease,
 * collects their samples and the creases that stop it. The sums over the nearest samples are kept
 * at every BLOCK of them as far as they were asked for, so that the covariance of any number of
 * nearest samples takes few additions.
 */
#include "features/neighborhood.h"

#include "base/covariance.h"
#include "base/vector.h"
#include "features/samples.h"
#include "features/surface.h"
#include "features/triangle_flood.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 16 };

/* The digits of the radix sort. The keys are positive floats, whose bits other than the sign
 * are 31. */
enum { DIGITS = 4, DIGIT_BITS = 8, DIGIT_MASK = (1 << DIGIT_BITS) - 1 };

void psplat_neighborhood_free(psplat_neighborhood *n) {
    free(n->stamps);
    free(n->clusters);
    free(n->samples);
    free(n->along[0]);
    free(n->order);
    free(n->sorted);
    free(n->blocks);
    free(n->creases);
    free(n->crease_boxes);
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

/* Returns whether a sphere comes within reach of the metric's centre; 2 where all of it does. */
static int sphere_near(const psplat_metric *metric, const psplat_sphere *sphere, double reach) {
    double w[3], far = reach + sphere->radius, inner = reach - sphere->radius;
    psplat_metric_coordinates(metric, sphere->center, w);
    double distance2 = dot3(w, w);
    if (distance2 > far * far) return 0;
    return inner > 0 && distance2 <= inner * inner ? 2 : 1;
}

static int push_creases(psplat_neighborhood *n, const psplat_clusters *clusters, uint32_t cluster) {
    uint32_t begin = clusters->first_crease[cluster], end = clusters->first_crease[cluster + 1];
    if (begin == end) return 1;
    if (!reserve((void **)&n->creases, &n->crease_capacity, n->crease_count + (end - begin),
                 sizeof *n->creases))
        return 0;
    memcpy(n->creases + n->crease_count, clusters->creases + begin,
           (end - begin) * sizeof *n->creases);
    n->crease_count += end - begin;
    return 1;
}

/* Finds the boxes around the creases. Returns 0 when out of memory. */
static int box_creases(psplat_neighborhood *n, const psplat_mesh *mesh) {
    size_t count = (n->crease_count + PSPLAT_CREASE_BLOCK - 1) / PSPLAT_CREASE_BLOCK;
    if (!reserve((void **)&n->crease_boxes, &n->crease_box_capacity, count,
                 sizeof *n->crease_boxes))
        return 0;
    for (size_t i = 0; i < n->crease_count; ++i) {
        psplat_crease_box *block = &n->crease_boxes[i / PSPLAT_CREASE_BLOCK];
        uint32_t edge = n->creases[i], next = edge % 3 == 2 ? edge - 2 : edge + 1;
        const double *a = mesh->positions + 3 * (size_t)mesh->triangles[edge];
        const double *b = mesh->positions + 3 * (size_t)mesh->triangles[next];
        int is_first = i % PSPLAT_CREASE_BLOCK == 0;
        for (int k = 0; k < 3; ++k) {
            double low = min2(a[k], b[k]), high = max2(a[k], b[k]);
            block->low[k] = is_first ? low : min2(block->low[k], low);
            block->high[k] = is_first ? high : max2(block->high[k], high);
        }
    }
    return 1;
}

static int push_cluster(psplat_neighborhood *n, uint32_t cluster) {
    n->stamps[cluster] = n->stamp;
    if (!reserve((void **)&n->clusters, &n->cluster_capacity, n->cluster_count,
                 sizeof *n->clusters))
        return 0;
    n->clusters[n->cluster_count++] = cluster;
    return 1;
}

/* Returns a key that sorts as a squared distance does: the bits of a positive float do. */
static uint32_t rank(double distance2) {
    float value = (float)distance2;
    uint32_t key;
    memcpy(&key, &value, sizeof key);
    return key;
}

/* Takes a sample where it lies within reach. There is room for it. */
static void push_sample(psplat_neighborhood *n, const psplat_samples *samples,
                        const psplat_metric *metric, uint32_t i, double reach) {
    double w[3];
    psplat_metric_coordinates(metric, samples->positions + 3 * (size_t)i, w);
    double distance2 = dot3(w, w);
    if (distance2 <= reach * reach)
        n->order[n->count++] = (psplat_ranked){rank(distance2), i};
    else
        n->whole = 0;
}

/* Takes the samples of a cluster that lie within reach. */
static int push_samples(psplat_neighborhood *n, const psplat_samples *samples,
                        const psplat_metric *metric, uint32_t cluster, double reach) {
    uint32_t first = samples->first[cluster], end = samples->first[cluster + 1];
    if (!reserve((void **)&n->order, &n->order_capacity, n->count + (end - first),
                 sizeof *n->order))
        return 0;
    for (uint32_t b = samples->first_block[cluster]; first < end; ++b) {
        uint32_t stop = end - first > PSPLAT_BLOCK_SAMPLES ? first + PSPLAT_BLOCK_SAMPLES : end;
        if (sphere_near(metric, &samples->blocks[b], reach))
            for (uint32_t i = first; i < stop; ++i) push_sample(n, samples, metric, i, reach);
        else
            n->whole = 0;
        first = stop;
    }
    for (uint32_t i = samples->last_appended[cluster]; i != PSPLAT_NONE;
         i = samples->next_appended[i - samples->drawn]) {
        if (!reserve((void **)&n->order, &n->order_capacity, n->count, sizeof *n->order)) return 0;
        push_sample(n, samples, metric, i, reach);
    }
    return 1;
}

/* What a flood is about. */
typedef struct flood {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_metric *metric;
    double reach;
    int creases_only;
} flood;

/* Returns whether a cluster comes within reach: of a single triangle exactly, since it may be
 * large. */
static int cluster_near(const flood *f, uint32_t cluster) {
    const psplat_clusters *clusters = &f->samples->clusters;
    int near = sphere_near(f->metric, &clusters->spheres[cluster], f->reach);
    uint32_t triangle = clusters->triangles[cluster];
    if (near != 1 || triangle == PSPLAT_NONE) return near;
    return psplat_triangle_within(f->surface, f->metric, triangle, f->reach);
}

/* Takes the samples of a cluster and queues its neighbours, where it is within reach. That of the
 * first triangle is visited even where it is not: points of a cloud may be farther from their
 * triangle than that, and moved centres, too. */
static int visit(psplat_neighborhood *n, const flood *f, uint32_t cluster) {
    const psplat_clusters *clusters = &f->samples->clusters;
    if (cluster != n->clusters[0] && !cluster_near(f, cluster)) {
        n->whole = 0;
        return 1;
    }
    if (!f->creases_only && !push_samples(n, f->samples, f->metric, cluster, f->reach)) return 0;
    if (!push_creases(n, clusters, cluster)) return 0;
    for (uint32_t at = clusters->first_neighbor[cluster];
         at < clusters->first_neighbor[cluster + 1]; ++at) {
        uint32_t next = clusters->neighbors[at];
        if (n->stamps[next] != n->stamp && !push_cluster(n, next)) return 0;
    }
    return 1;
}

static int begin(psplat_neighborhood *n, const psplat_clusters *clusters, uint32_t triangle) {
    if (n->stamp_count != clusters->count) {
        free(n->stamps);
        n->stamps = calloc(clusters->count + 1, sizeof *n->stamps);
        n->stamp_count = n->stamps ? clusters->count : 0;
        n->stamp = 0;
    }
    if (!n->stamps) return 0;
    if (++n->stamp == 0) { /* The stamp wrapped around: all old ones are cleared. */
        memset(n->stamps, 0, n->stamp_count * sizeof *n->stamps);
        n->stamp = 1;
    }
    n->cluster_count = n->count = n->crease_count = 0;
    n->whole = 1;
    return push_cluster(n, clusters->of_triangles[triangle]);
}

/* Stores for each digit how many samples have a lower value of it than each one. */
static void count_digits(const psplat_neighborhood *n, uint32_t starts[][1 << DIGIT_BITS]) {
    for (size_t i = 0; i < n->count; ++i)
        for (int digit = 0; digit < DIGITS; ++digit)
            starts[digit][n->order[i].key >> digit * DIGIT_BITS & DIGIT_MASK]++;
    for (int digit = 0; digit < DIGITS; ++digit) {
        uint32_t below = 0;
        for (uint32_t value = 0; value <= DIGIT_MASK; ++value) {
            uint32_t count = starts[digit][value];
            starts[digit][value] = below;
            below += count;
        }
    }
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
    uint32_t starts[DIGITS][1 << DIGIT_BITS] = {{0}};
    count_digits(n, starts);
    for (int digit = 0; digit < DIGITS; ++digit) {
        int shift = digit * DIGIT_BITS;
        for (size_t i = 0; i < n->count; ++i)
            n->sorted[starts[digit][n->order[i].key >> shift & DIGIT_MASK]++] = n->order[i];
        psplat_ranked *order = n->order;
        n->order = n->sorted, n->sorted = order;
        size_t capacity = n->order_capacity;
        n->order_capacity = n->sorted_capacity, n->sorted_capacity = capacity;
    }
    return 1;
}

/* Makes room for the sorted samples. Returns 0 when out of memory. */
static int reserve_samples(psplat_neighborhood *n) {
    if (n->count <= n->sample_capacity && n->samples) return 1;
    size_t capacity = 2 * n->count + 64;
    free(n->samples);
    free(n->along[0]);
    free(n->blocks);
    n->samples = malloc(capacity * sizeof *n->samples);
    n->along[0] = malloc(3 * capacity * sizeof *n->along[0]);
    n->blocks = malloc((capacity / BLOCK + 2) * sizeof *n->blocks);
    n->sample_capacity = n->samples && n->along[0] && n->blocks ? capacity : 0;
    if (!n->sample_capacity) return 0;
    for (size_t k = 1; k < 3; ++k) n->along[k] = n->along[0] + k * capacity;
    return 1;
}

/* Copies the sorted samples, relative to the centre. */
static int copy_samples(psplat_neighborhood *n, const psplat_samples *samples,
                        const double origin[3]) {
    if (!reserve_samples(n)) return 0;
    for (size_t i = 0; i < n->count; ++i) {
        psplat_near_sample *s = &n->samples[i];
        s->index = n->order[i].index;
        sub3(s->p, samples->positions + 3 * (size_t)s->index, origin);
        for (size_t k = 0; k < 3; ++k) {
            s->n[k] = (double)samples->normals[3 * (size_t)s->index + k];
            n->along[k][i] = s->p[k];
        }
    }
    n->blocks[0] = (psplat_covariance){0};
    n->block_count = 1;
    return 1;
}

int psplat_neighborhood_gather(psplat_neighborhood *n, const psplat_surface *surface,
                               const psplat_samples *samples, const psplat_metric *metric,
                               uint32_t triangle, double reach, int creases_only) {
    const flood f = {surface, samples, metric, reach, creases_only};
    int ok = begin(n, &samples->clusters, triangle);
    for (size_t i = 0; ok && i < n->cluster_count; ++i) ok = visit(n, &f, n->clusters[i]);
    if (!ok || !box_creases(n, surface->mesh)) return 0;
    memcpy(n->origin, metric->center, sizeof n->origin);
    return creases_only || (sort_ranked(n) && copy_samples(n, samples, metric->center));
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

/* Adds the samples from one index to another to sums. */
static void add_samples(const psplat_neighborhood *n, size_t from, size_t to,
                        psplat_covariance *covariance) {
    for (size_t i = from; i < to; ++i)
        psplat_covariance_add(covariance, n->samples[i].p, n->samples[i].n);
}

void psplat_neighborhood_covariance(psplat_neighborhood *n, size_t count,
                                    psplat_covariance *covariance) {
    size_t whole = count / BLOCK;
    for (; n->block_count <= whole; ++n->block_count) {
        psplat_covariance *sum = &n->blocks[n->block_count];
        *sum = n->blocks[n->block_count - 1];
        add_samples(n, BLOCK * (n->block_count - 1), BLOCK * n->block_count, sum);
    }
    *covariance = n->blocks[whole];
    add_samples(n, BLOCK * whole, count, covariance);
}
