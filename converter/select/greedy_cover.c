/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * greedy_cover.c - greedy set cover: a small set of candidates that together cover every sample.
 *
 * The pool of candidates grows from round to round (Wu, Kobbelt 2004, section 4). A round grows
 * candidates around samples that are not covered yet and have few candidates to choose from, and
 * then takes the pool's best ones as long as each newly covers nearly as many samples as the first.
 * Those that are not taken stay in the selection, where local_search.c may choose them. The seeds
 * of a round are drawn before candidates grow, so that the result does not depend on the number of
 * threads.
 */
#include "select/greedy_cover.h"

#include "base/random.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "select/conversion.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most candidates that grow in a round: FIRST_SEEDS in the first, and then LEAST_SEEDS
 * plus SEEDS_PER_SPLAT for each splat that the uncovered samples seem to need by the mean gain of
 * the round before, at most MOST_SEEDS. Chosen by hand. */
enum { SEEDS_PER_SPLAT = 2, LEAST_SEEDS = 4, FIRST_SEEDS = 16, MOST_SEEDS = 1024 };

/* The number of candidates that cover a sample from which on no more grow around it. With 6,
 * 1.6 times as many grow, and 1.5 % fewer are taken in the end; another round of the local search
 * saves as many in less time. Chosen by hand. */
enum { CHOICES = 3 };

/* The least gain of a candidate that is taken, as a share of the gain of the round's best. Chosen
 * by hand. */
static const double least_gain_share = 0.8;

typedef struct pool_entry {
    uint32_t candidate;
    size_t gain; /* samples that it would newly cover; an upper bound between updates */
} pool_entry;

/* The state of the greedy cover. */

typedef struct selector {
    const psplat_fit_context *context;
    psplat_selection *selection;
    pool_entry *pool; /* candidates that may still gain */
    size_t pool_count;
    uint8_t *covered; /* per sample */
    uint8_t *choices; /* per sample: how many candidates of the pool cover it, CHOICES at most */
    uint32_t *open;   /* samples in random order; those before open_count may need candidates */
    size_t open_count;
    size_t uncovered; /* the number of samples not covered */
    size_t taken;     /* the number of candidates that are taken */
    size_t mean_gain; /* of the candidates taken in the last round */
    uint64_t random;
} selector;

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
    ++s->taken;
}

/* Stores the next samples of the random order that need candidates as seeds, and returns their
 * number. Samples that are covered, or that enough candidates of the pool cover, one of which will
 * be taken, are no longer open; seeds stay open until this is so. */
static size_t next_seeds(selector *s, uint32_t *seeds, size_t wanted) {
    size_t count = 0, kept = 0, i = 0;
    for (; i < s->open_count && count < wanted; ++i)
        if (!s->covered[s->open[i]] && s->choices[s->open[i]] < CHOICES)
            seeds[count++] = s->open[i];
    for (size_t rest = i; rest < s->open_count; ++rest) s->open[kept++] = s->open[rest];
    for (size_t k = 0; k < count; ++k) s->open[kept++] = seeds[k];
    s->open_count = kept;
    return count;
}

/* Appends a candidate to the pool. */
static void pool_add(selector *s, uint32_t index) {
    const psplat_candidate *candidate = &s->selection->candidates[index];
    s->pool[s->pool_count++] = (pool_entry){index, 0};
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint8_t *choices = &s->choices[candidate->covered[i]];
        *choices = (uint8_t)(*choices + (*choices < CHOICES));
    }
}

static psplat_result pool_grow(selector *s) {
    size_t wanted = FIRST_SEEDS, before = s->selection->count;
    if (s->mean_gain) wanted = LEAST_SEEDS + SEEDS_PER_SPLAT * s->uncovered / s->mean_gain;
    if (wanted > MOST_SEEDS) wanted = MOST_SEEDS;
    uint32_t *seeds = malloc(wanted * sizeof *seeds);
    if (!seeds) return PSPLAT_ERROR_MEMORY;
    size_t count = next_seeds(s, seeds, wanted);
    psplat_result result = psplat_selection_grow(s->context, seeds, count, s->selection);
    free(seeds);
    if (result) return result;
    pool_entry *pool = realloc(s->pool, (s->pool_count + count + 1) * sizeof *pool);
    if (!pool) return PSPLAT_ERROR_MEMORY;
    s->pool = pool;
    for (size_t i = 0; i < count; ++i) pool_add(s, (uint32_t)(before + i));
    return PSPLAT_OK;
}

static int compare_entries(const void *left, const void *right) {
    const pool_entry *a = left, *b = right;
    if (a->gain != b->gain) return a->gain > b->gain ? -1 : 1;
    return a->candidate < b->candidate ? -1 : a->candidate > b->candidate;
}

/* Recounts all gains, drops entries without gain, and sorts the best first. */
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

/* Takes the best entries of a sorted pool, as long as their gains, recounted, are large enough. */
static void pool_take(selector *s) {
    size_t least = s->pool_count ? (size_t)ceil(least_gain_share * (double)s->pool[0].gain) : 0;
    size_t taken = 0, before = s->uncovered;
    for (size_t i = 0; i < s->pool_count && s->pool[i].gain >= least; ++i) {
        psplat_candidate *candidate = &s->selection->candidates[s->pool[i].candidate];
        size_t gain = gain_of(s, candidate);
        if (!gain || gain < least) continue;
        take(s, candidate);
        ++taken;
    }
    if (taken) s->mean_gain = (before - s->uncovered) / taken;
}

/* ---- cover --------------------------------------------------------------------------------- */

/* Marks the samples of an apron, which no splat has to cover. */
static void mark_apron(selector *s) {
    const psplat_samples *samples = s->context->samples;
    for (size_t i = 0; s->context->surface->owned && i < samples->count; ++i) {
        s->covered[i] = !psplat_surface_owns(s->context->surface, samples->positions + 3 * i);
        s->uncovered -= s->covered[i];
    }
}

/* Marks what the candidates taken before cover, and shuffles the samples. Returns 0 when out of
 * memory. */
static int selector_begin(selector *s) {
    size_t count = s->context->samples->count;
    s->covered = calloc(count, 1);
    s->choices = calloc(count, 1);
    s->open = malloc(count * sizeof *s->open);
    if (!s->covered || !s->choices || !s->open) return 0;
    s->uncovered = s->open_count = count;
    mark_apron(s);
    for (size_t i = 0; i < s->selection->count; ++i)
        if (s->selection->candidates[i].taken) take(s, &s->selection->candidates[i]);
    for (uint32_t i = 0; i < count; ++i) {
        size_t at = (size_t)(psplat_random_unit(&s->random) * (double)(i + 1));
        if (at != i) s->open[i] = s->open[at];
        s->open[at] = i;
    }
    return 1;
}

/* Takes candidates until all is covered, or more than `most` are taken. */
static psplat_result cover_all(selector *s, const psplat_convert_desc *desc, size_t most) {
    while (s->uncovered && s->taken <= most) {
        double done = 1 - (double)s->uncovered / (double)s->context->samples->count;
        if (desc->progress && desc->progress(desc->user, "selecting splats", done))
            return PSPLAT_ERROR_INTERRUPTED;
        psplat_result result = pool_grow(s);
        if (result) return result;
        pool_update(s);
        pool_take(s);
    }
    return PSPLAT_OK;
}

psplat_result psplat_greedy_cover(const psplat_fit_context *context,
                                  const psplat_convert_desc *desc, psplat_selection *selection,
                                  psplat_error *error) {
    int is_whole;
    return psplat_greedy_cover_by(context, desc, SIZE_MAX, selection, &is_whole, error);
}

psplat_result psplat_greedy_cover_by(const psplat_fit_context *context,
                                     const psplat_convert_desc *desc, size_t most,
                                     psplat_selection *selection, int *is_whole,
                                     psplat_error *error) {
    selector s = {.context = context, .selection = selection, .random = desc->seed + 1};
    psplat_result result = selector_begin(&s) ? cover_all(&s, desc, most) : PSPLAT_ERROR_MEMORY;
    *is_whole = !result && !s.uncovered;
    free(s.pool);
    free(s.covered);
    free(s.choices);
    free(s.open);
    if (!result) return PSPLAT_OK;
    return psplat_fail(error, result, 0, "%s while selecting splats", psplat_result_text(result));
}
