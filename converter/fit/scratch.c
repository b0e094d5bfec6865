/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * scratch.c - the memory of the threads that evaluate candidates, and the loop that runs them.
 */
#include "features/neighborhood.h"
#include "fit/evaluate.h"
#include "fit/fit_context.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>

/* How far the file's own normals may move fits off the surface, in tolerances. Chosen by hand. */
static const double most_pull_tolerances = 0.1;

static void free_samples(psplat_scratch *s) {
    free(s->uvh);
    free(s->covered);
    free(s->cells);
    free(s->sorted);
    free(s->uv);
    free(s->slopes);
    free(s->heights);
}

void psplat_scratch_free(psplat_scratch *scratch) {
    psplat_neighborhood_free(&scratch->near);
    free_samples(scratch);
    free(scratch->segments);
    *scratch = (psplat_scratch){0};
}

static int reserve_samples(psplat_scratch *s) {
    size_t count = s->near.count + 1;
    if (count <= s->capacity) return 1;
    size_t capacity = 2 * count + 256;
    free_samples(s);
    s->uvh = malloc(capacity * sizeof *s->uvh);
    s->covered = malloc(capacity * sizeof *s->covered);
    s->cells = malloc(capacity * sizeof *s->cells);
    s->sorted = malloc(capacity * sizeof *s->sorted);
    s->uv = malloc(capacity * sizeof *s->uv);
    s->slopes = malloc(capacity * sizeof *s->slopes);
    s->heights = malloc(capacity * sizeof *s->heights);
    int all = s->uvh && s->covered && s->cells && s->sorted && s->uv && s->slopes && s->heights;
    s->capacity = all ? capacity : 0;
    return all;
}

static int reserve_segments(psplat_scratch *s) {
    if (s->near.crease_count <= s->segment_capacity) return 1;
    size_t capacity = 2 * s->near.crease_count;
    free(s->segments);
    s->segments = malloc(capacity * sizeof *s->segments);
    s->segment_capacity = s->segments ? capacity : 0;
    return s->segment_capacity > 0;
}

psplat_result psplat_scratch_reserve(psplat_scratch *scratch) {
    return reserve_samples(scratch) && reserve_segments(scratch) ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

psplat_fit_context psplat_fit_draft(const psplat_fit_context *context, psplat_limits *draft) {
    psplat_fit_context result = *context;
    *draft = *context->limits;
    if (draft->proven && draft->measured_tolerance > 0)
        draft->tolerance = draft->measured_tolerance;
    draft->proven = 0;
    result.limits = draft;
    return result;
}

double psplat_most_normal_pull(const psplat_fit_context *context) {
    const psplat_surface *surface = context->surface;
    int are_others = surface->mesh->corner_normals || surface->facet_edges;
    return are_others ? most_pull_tolerances * context->limits->tolerance : HUGE_VAL;
}

psplat_result psplat_fit_each(const psplat_fit_context *context, size_t count,
                              psplat_result (*visit)(const psplat_fit_context *context,
                                                     size_t index, void *user),
                              void *user) {
    long end = (long)count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        psplat_scratch scratch = {0};
        psplat_fit_context own = *context;
        own.scratch = &scratch;
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 4)
#endif
        for (long i = 0; i < end; ++i) failed |= visit(&own, (size_t)i, user) != PSPLAT_OK;
        psplat_scratch_free(&scratch);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
