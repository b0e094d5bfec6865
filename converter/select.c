/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * select.c - a small set of candidates that covers every sample.
 *
 * Greedy cover (Wu, Kobbelt 2004, section 4) over a pool that grows as it goes: each round grows
 * candidates around samples not yet covered and takes the pool's best as long as they gain nearly
 * as much as the round's first. What is not taken stays in the pool, for improve.c to choose from.
 * Seeds of a round are drawn before growing, so that the result does not depend on the number of
 * threads.
 */
#include "stages.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Candidates grown in a round: so many for each that what is uncovered seems to need, going by what
 * the round before gained; at least, at first, and at most. */
enum { SEEDS_PER_SPLAT = 4, LEAST_SEEDS = 8, FIRST_SEEDS = 32, MOST_SEEDS = 128 };

/* A candidate is taken while it gains this part of the round's best. */
static const double worth_taking = 0.8;

typedef struct pool_entry {
    uint32_t candidate;
    size_t gain; /* samples it would newly cover; an upper bound between updates */
} pool_entry;

typedef struct selector {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    psplat_selection *selection;
    pool_entry *pool; /* candidates that may still gain */
    size_t pool_count;
    uint8_t *covered; /* per sample */
    uint32_t *open;   /* samples in random order; those before open_count may be uncovered */
    size_t open_count;
    size_t uncovered;
    size_t gained; /* by a candidate taken in the last round, on average */
    uint64_t random;
} selector;

/* ---- selection ----------------------------------------------------------------------------- */

void psplat_selection_free(psplat_selection *selection) {
    for (size_t i = 0; i < selection->count; ++i) psplat_candidate_free(&selection->candidates[i]);
    free(selection->candidates);
    *selection = (psplat_selection){0};
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

size_t psplat_selection_taken(const psplat_selection *selection) {
    size_t count = 0;
    for (size_t i = 0; i < selection->count; ++i) count += selection->candidates[i].taken != 0;
    return count;
}

void psplat_selection_settle(psplat_selection *selection) {
    size_t kept = 0;
    for (size_t i = 0; i < selection->count; ++i) {
        psplat_candidate candidate = selection->candidates[i];
        if (candidate.taken)
            selection->candidates[kept++] = candidate;
        else
            psplat_candidate_free(&candidate);
    }
    selection->count = kept;
}

/* Seeds and what grows from them. */
typedef struct nursery {
    const psplat_surface *surface;
    const psplat_samples *samples;
    const psplat_limits *limits;
    const uint32_t *seeds;
    psplat_candidate *grown;
} nursery;

static psplat_result grow_one(void *user, size_t index, psplat_growth *growth) {
    const nursery *n = user;
    return psplat_candidate_grow(n->surface, n->samples, n->limits, n->seeds[index], growth,
                                 &n->grown[index]);
}

psplat_result psplat_selection_grow(const psplat_surface *surface, const psplat_samples *samples,
                                    const psplat_limits *limits, const uint32_t *seeds,
                                    size_t count, psplat_selection *selection) {
    psplat_candidate *grown = calloc(count + 1, sizeof *grown);
    if (!grown) return PSPLAT_ERROR_MEMORY;
    nursery n = {surface, samples, limits, seeds, grown};
    psplat_result result = psplat_growth_each(count, grow_one, &n);
    for (size_t i = 0; i < count; ++i) {
        if (!result && !psplat_selection_push(selection, &grown[i])) result = PSPLAT_ERROR_MEMORY;
        psplat_candidate_free(&grown[i]);
    }
    free(grown);
    return result;
}

/* ---- pool ---------------------------------------------------------------------------------- */

static size_t gain_of(const selector *s, const psplat_candidate *candidate) {
    size_t gain = 0;
    for (size_t i = 0; i < candidate->covered_count; ++i)
        gain += !s->covered[candidate->covered[i]];
    return gain;
}

static void take(selector *s, psplat_candidate *candidate) {
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint8_t *covered = &s->covered[candidate->covered[i]];
        s->uncovered -= !*covered;
        *covered = 1;
    }
    candidate->taken = 1;
}

/* Moves uncovered samples to grow from to the end of the open ones, and returns their number: the
 * next of the random order. Once drawn they were tried, but may remain uncovered. */
static size_t draw_seeds(selector *s, uint32_t *seeds, size_t wanted) {
    size_t count = 0, kept = 0, i = 0;
    for (; i < s->open_count && count < wanted; ++i)
        if (!s->covered[s->open[i]]) seeds[count++] = s->open[i];
    for (size_t rest = i; rest < s->open_count; ++rest) s->open[kept++] = s->open[rest];
    for (size_t k = 0; k < count; ++k) s->open[kept++] = seeds[k];
    s->open_count = kept;
    return count;
}

static psplat_result pool_grow(selector *s) {
    size_t wanted = FIRST_SEEDS, before = s->selection->count;
    if (s->gained) wanted = LEAST_SEEDS + SEEDS_PER_SPLAT * s->uncovered / s->gained;
    if (wanted > MOST_SEEDS) wanted = MOST_SEEDS;
    uint32_t *seeds = malloc(wanted * sizeof *seeds);
    if (!seeds) return PSPLAT_ERROR_MEMORY;
    size_t count = draw_seeds(s, seeds, wanted);
    psplat_result result =
        psplat_selection_grow(s->surface, s->samples, s->limits, seeds, count, s->selection);
    free(seeds);
    if (result) return result;
    pool_entry *pool = realloc(s->pool, (s->pool_count + count + 1) * sizeof *pool);
    if (!pool) return PSPLAT_ERROR_MEMORY;
    s->pool = pool;
    for (size_t i = 0; i < count; ++i)
        pool[s->pool_count++] = (pool_entry){(uint32_t)(before + i), 0};
    return PSPLAT_OK;
}

static int compare_entries(const void *left, const void *right) {
    const pool_entry *a = left, *b = right;
    if (a->gain != b->gain) return a->gain > b->gain ? -1 : 1;
    return a->candidate < b->candidate ? -1 : a->candidate > b->candidate;
}

/* Recounts all gains, drops entries without any, and sorts the best first. */
static void pool_update(selector *s) {
    size_t kept = 0;
    for (size_t i = 0; i < s->pool_count; ++i) {
        pool_entry entry = s->pool[i];
        entry.gain = gain_of(s, &s->selection->candidates[entry.candidate]);
        if (entry.gain) s->pool[kept++] = entry;
    }
    s->pool_count = kept;
    if (kept) qsort(s->pool, kept, sizeof(pool_entry), compare_entries);
}

static void pool_take(selector *s) {
    size_t least = s->pool_count ? (size_t)ceil(worth_taking * (double)s->pool[0].gain) : 0;
    size_t taken = 0, before = s->uncovered;
    for (size_t i = 0; i < s->pool_count && s->pool[i].gain >= least; ++i) {
        psplat_candidate *candidate = &s->selection->candidates[s->pool[i].candidate];
        size_t gain = gain_of(s, candidate);
        if (!gain || gain < least) continue;
        take(s, candidate);
        ++taken;
    }
    if (taken) s->gained = (before - s->uncovered) / taken;
}

/* ---- cover --------------------------------------------------------------------------------- */

/* Candidates taken before count as they are; every sample stands in a random order. */
static int selector_begin(selector *s) {
    size_t count = s->samples->count;
    s->covered = calloc(count, 1);
    s->open = malloc(count * sizeof *s->open);
    if (!s->covered || !s->open) return 0;
    s->uncovered = s->open_count = count;
    for (size_t i = 0; i < s->selection->count; ++i)
        if (s->selection->candidates[i].taken) take(s, &s->selection->candidates[i]);
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
        pool_take(s);
    }
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
    free(s.pool);
    free(s.covered);
    free(s.open);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "%s while selecting splats", psplat_result_text(result));
}
