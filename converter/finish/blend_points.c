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

/* The search for the fragments at one point after another. */
typedef struct search {
    psplat_point_blend blend;
    psplat_kernel kernel;
    uint32_t point;
    found_hit *found; /* count, owned */
    size_t count, capacity;
    int failed; /* memory ran out */
} search;

static int visit_splat(void *user, uint32_t splat) {
    search *s = user;
    double uv[2];
    if (!psplat_measured_splats_near(s->blend.measured, splat, s->blend.point, s->blend.reach) ||
        !psplat_point_blend_meet(&s->blend, splat, uv))
        return 0;
    if (s->count == s->capacity) {
        size_t capacity = 2 * s->capacity + 1024;
        found_hit *grown = realloc(s->found, capacity * sizeof *grown);
        s->failed |= !grown;
        if (!grown) return 1;
        s->found = grown;
        s->capacity = capacity;
    }
    double weight =
        exp(-(double)s->kernel.sharpness * pow(norm2(uv[0], uv[1]), (double)s->kernel.exponent));
    s->found[s->count++] =
        (found_hit){{s->point, {(float)uv[0], (float)uv[1]}, (float)max2(weight, 1e-30)}, splat};
    return 0;
}

/* Finds the fragments at all samples, whose normals become those of the points. */
static void search_points(search *s, const psplat_samples *samples, psplat_blend_points *points) {
    for (size_t i = 0; i < samples->count && !s->failed; ++i) {
        double *normal = points->normals[i];
        for (size_t k = 0; k < 3; ++k) normal[k] = (double)samples->normals[3 * i + k];
        normalize3(normal);
        memcpy(s->blend.point, samples->positions + 3 * i, sizeof s->blend.point);
        memcpy(s->blend.normal, normal, sizeof s->blend.normal);
        s->point = (uint32_t)i;
        psplat_region_tree_visit(s->blend.measured->region_tree, s->blend.point, visit_splat, s);
    }
}

/* Sorts what was found by splats; those of one keep their order. first is all 0. */
static void sort_hits(const search *s, size_t splats, psplat_blend_points *points) {
    size_t *first = points->first;
    for (size_t i = 0; i < s->count; ++i) ++first[s->found[i].splat + 1];
    for (size_t i = 0; i < splats; ++i) first[i + 1] += first[i];
    for (size_t i = 0; i < s->count; ++i)
        points->hits[first[s->found[i].splat]++] = s->found[i].hit;
    memmove(first + 1, first, splats * sizeof *first); /* Each is the end of its splat by now. */
    first[0] = 0;
}

static psplat_result find_hits(search *s, const psplat_samples *samples, size_t splats,
                               psplat_blend_points *points) {
    points->count = samples->count;
    points->normals = malloc((samples->count + 1) * sizeof *points->normals);
    points->first = calloc(splats + 1, sizeof *points->first);
    if (!points->normals || !points->first) return PSPLAT_ERROR_MEMORY;
    search_points(s, samples, points);
    if (s->failed) return PSPLAT_ERROR_MEMORY;
    points->hits = malloc((s->count + 1) * sizeof *points->hits);
    if (!points->hits) return PSPLAT_ERROR_MEMORY;
    sort_hits(s, splats, points);
    return PSPLAT_OK;
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
        search s = {.blend = {.measured = &measured, .reach = 2 * c->tolerance},
                    .kernel = c->kernel};
        result = find_hits(&s, &samples, splats, points);
        free(s.found);
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
