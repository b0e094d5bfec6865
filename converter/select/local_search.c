/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * local_search.c - large-neighbourhood search (Shaw 1998) for a set cover of fewer candidates.
 *
 * A move removes a handful of neighbouring candidates, covers the samples that only they covered by
 * a randomized greedy choice from the pool, and keeps the result where it is no larger. Moves that
 * exchange candidates without saving any are kept too, since they lead out of local minima. For
 * several cores the surface is cut into slabs, along another axis each time. The moves of a slab
 * exchange only candidates that cover samples of that slab alone. So slabs do not depend on each
 * other, and the result is the same for any number of threads.
 */
#include "select/local_search.h"

#include "base/random.h"
#include "features/samples.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "mesh/mesh.h"
#include "select/selection.h"

#include <math.h>
#include <stdlib.h>

/* All of these were chosen by hand. */
/* A move removes at least LEAST_REMOVED and fewer than REMOVED_LIMIT candidates. At NEIGHBOR_TRIES
 * random samples of each removed one it looks for a neighbour to remove. */
enum { LEAST_REMOVED = 2, REMOVED_LIMIT = 13, NEIGHBOR_TRIES = 24 };

/* The number of taken candidates that a slab has at least on average, the greatest number of slabs,
 * and the number of bins between which the surface may be cut. OUTSIDE marks candidates that belong
 * to no slab. */
enum { LEAST_SLAB_CANDIDATES = 250, MOST_SLABS = 16, CUT_BINS = 1024, OUTSIDE = 255 };

/* The part of a gain by which noise may raise it. */
static const double greatest_noise = 0.25;

/* The state that all slabs share. Each changes only its own samples and candidates. */
typedef struct search_state {
    psplat_selection *selection;
    const psplat_local_search_desc *desc;
    size_t *first;         /* sample count + 1: where the candidates of each begin in incident */
    uint32_t *incident;    /* the candidates of each sample's slab that cover it */
    uint16_t *covers;      /* per sample: the number of taken candidates that cover it */
    uint8_t *open;         /* per sample: 1 where the current move has yet to cover it */
    uint8_t *sample_slabs; /* per sample: its slab */
    uint8_t *slabs;        /* per candidate: its slab; OUTSIDE: it covers samples of several */
    uint32_t *places;      /* per candidate: its index in its slab's taken */
    uint32_t *gains;       /* per candidate: the number of open samples that it covers */
    size_t slab_count;
} search_state;

/* A slab and its current move. */
typedef struct slab {
    const search_state *state;
    uint32_t *taken;     /* candidates taken, taken_count */
    uint32_t *touched;   /* candidates that had a gain in this move */
    uint32_t *open_list; /* samples opened by this move */
    size_t taken_count, touched_count, open_count;
    uint64_t random;
    uint8_t id;
} slab;

/* The candidates that one move removes and adds. */
typedef struct exchange {
    uint32_t removed[REMOVED_LIMIT], added[REMOVED_LIMIT];
    size_t removed_count, added_count;
} exchange;

/* Returns a random index below count. */
static size_t draw(slab *s, size_t count) {
    return (size_t)(psplat_random_next(&s->random) % count);
}

static void count_covers(const search_state *state, const psplat_candidate *candidate, int step) {
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint16_t *covers = &state->covers[candidate->covered[i]];
        *covers = (uint16_t)(*covers + step);
    }
}

static void take_candidate(slab *s, uint32_t c) {
    count_covers(s->state, &s->state->selection->candidates[c], 1);
    s->state->selection->candidates[c].taken = 1;
    s->state->places[c] = (uint32_t)s->taken_count;
    s->taken[s->taken_count++] = c;
}

static void drop_candidate(slab *s, uint32_t c) {
    count_covers(s->state, &s->state->selection->candidates[c], -1);
    s->state->selection->candidates[c].taken = 0;
    uint32_t last = s->taken[--s->taken_count];
    s->taken[s->state->places[c]] = last;
    s->state->places[last] = s->state->places[c];
}

static int is_needed(const search_state *state, const psplat_candidate *candidate) {
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (state->covers[candidate->covered[i]] < 2) return 1;
    return 0;
}

/* ---- a move -------------------------------------------------------------------------------- */

static void remove_one(slab *s, exchange *e, uint32_t c) {
    const search_state *state = s->state;
    const psplat_candidate *candidate = &state->selection->candidates[c];
    e->removed[e->removed_count++] = c;
    drop_candidate(s, c);
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint32_t sample = candidate->covered[i];
        if (state->covers[sample] || state->open[sample]) continue;
        state->open[sample] = 1;
        s->open_list[s->open_count++] = sample;
    }
}

/* Finds a taken candidate of the slab that covers a sample; PSPLAT_NONE where there is none. */
static uint32_t taken_candidate_of(const slab *s, size_t sample) {
    const search_state *state = s->state;
    if (state->sample_slabs[sample] != s->id) return PSPLAT_NONE;
    for (size_t i = state->first[sample]; i < state->first[sample + 1]; ++i)
        if (state->selection->candidates[state->incident[i]].taken) return state->incident[i];
    return PSPLAT_NONE;
}

static uint32_t first_to_remove(slab *s) {
    size_t focus = s->state->desc->focus, count = s->state->desc->samples->count;
    uint32_t found = PSPLAT_NONE;
    if (focus < count) found = taken_candidate_of(s, focus + draw(s, count - focus));
    return found != PSPLAT_NONE ? found : s->taken[draw(s, s->taken_count)];
}

/* Removes a random candidate and neighbours: others that share a sample with one removed before. */
static void remove_neighbors(slab *s, exchange *e) {
    size_t wanted = LEAST_REMOVED + draw(s, REMOVED_LIMIT - LEAST_REMOVED);
    remove_one(s, e, first_to_remove(s));
    for (size_t at = 0; at < e->removed_count && e->removed_count < wanted; ++at) {
        const psplat_candidate *candidate = &s->state->selection->candidates[e->removed[at]];
        for (int look = 0; look < NEIGHBOR_TRIES && e->removed_count < wanted; ++look) {
            uint32_t sample = candidate->covered[draw(s, candidate->covered_count)];
            uint32_t neighbor =
                s->state->open[sample] ? PSPLAT_NONE : taken_candidate_of(s, sample);
            if (neighbor != PSPLAT_NONE) remove_one(s, e, neighbor);
        }
    }
}

static void count_gains(slab *s) {
    const search_state *state = s->state;
    s->touched_count = 0;
    for (size_t k = 0; k < s->open_count; ++k) {
        size_t sample = s->open_list[k];
        for (size_t i = state->first[sample]; i < state->first[sample + 1]; ++i) {
            uint32_t c = state->incident[i];
            if (state->gains[c]++ == 0) s->touched[s->touched_count++] = c;
        }
    }
}

/* Finds the candidate of the largest gain, which noise raises by a part that stays the same for a
 * candidate during a move. */
static uint32_t best_candidate(const slab *s, uint64_t noise_seed) {
    uint32_t best = PSPLAT_NONE;
    double most = 0;
    for (size_t i = 0; i < s->touched_count; ++i) {
        uint32_t c = s->touched[i];
        double gain = (double)s->state->gains[c];
        if (gain * (1 + greatest_noise) <= most) continue;
        uint64_t noise = noise_seed + c;
        gain *= 1 + greatest_noise * psplat_random_unit(&noise);
        if (gain > most) most = gain, best = c;
    }
    return best;
}

static void close_samples(const slab *s, uint32_t chosen, size_t *left) {
    const search_state *state = s->state;
    const psplat_candidate *candidate = &state->selection->candidates[chosen];
    for (size_t k = 0; k < candidate->covered_count; ++k) {
        size_t sample = candidate->covered[k];
        if (!state->open[sample]) continue;
        state->open[sample] = 0;
        --*left;
        for (size_t i = state->first[sample]; i < state->first[sample + 1]; ++i)
            --state->gains[state->incident[i]];
    }
}

/* Covers the open samples with at most as many candidates as were removed. Returns 0 where these do
 * not suffice. */
static int cover_open_samples(slab *s, exchange *e) {
    size_t left = s->open_count;
    uint64_t noise_seed = psplat_random_next(&s->random);
    while (left && e->added_count < e->removed_count) {
        uint32_t best = best_candidate(s, noise_seed);
        if (best == PSPLAT_NONE) return 0;
        e->added[e->added_count++] = best;
        close_samples(s, best, &left);
        take_candidate(s, best);
    }
    return left == 0;
}

static void undo(slab *s, const exchange *e) {
    for (size_t i = 0; i < e->added_count; ++i) drop_candidate(s, e->added[i]);
    for (size_t i = 0; i < e->removed_count; ++i) take_candidate(s, e->removed[i]);
}

static void try_move(slab *s) {
    exchange e = {.removed_count = 0};
    s->open_count = 0;
    remove_neighbors(s, &e);
    count_gains(s);
    if (!cover_open_samples(s, &e) ||
        (s->state->desc->strict && e.added_count >= e.removed_count)) {
        undo(s, &e);
    } else {
        for (size_t i = 0; i < e.added_count; ++i)
            if (!is_needed(s->state, &s->state->selection->candidates[e.added[i]]))
                drop_candidate(s, e.added[i]);
    }
    for (size_t i = 0; i < s->open_count; ++i) s->state->open[s->open_list[i]] = 0;
    for (size_t i = 0; i < s->touched_count; ++i) s->state->gains[s->touched[i]] = 0;
}

/* ---- slabs --------------------------------------------------------------------------------- */

/* Cuts the samples into slabs of about equal numbers of samples, along an axis. */
static void cut_into_slabs(const search_state *state, int axis) {
    const psplat_samples *samples = state->desc->samples;
    const double *along = samples->positions + axis;
    size_t bins[CUT_BINS] = {0}, below = 0;
    uint8_t slab_of[CUT_BINS];
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < samples->count; ++i) {
        low = fmin(low, along[3 * i]);
        high = fmax(high, along[3 * i]);
    }
    double scale = high > low ? (CUT_BINS - 1) / (high - low) : 0;
    for (size_t i = 0; i < samples->count; ++i) bins[(size_t)((along[3 * i] - low) * scale)]++;
    for (size_t i = 0; i < CUT_BINS; ++i) {
        slab_of[i] = (uint8_t)(below * state->slab_count / (samples->count + 1));
        below += bins[i];
    }
    for (size_t i = 0; i < samples->count; ++i)
        state->sample_slabs[i] = slab_of[(size_t)((along[3 * i] - low) * scale)];
}

static uint8_t slab_of_candidate(const search_state *state, const psplat_candidate *candidate) {
    if (!candidate->covered_count) return OUTSIDE;
    uint8_t id = state->sample_slabs[candidate->covered[0]];
    for (size_t i = 1; i < candidate->covered_count; ++i)
        if (state->sample_slabs[candidate->covered[i]] != id) return OUTSIDE;
    return id;
}

static void slab_free(slab *s) {
    free(s->taken);
    free(s->touched);
    free(s->open_list);
}

static int slab_begin(slab *s, const search_state *state, uint8_t id) {
    size_t candidates = 1, samples = 1;
    *s = (slab){.state = state, .id = id, .random = state->desc->seed + id};
    for (size_t c = 0; c < state->selection->count; ++c) candidates += state->slabs[c] == id;
    for (size_t i = 0; i < state->desc->samples->count; ++i)
        samples += state->sample_slabs[i] == id;
    s->taken = malloc(candidates * sizeof *s->taken);
    s->touched = malloc(candidates * sizeof *s->touched);
    s->open_list = malloc(samples * sizeof *s->open_list);
    if (!s->taken || !s->touched || !s->open_list) return 0;
    for (uint32_t c = 0; c < state->selection->count; ++c)
        if (state->slabs[c] == id && state->selection->candidates[c].taken) {
            state->places[c] = (uint32_t)s->taken_count;
            s->taken[s->taken_count++] = c;
        }
    return 1;
}

/* Makes a slab's share of the moves. Returns 0 when out of memory. */
static int improve_slab(const search_state *state, uint8_t id, size_t taken) {
    slab s;
    int ok = slab_begin(&s, state, id);
    size_t moves = ok && taken ? state->desc->moves * s.taken_count / taken : 0;
    for (size_t i = 0; i < moves; ++i) try_move(&s);
    slab_free(&s);
    return ok;
}

/* ---- setting up ---------------------------------------------------------------------------- */

/* Counts the samples of an apron as covered by one that is never dropped. */
static void cover_apron(const search_state *state) {
    const psplat_surface *surface = state->desc->surface;
    const psplat_samples *samples = state->desc->samples;
    for (size_t i = 0; surface && surface->owned && i < samples->count; ++i)
        state->covers[i] = !psplat_surface_owns(surface, samples->positions + 3 * i);
}

static int search_begin(search_state *state) {
    size_t candidates = state->selection->count + 1, samples = state->desc->samples->count + 1;
    state->covers = calloc(samples, sizeof *state->covers);
    state->open = calloc(samples, 1);
    state->sample_slabs = calloc(samples, 1);
    state->slabs = calloc(candidates, 1);
    state->places = malloc(candidates * sizeof *state->places);
    state->gains = calloc(candidates, sizeof *state->gains);
    if (!state->covers || !state->open || !state->sample_slabs || !state->slabs || !state->places ||
        !state->gains)
        return 0;
    cover_apron(state);
    for (size_t c = 0; c < state->selection->count; ++c)
        if (state->selection->candidates[c].taken)
            count_covers(state, &state->selection->candidates[c], 1);
    return 1;
}

static void search_end(search_state *state) {
    free(state->first);
    free(state->incident);
    free(state->covers);
    free(state->open);
    free(state->sample_slabs);
    free(state->slabs);
    free(state->places);
    free(state->gains);
}

/* Drops the candidates that no sample needs, the last of the pool first. Returns how many remain.
 */
static size_t drop_unneeded(const search_state *state) {
    size_t taken = 0;
    for (size_t c = state->selection->count; c-- > 0;) {
        psplat_candidate *candidate = &state->selection->candidates[c];
        if (!candidate->taken) continue;
        if (is_needed(state, candidate)) {
            ++taken;
            continue;
        }
        candidate->taken = 0;
        count_covers(state, candidate, -1);
    }
    return taken;
}

/* Lists the candidates of each sample but for those of no slab, which no move exchanges. Returns 0
 * when out of memory. */
static int index_samples(search_state *state) {
    const psplat_selection *selection = state->selection;
    size_t count = state->desc->samples->count;
    state->first = calloc(count + 2, sizeof *state->first);
    if (!state->first) return 0;
    size_t *starts = state->first + 1; /* Filling moves each start to the next one's place. */
    for (size_t c = 0; c < selection->count; ++c)
        for (size_t i = 0; state->slabs[c] != OUTSIDE && i < selection->candidates[c].covered_count;
             ++i)
            starts[selection->candidates[c].covered[i] + 1]++;
    for (size_t i = 0; i < count; ++i) starts[i + 1] += starts[i];
    state->incident = malloc((starts[count] + 1) * sizeof *state->incident);
    if (!state->incident) return 0;
    for (uint32_t c = 0; c < selection->count; ++c)
        for (size_t i = 0; state->slabs[c] != OUTSIDE && i < selection->candidates[c].covered_count;
             ++i)
            state->incident[starts[selection->candidates[c].covered[i]]++] = c;
    return 1;
}

/* Cuts the surface into slabs and lets each make its moves. Returns 0 when out of memory. */
static int improve_slabs(search_state *state, size_t taken) {
    size_t slabs = taken / LEAST_SLAB_CANDIDATES;
    state->slab_count = slabs < 1 ? 1 : slabs > MOST_SLABS ? MOST_SLABS : slabs;
    cut_into_slabs(state, state->desc->axis);
    for (size_t c = 0; c < state->selection->count; ++c)
        state->slabs[c] = slab_of_candidate(state, &state->selection->candidates[c]);
    if (!index_samples(state)) return 0;
    long end = (long)state->slab_count;
    int failed = 0;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1) reduction(| : failed)
#endif
    for (long i = 0; i < end; ++i) failed |= !improve_slab(state, (uint8_t)i, taken);
    return !failed;
}

psplat_result psplat_local_search(psplat_selection *selection,
                                  const psplat_local_search_desc *desc) {
    search_state state = {.selection = selection, .desc = desc};
    int ok = search_begin(&state);
    size_t taken = ok ? drop_unneeded(&state) : 0;
    if (taken && desc->moves) {
        ok = improve_slabs(&state, taken);
        /* Candidates of one slab may have come to cover what those of another did. */
        if (ok) drop_unneeded(&state);
    }
    search_end(&state);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}
