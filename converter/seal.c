/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * seal.c - cracks that open to slanted views.
 *
 * Splats that cover a surface as seen along its normals may still let a slanted view pass between
 * two of them where they lie at different heights. Fresh samples are looked at from the side; where
 * the view meets no splat, splats are added that keep half of the tolerance, near enough to
 * the surface to stand in the way.
 */
#include "stages.h"

#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 2, BATCH = 48, FRESH = 4, LEAST_FRESH = 50000 };

static const double tight_part = 0.5;
static const uint64_t seal_seed = 0x7365616c00000000u;

/* Indices, in the samples they were appended to, of fresh samples that stand last in their
 * triangles' groups. triangles: that of each, ascending. */
static void find_appended(const psplat_samples *samples, const uint32_t *triangles, size_t count,
                          uint32_t *indices) {
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && triangles[end] == triangles[begin];) ++end;
        uint32_t first = samples->first[triangles[begin] + 1] - (uint32_t)(end - begin);
        for (size_t i = begin; i < end; ++i) indices[i] = first + (uint32_t)(i - begin);
    }
}

/* Fresh samples that a slanted view passes by, appended to the samples; indices is malloc'ed. */
static psplat_result find_cracks(const psplat_seal *seal, uint64_t seed, uint32_t **indices,
                                 size_t *count) {
    psplat_samples fresh;
    size_t wanted = FRESH * seal->samples->count, found = 0;
    if (wanted < LEAST_FRESH) wanted = LEAST_FRESH;
    psplat_result result = psplat_samples_draw_uniform(seal->surface, wanted, seed, &fresh, NULL);
    if (result) return result;
    uint8_t *open = malloc(fresh.count + 1);
    uint32_t *chosen = malloc((fresh.count + 1) * sizeof *chosen);
    *indices = malloc((fresh.count + 1) * sizeof **indices);
    result = PSPLAT_ERROR_MEMORY;
    if (open && chosen && *indices)
        result = psplat_verify_sight(&fresh, seal->splats, seal->tolerance, open, count);
    for (uint32_t i = 0; !result && i < fresh.count; ++i)
        if (open[i]) chosen[found++] = i;
    if (found)
        result = psplat_samples_append(seal->samples, &fresh, chosen, found,
                                       seal->surface->mesh->triangle_count, NULL);
    if (found && !result) {
        for (size_t i = 0; i < found; ++i) chosen[i] = fresh.triangles[chosen[i]];
        find_appended(seal->samples, chosen, found, *indices);
    }
    free(open);
    free(chosen);
    psplat_samples_free(&fresh);
    return result;
}

/* Grows a candidate around each of count seeds. */
static psplat_result grow_batch(const psplat_seal *seal, const psplat_limits *limits,
                                const uint32_t *seeds, long count, psplat_candidate *grown) {
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel reduction(| : failed)
#endif
    {
        psplat_growth growth = {0};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 2)
#endif
        for (long i = 0; i < count; ++i)
            failed |= psplat_candidate_grow(seal->surface, seal->samples, limits, seeds[i], &growth,
                                            &grown[i]) != PSPLAT_OK;
        psplat_growth_free(&growth);
    }
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}

/* Adds the candidates whose seeds no earlier one covers. done: a flag for each sample. */
static psplat_result take_batch(const psplat_seal *seal, const uint32_t *seeds, long count,
                                psplat_candidate *grown, uint8_t *done) {
    for (long i = 0; i < count; ++i) {
        if (done[seeds[i]]) continue;
        for (size_t k = 0; k < grown[i].covered_count; ++k) done[grown[i].covered[k]] = 1;
        if (!psplat_selection_push(seal->selection, &grown[i])) return PSPLAT_ERROR_MEMORY;
    }
    return PSPLAT_OK;
}

static psplat_result seal_samples(const psplat_seal *seal, const uint32_t *indices, size_t count) {
    psplat_limits limits = *seal->limits;
    limits.tolerance *= tight_part;
    uint8_t *done = calloc(seal->samples->count, 1);
    psplat_result result = done ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (size_t next = 0; !result && next < count;) {
        uint32_t seeds[BATCH];
        psplat_candidate grown[BATCH];
        long batch = 0;
        memset(grown, 0, sizeof grown);
        for (; next < count && batch < BATCH; ++next)
            if (!done[indices[next]]) seeds[batch++] = indices[next];
        result = grow_batch(seal, &limits, seeds, batch, grown);
        if (!result) result = take_batch(seal, seeds, batch, grown, done);
        for (long i = 0; i < batch; ++i) psplat_candidate_free(&grown[i]);
    }
    free(done);
    return result;
}

psplat_result psplat_seal_cracks(const psplat_seal *seal, psplat_splats *splats) {
    psplat_result result = PSPLAT_OK;
    for (int round = 0; round < ROUNDS && !result; ++round) {
        uint32_t *indices = NULL;
        size_t count = 0;
        result = find_cracks(seal, seal->seed + seal_seed + (uint64_t)round, &indices, &count);
        if (!result && count) result = seal_samples(seal, indices, count);
        free(indices);
        if (!result && count)
            result = psplat_store_splats(seal->selection, seal->samples->colors != NULL, splats);
        if (!count) break;
    }
    return result;
}
