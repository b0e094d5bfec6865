/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * blend_points.c - random points of the surface, and which splats blend there.
 */
#include "finish/blend_points.h"

#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "fit/candidate.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "select/conversion.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most points, as many as the verification draws. They bound the memory of large conversions.
 */
enum { MOST_POINTS = 1000000 };

/* A fragment with its splat, before they are sorted. */
typedef struct found_hit {
    psplat_blend_hit hit;
    uint32_t splat;
} found_hit;

/* The points that a thread takes at once, and the fragments found there, in their order. */
enum { BLOCK_POINTS = 1024 };
typedef struct block {
    found_hit *found; /* count, owned */
    size_t count, capacity;
    int failed; /* memory ran out */
} block;

/* The search for the fragments at all points. */
typedef struct search {
    const psplat_measured_splats *measured;
    const psplat_samples *samples;
    double reach; /* of blends, a length */
    psplat_kernel kernel;
    block *blocks; /* block_count, owned */
    size_t block_count;
} search;

/* The search at one point. */
typedef struct point_search {
    psplat_point_blend blend;
    const psplat_kernel *kernel;
    uint32_t point;
    block *block;
} point_search;

static int visit_splat(void *user, uint32_t splat) {
    point_search *s = user;
    block *b = s->block;
    double uv[2];
    if (!psplat_measured_splats_near(s->blend.measured, splat, s->blend.point, s->blend.reach) ||
        !psplat_point_blend_meet(&s->blend, splat, uv))
        return 0;
    if (b->count == b->capacity) {
        size_t capacity = 2 * b->capacity + BLOCK_POINTS;
        found_hit *grown = realloc(b->found, capacity * sizeof *grown);
        b->failed |= !grown;
        if (!grown) return 1;
        b->found = grown;
        b->capacity = capacity;
    }
    double weight =
        exp(-(double)s->kernel->sharpness * pow(norm2(uv[0], uv[1]), (double)s->kernel->exponent));
    b->found[b->count++] =
        (found_hit){{s->point, {(float)uv[0], (float)uv[1]}, (float)max2(weight, 1e-30)}, splat};
    return 0;
}

/* Finds the fragments at the points of a block, whose normals become those of the samples. */
static void search_block(const search *s, size_t index, psplat_blend_points *points) {
    size_t begin = index * BLOCK_POINTS, end = begin + BLOCK_POINTS;
    point_search p = {.blend = {.measured = s->measured, .reach = s->reach},
                      .kernel = &s->kernel,
                      .block = &s->blocks[index]};
    for (size_t i = begin; i < end && i < s->samples->count && !p.block->failed; ++i) {
        double *normal = points->normals[i];
        for (size_t k = 0; k < 3; ++k) normal[k] = (double)s->samples->normals[3 * i + k];
        normalize3(normal);
        memcpy(p.blend.point, s->samples->positions + 3 * i, sizeof p.blend.point);
        memcpy(p.blend.normal, normal, sizeof p.blend.normal);
        p.point = (uint32_t)i;
        psplat_region_tree_visit(s->measured->region_tree, p.blend.point, visit_splat, &p);
    }
}

/* Returns 0 when out of memory. */
static int search_blocks(search *s, psplat_blend_points *points) {
    int failed = 0;
    s->block_count = (s->samples->count + BLOCK_POINTS - 1) / BLOCK_POINTS;
    s->blocks = calloc(s->block_count + 1, sizeof *s->blocks);
    if (!s->blocks) return 0;
    long end = (long)s->block_count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i) {
        search_block(s, (size_t)i, points);
        failed |= s->blocks[i].failed;
    }
    return !failed;
}

static void search_free(search *s) {
    for (size_t i = 0; s->blocks && i < s->block_count; ++i) free(s->blocks[i].found);
    free(s->blocks);
}

/* Sorts what was found by splats; those of one keep their order. first is all 0. Returns 0 when out
 * of memory. */
static int sort_hits(const search *s, size_t splats, psplat_blend_points *points) {
    size_t *first = points->first, count = 0;
    for (size_t b = 0; b < s->block_count; ++b) count += s->blocks[b].count;
    points->hits = malloc((count + 1) * sizeof *points->hits);
    if (!points->hits) return 0;
    for (size_t b = 0; b < s->block_count; ++b)
        for (size_t i = 0; i < s->blocks[b].count; ++i) ++first[s->blocks[b].found[i].splat + 1];
    for (size_t i = 0; i < splats; ++i) first[i + 1] += first[i];
    for (size_t b = 0; b < s->block_count; ++b)
        for (size_t i = 0; i < s->blocks[b].count; ++i)
            points->hits[first[s->blocks[b].found[i].splat]++] = s->blocks[b].found[i].hit;
    memmove(first + 1, first, splats * sizeof *first); /* Each is the end of its splat by now. */
    first[0] = 0;
    return 1;
}

static psplat_result find_hits(search *s, size_t splats, psplat_blend_points *points) {
    points->count = s->samples->count;
    points->normals = malloc((points->count + 1) * sizeof *points->normals);
    points->first = calloc(splats + 1, sizeof *points->first);
    if (!points->normals || !points->first) return PSPLAT_ERROR_MEMORY;
    return search_blocks(s, points) && sort_hits(s, splats, points) ? PSPLAT_OK
                                                                    : PSPLAT_ERROR_MEMORY;
}

/* Prepares the regions of the selection for a search. */
static psplat_result measure_selection(const psplat_conversion *c,
                                       psplat_measured_splats *measured) {
    const psplat_selection *selection = &c->selection;
    *measured = (psplat_measured_splats){.count = selection->count, .tolerance = c->tolerance};
    measured->regions = malloc((selection->count + 1) * sizeof *measured->regions);
    if (!measured->regions) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < selection->count; ++i)
        measured->regions[i] = selection->candidates[i].region;
    measured->region_tree =
        psplat_region_tree_create(measured->regions, selection->count, 2 * c->tolerance);
    return measured->region_tree ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

psplat_result psplat_blend_points_draw(const psplat_conversion *c, size_t per_splat, uint64_t seed,
                                       psplat_blend_points *points) {
    psplat_measured_splats measured;
    psplat_samples samples = {0};
    size_t splats = c->selection.count;
    size_t count = splats < MOST_POINTS / per_splat ? splats * per_splat : MOST_POINTS;
    *points = (psplat_blend_points){0};
    psplat_result result = measure_selection(c, &measured);
    if (!result) result = psplat_samples_draw_uniform(&c->surface, count, seed, &samples, NULL);
    if (!result) {
        psplat_samples_drop_apron(&samples, &c->surface);
        search s = {.measured = &measured,
                    .samples = &samples,
                    .reach = 2 * c->tolerance,
                    .kernel = c->kernel};
        result = find_hits(&s, splats, points);
        search_free(&s);
    }
    psplat_samples_free(&samples);
    psplat_measured_splats_free(&measured);
    if (result) psplat_blend_points_free(points);
    return result;
}

void psplat_blend_points_free(psplat_blend_points *points) {
    free(points->normals);
    free(points->hits);
    free(points->first);
    *points = (psplat_blend_points){0};
}
