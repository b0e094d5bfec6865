/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * select.c - a small set of candidates that covers every sample.
 *
 * Greedy cover (Wu, Kobbelt 2004, section 4) over a pool that grows as it goes: each round grows
 * candidates around samples not yet covered and takes the pool's best as long as they gain nearly
 * as much as the round's first. Rounds are of fixed size and seeds are drawn before growing, so
 * that the result does not depend on the number of threads.
 */
#include "stages.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUND = 96 };

/* A candidate is taken while it gains this part of the round's best. */
static const double worth_taking = 0.8;

typedef struct pool_entry {
    psplat_candidate candidate;
    size_t gain; /* samples it would newly cover; an upper bound between updates */
} pool_entry;

typedef struct selector {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    psplat_selection *selection;
    pool_entry *pool;
    size_t pool_count, pool_capacity;
    uint16_t *covers; /* per sample: selected candidates covering it, saturating */
    uint32_t *open;   /* samples in random order; those before open_count may be uncovered */
    size_t open_count;
    size_t uncovered;
    uint64_t random;
} selector;

void psplat_selection_free(psplat_selection *selection) {
    for (size_t i = 0; i < selection->count; ++i) psplat_candidate_free(&selection->candidates[i]);
    free(selection->candidates);
    *selection = (psplat_selection){0};
}

static void count_cover(selector *s, const psplat_candidate *candidate, int step) {
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint16_t *count = &s->covers[candidate->covered[i]];
        if (step > 0) {
            s->uncovered -= *count == 0;
            if (*count < UINT16_MAX) ++*count;
        } else if (*count < UINT16_MAX) {
            --*count; /* a saturated count stays: it only keeps a candidate too many */
        }
    }
}

static size_t gain_of(const selector *s, const psplat_candidate *candidate) {
    size_t gain = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i)
        gain += s->covers[candidate->covered[i]] == 0;
    return gain;
}

int psplat_selection_push(psplat_selection *selection, psplat_candidate *candidate) {
    if (selection->count == selection->capacity) {
        size_t capacity = 2 * selection->capacity + 64;
        void *grown = realloc(selection->candidates, capacity * sizeof(psplat_candidate));
        if (!grown) return 0;
        selection->candidates = grown;
        selection->capacity = capacity;
    }
    selection->candidates[selection->count++] = *candidate;
    *candidate = (psplat_candidate){0};
    return 1;
}

psplat_result psplat_selection_refresh(const psplat_surface *surface, const psplat_samples *samples,
                                       const psplat_limits *limits, psplat_selection *selection) {
    psplat_growth growth = {0};
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < selection->count && !result; ++i)
        result =
            psplat_candidate_cover(surface, samples, limits, &growth, &selection->candidates[i]);
    psplat_growth_free(&growth);
    return result;
}

/* ---- pool ---------------------------------------------------------------------------------- */

/* Uncovered samples to grow from: the next of the random order. */
static size_t draw_seeds(selector *s, uint32_t seeds[ROUND]) {
    size_t count = 0, kept = 0, i = 0;
    for (; i < s->open_count && count < ROUND; ++i)
        if (!s->covers[s->open[i]]) seeds[count++] = s->open[i];
    /* Drawn seeds go to the back: they were tried, but may remain uncovered. */
    for (size_t rest = i; rest < s->open_count; ++rest) s->open[kept++] = s->open[rest];
    for (size_t k = 0; k < count; ++k) s->open[kept++] = seeds[k];
    s->open_count = kept;
    return count;
}

static int pool_reserve(selector *s, size_t count) {
    if (count <= s->pool_capacity) return 1;
    size_t capacity = 2 * count;
    void *grown = realloc(s->pool, capacity * sizeof(pool_entry));
    if (!grown) return 0;
    s->pool = grown;
    s->pool_capacity = capacity;
    return 1;
}

static psplat_result pool_grow(selector *s) {
    uint32_t seeds[ROUND];
    psplat_candidate grown[ROUND];
    psplat_result results[ROUND];
    long count = (long)draw_seeds(s, seeds);
#if defined(_OPENMP)
#pragma omp parallel
#endif
    {
        psplat_growth growth = {0};
#if defined(_OPENMP)
#pragma omp for schedule(dynamic, 2)
#endif
        for (long i = 0; i < count; ++i)
            results[i] = psplat_candidate_grow(s->surface, s->samples, s->limits, seeds[i], &growth,
                                               &grown[i]);
        psplat_growth_free(&growth);
    }
    psplat_result result = pool_reserve(s, s->pool_count + ROUND) ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    for (long i = 0; i < count; ++i) {
        if (results[i]) result = results[i];
        if (result)
            psplat_candidate_free(&grown[i]);
        else
            s->pool[s->pool_count++] = (pool_entry){grown[i], grown[i].covered_count};
    }
    return result;
}

static int compare_entries(const void *left, const void *right) {
    const pool_entry *a = left, *b = right;
    if (a->gain != b->gain) return a->gain > b->gain ? -1 : 1;
    /* Regions differ where gains do not; the order must not depend on addresses. */
    return memcmp(a->candidate.region.center, b->candidate.region.center, sizeof(double[3]));
}

/* Recounts all gains, drops entries without any, and sorts the best first. */
static void pool_update(selector *s) {
    size_t kept = 0;
    for (size_t i = 0; i < s->pool_count; ++i) {
        s->pool[i].gain = gain_of(s, &s->pool[i].candidate);
        if (s->pool[i].gain)
            s->pool[kept++] = s->pool[i];
        else
            psplat_candidate_free(&s->pool[i].candidate);
    }
    s->pool_count = kept;
    if (kept) qsort(s->pool, s->pool_count, sizeof(pool_entry), compare_entries);
}

static int pool_take(selector *s) {
    size_t least = (size_t)ceil(worth_taking * (double)s->pool[0].gain);
    for (size_t i = 0; i < s->pool_count; ++i) {
        pool_entry *entry = &s->pool[i];
        if (entry->gain < least) break;
        entry->gain = gain_of(s, &entry->candidate);
        if (entry->gain < least || entry->gain == 0) continue;
        count_cover(s, &entry->candidate, 1);
        if (!psplat_selection_push(s->selection, &entry->candidate)) return 0;
    }
    return 1;
}

static void pool_free(selector *s) {
    for (size_t i = 0; i < s->pool_count; ++i) psplat_candidate_free(&s->pool[i].candidate);
    free(s->pool);
}

/* ---- pruning ------------------------------------------------------------------------------- */

static int compare_sizes(const void *left, const void *right) {
    const psplat_candidate *a = left, *b = right;
    if (a->covered_count != b->covered_count) return a->covered_count < b->covered_count ? -1 : 1;
    return memcmp(a->region.center, b->region.center, sizeof(double[3]));
}

/* Drops candidates whose samples are all covered twice, the smallest first. */
static void prune(selector *s) {
    psplat_selection *selection = s->selection;
    if (!selection->count) return;
    qsort(selection->candidates, selection->count, sizeof(psplat_candidate), compare_sizes);
    size_t kept = 0;
    for (size_t i = 0; i < selection->count; ++i) {
        psplat_candidate *candidate = &selection->candidates[i];
        int needed = 0;
        for (size_t k = 0; k < candidate->covered_count && !needed; ++k)
            needed = s->covers[candidate->covered[k]] < 2;
        if (needed) {
            selection->candidates[kept++] = *candidate;
        } else {
            count_cover(s, candidate, -1);
            psplat_candidate_free(candidate);
        }
    }
    selection->count = kept;
}

/* ---- cover --------------------------------------------------------------------------------- */

/* Existing candidates count as they are; every sample stands in a random order. */
static int selector_begin(selector *s) {
    size_t count = s->samples->count;
    s->covers = calloc(count, sizeof *s->covers);
    s->open = malloc(count * sizeof *s->open);
    if (!s->covers || !s->open) return 0;
    s->uncovered = s->open_count = count;
    for (size_t i = 0; i < s->selection->count; ++i)
        count_cover(s, &s->selection->candidates[i], 1);
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = (size_t)(psplat_random_unit(&s->random) * (double)(i + 1));
        if (at != i) s->open[i] = s->open[at];
        s->open[at] = i;
    }
    return 1;
}

static psplat_result cover_all(selector *s, const psplat_convert_desc *desc) {
    while (s->uncovered) {
        double done = 1 - (double)s->uncovered / (double)s->samples->count;
        if (desc->progress && desc->progress(desc->user, "selecting splats", done))
            return PSPLAT_ERROR_INTERRUPTED;
        psplat_result result = pool_grow(s);
        if (result) return result;
        pool_update(s);
        if (s->pool_count && !pool_take(s)) return PSPLAT_ERROR_MEMORY;
    }
    prune(s);
    return PSPLAT_OK;
}

psplat_result psplat_select_cover(const psplat_surface *surface, const psplat_samples *samples,
                                  const psplat_limits *limits, const psplat_convert_desc *desc,
                                  psplat_selection *selection, psplat_error *error) {
    selector s = {.surface = surface,
                  .samples = samples,
                  .limits = limits,
                  .selection = selection,
                  .random = desc->seed + 1};
    psplat_result result = selector_begin(&s) ? cover_all(&s, desc) : PSPLAT_ERROR_MEMORY;
    pool_free(&s);
    free(s.covers);
    free(s.open);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "%s while selecting splats", psplat_result_text(result));
}
