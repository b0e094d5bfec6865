/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * improve.c - fewer candidates for the same samples: large-neighbourhood search.
 *
 * Shaw (1998) on a set cover: take a handful of neighbouring candidates out, cover what they alone
 * covered anew with a greedy choice from the pool in which chance has some say, and keep the result
 * where it is no larger. Moves that change nothing but the places are kept too: they lead out of
 * dead ends. For several cores the surface is cut into slabs, across another axis each time: moves
 * in one slab exchange only candidates that cover samples of that slab alone, so that slabs do not
 * know of each other, and the result is the same whoever works on them.
 */
#include "stages.h"

#include <math.h>
#include <stdlib.h>

/* Candidates taken out at once, and how often a candidate looks for neighbours. */
enum { LEAST_REMOVED = 2, MOST_REMOVED = 13, LOOKS = 24 };

/* Taken candidates of a slab at least, and slabs at most; bins in which cuts are looked for. */
enum { SLAB_SIZE = 250, MOST_SLABS = 16, BINS = 1024, OUTSIDE = 255 };

/* How far chance may raise a gain. */
static const double whim = 0.25;

/* Shared by all slabs; each touches its own samples and candidates only. */
typedef struct improver {
    psplat_selection *selection;
    const psplat_improvement *what;
    size_t *first;         /* of each sample's candidates in incident; sample count + 1 */
    uint32_t *incident;    /* candidates that cover a sample */
    uint16_t *covers;      /* per sample: taken candidates covering it */
    uint8_t *open;         /* per sample: to be covered by the move under way */
    uint8_t *sample_slabs; /* per sample */
    uint8_t *slabs;        /* per candidate; OUTSIDE: covers samples of several */
    uint32_t *places;      /* per candidate: where it is in its slab's taken */
    uint32_t *gains;       /* per candidate: open samples it covers */
    size_t slab_count;
} improver;

/* One slab and its move under way. */
typedef struct slab {
    const improver *m;
    uint32_t *taken;     /* candidates taken, taken_count */
    uint32_t *touched;   /* candidates that had a gain in this move */
    uint32_t *open_list; /* samples opened by this move */
    size_t taken_count, touched_count, open_count;
    uint64_t random;
    uint8_t id;
} slab;

/* One move: what it took out, what it put in. */
typedef struct exchange {
    uint32_t removed[MOST_REMOVED], added[MOST_REMOVED];
    size_t removed_count, added_count;
} exchange;

static size_t draw(slab *s, size_t count) {
    return (size_t)(psplat_random_next(&s->random) % count);
}

static void count_covers(const improver *m, const psplat_candidate *candidate, int step) {
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint16_t *covers = &m->covers[candidate->covered[i]];
        *covers = (uint16_t)(*covers + step);
    }
}

static void include(slab *s, uint32_t c) {
    count_covers(s->m, &s->m->selection->candidates[c], 1);
    s->m->selection->candidates[c].taken = 1;
    s->m->places[c] = (uint32_t)s->taken_count;
    s->taken[s->taken_count++] = c;
}

static void exclude(slab *s, uint32_t c) {
    count_covers(s->m, &s->m->selection->candidates[c], -1);
    s->m->selection->candidates[c].taken = 0;
    uint32_t last = s->taken[--s->taken_count];
    s->taken[s->m->places[c]] = last;
    s->m->places[last] = s->m->places[c];
}

static int is_needed(const improver *m, const psplat_candidate *candidate) {
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (m->covers[candidate->covered[i]] < 2) return 1;
    return 0;
}

/* ---- a move -------------------------------------------------------------------------------- */

static void remove_one(slab *s, exchange *e, uint32_t c) {
    const improver *m = s->m;
    const psplat_candidate *candidate = &m->selection->candidates[c];
    e->removed[e->removed_count++] = c;
    exclude(s, c);
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint32_t sample = candidate->covered[i];
        if (m->covers[sample] || m->open[sample]) continue;
        m->open[sample] = 1;
        s->open_list[s->open_count++] = sample;
    }
}

/* A taken candidate of the slab that covers a sample, or PSPLAT_NONE. */
static uint32_t taken_over(const slab *s, size_t sample) {
    const improver *m = s->m;
    for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i)
        if (m->slabs[m->incident[i]] == s->id && m->selection->candidates[m->incident[i]].taken)
            return m->incident[i];
    return PSPLAT_NONE;
}

static uint32_t first_removed(slab *s) {
    size_t focus = s->m->what->focus, count = s->m->what->samples->count;
    uint32_t found = PSPLAT_NONE;
    if (focus < count) found = taken_over(s, focus + draw(s, count - focus));
    return found != PSPLAT_NONE ? found : s->taken[draw(s, s->taken_count)];
}

/* Takes out a random candidate and its neighbours: others that cover some sample of those out. */
static void remove_neighbors(slab *s, exchange *e) {
    size_t wanted = LEAST_REMOVED + draw(s, MOST_REMOVED - LEAST_REMOVED);
    remove_one(s, e, first_removed(s));
    for (size_t at = 0; at < e->removed_count && e->removed_count < wanted; ++at) {
        const psplat_candidate *candidate = &s->m->selection->candidates[e->removed[at]];
        for (int look = 0; look < LOOKS && e->removed_count < wanted; ++look) {
            uint32_t sample = candidate->covered[draw(s, candidate->covered_count)];
            uint32_t neighbor = s->m->open[sample] ? PSPLAT_NONE : taken_over(s, sample);
            if (neighbor != PSPLAT_NONE) remove_one(s, e, neighbor);
        }
    }
}

static void count_gains(slab *s) {
    const improver *m = s->m;
    s->touched_count = 0;
    for (size_t k = 0; k < s->open_count; ++k) {
        size_t sample = s->open_list[k];
        for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i) {
            uint32_t c = m->incident[i];
            if (m->slabs[c] == s->id && m->gains[c]++ == 0) s->touched[s->touched_count++] = c;
        }
    }
}

/* The candidate of the largest gain, give or take a whim of this move. */
static uint32_t best_candidate(const slab *s, uint64_t whims) {
    uint32_t best = PSPLAT_NONE;
    double most = 0;
    for (size_t i = 0; i < s->touched_count; ++i) {
        uint32_t c = s->touched[i];
        double gain = (double)s->m->gains[c];
        if (gain * (1 + whim) <= most) continue;
        uint64_t state = whims + c;
        gain *= 1 + whim * psplat_random_unit(&state);
        if (gain > most) most = gain, best = c;
    }
    return best;
}

static void close_samples(const slab *s, uint32_t chosen, size_t *left) {
    const improver *m = s->m;
    const psplat_candidate *candidate = &m->selection->candidates[chosen];
    for (size_t k = 0; k < candidate->covered_count; ++k) {
        size_t sample = candidate->covered[k];
        if (!m->open[sample]) continue;
        m->open[sample] = 0;
        --*left;
        for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i)
            if (m->slabs[m->incident[i]] == s->id) --m->gains[m->incident[i]];
    }
}

/* Covers the open samples with at most as many candidates as went out. Returns 0 where that takes
 * more. */
static int recover(slab *s, exchange *e) {
    size_t left = s->open_count;
    uint64_t whims = psplat_random_next(&s->random);
    while (left && e->added_count < e->removed_count) {
        uint32_t best = best_candidate(s, whims);
        if (best == PSPLAT_NONE) return 0;
        e->added[e->added_count++] = best;
        close_samples(s, best, &left);
        include(s, best);
    }
    return left == 0;
}

static void undo(slab *s, const exchange *e) {
    for (size_t i = 0; i < e->added_count; ++i) exclude(s, e->added[i]);
    for (size_t i = 0; i < e->removed_count; ++i) include(s, e->removed[i]);
}

static void move(slab *s) {
    exchange e = {.removed_count = 0};
    s->open_count = 0;
    remove_neighbors(s, &e);
    count_gains(s);
    if (!recover(s, &e) || (s->m->what->strict && e.added_count >= e.removed_count)) {
        undo(s, &e);
    } else {
        for (size_t i = 0; i < e.added_count; ++i)
            if (!is_needed(s->m, &s->m->selection->candidates[e.added[i]])) exclude(s, e.added[i]);
    }
    for (size_t i = 0; i < s->open_count; ++i) s->m->open[s->open_list[i]] = 0;
    for (size_t i = 0; i < s->touched_count; ++i) s->m->gains[s->touched[i]] = 0;
}

/* ---- slabs --------------------------------------------------------------------------------- */

/* Cuts the samples into slabs of about as many each, across an axis. */
static void cut(const improver *m, int axis) {
    const psplat_samples *samples = m->what->samples;
    const double *along = samples->positions + axis;
    size_t bins[BINS] = {0}, below = 0;
    uint8_t slab_of[BINS];
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t i = 0; i < samples->count; ++i) {
        low = fmin(low, along[3 * i]);
        high = fmax(high, along[3 * i]);
    }
    double scale = high > low ? (BINS - 1) / (high - low) : 0;
    for (size_t i = 0; i < samples->count; ++i) bins[(size_t)((along[3 * i] - low) * scale)]++;
    for (size_t i = 0; i < BINS; ++i) {
        slab_of[i] = (uint8_t)(below * m->slab_count / (samples->count + 1));
        below += bins[i];
    }
    for (size_t i = 0; i < samples->count; ++i)
        m->sample_slabs[i] = slab_of[(size_t)((along[3 * i] - low) * scale)];
}

static uint8_t slab_of_candidate(const improver *m, const psplat_candidate *candidate) {
    if (!candidate->covered_count) return OUTSIDE;
    uint8_t id = m->sample_slabs[candidate->covered[0]];
    for (size_t i = 1; i < candidate->covered_count; ++i)
        if (m->sample_slabs[candidate->covered[i]] != id) return OUTSIDE;
    return id;
}

static void slab_free(slab *s) {
    free(s->taken);
    free(s->touched);
    free(s->open_list);
}

static int slab_begin(slab *s, const improver *m, uint8_t id) {
    size_t candidates = 1, samples = 1;
    *s = (slab){.m = m, .id = id, .random = m->what->seed + id};
    for (size_t c = 0; c < m->selection->count; ++c) candidates += m->slabs[c] == id;
    for (size_t i = 0; i < m->what->samples->count; ++i) samples += m->sample_slabs[i] == id;
    s->taken = malloc(candidates * sizeof *s->taken);
    s->touched = malloc(candidates * sizeof *s->touched);
    s->open_list = malloc(samples * sizeof *s->open_list);
    if (!s->taken || !s->touched || !s->open_list) return 0;
    for (uint32_t c = 0; c < m->selection->count; ++c)
        if (m->slabs[c] == id && m->selection->candidates[c].taken) {
            m->places[c] = (uint32_t)s->taken_count;
            s->taken[s->taken_count++] = c;
        }
    return 1;
}

/* Each slab makes its share of the moves. */
static int improve_slab(const improver *m, uint8_t id, size_t taken) {
    slab s;
    int ok = slab_begin(&s, m, id);
    size_t moves = ok && taken ? m->what->moves * s.taken_count / taken : 0;
    for (size_t i = 0; i < moves; ++i) move(&s);
    slab_free(&s);
    return ok;
}

/* ---- setting up ---------------------------------------------------------------------------- */

static int index_samples(improver *m) {
    const psplat_selection *selection = m->selection;
    size_t count = m->what->samples->count;
    m->first = calloc(count + 2, sizeof *m->first);
    if (!m->first) return 0;
    size_t *starts = m->first + 1; /* shifted by one, so that filling leaves first right */
    for (size_t c = 0; c < selection->count; ++c)
        for (size_t i = 0; i < selection->candidates[c].covered_count; ++i)
            starts[selection->candidates[c].covered[i] + 1]++;
    for (size_t i = 0; i < count; ++i) starts[i + 1] += starts[i];
    m->incident = malloc((starts[count] + 1) * sizeof *m->incident);
    if (!m->incident) return 0;
    for (uint32_t c = 0; c < selection->count; ++c)
        for (size_t i = 0; i < selection->candidates[c].covered_count; ++i)
            m->incident[starts[selection->candidates[c].covered[i]]++] = c;
    return 1;
}

static int improver_begin(improver *m) {
    size_t candidates = m->selection->count + 1, samples = m->what->samples->count + 1;
    m->covers = calloc(samples, sizeof *m->covers);
    m->open = calloc(samples, 1);
    m->sample_slabs = calloc(samples, 1);
    m->slabs = calloc(candidates, 1);
    m->places = malloc(candidates * sizeof *m->places);
    m->gains = calloc(candidates, sizeof *m->gains);
    if (!m->covers || !m->open || !m->sample_slabs || !m->slabs || !m->places || !m->gains ||
        !index_samples(m))
        return 0;
    for (size_t c = 0; c < m->selection->count; ++c)
        if (m->selection->candidates[c].taken) count_covers(m, &m->selection->candidates[c], 1);
    return 1;
}

static void improver_end(improver *m) {
    free(m->first);
    free(m->incident);
    free(m->covers);
    free(m->open);
    free(m->sample_slabs);
    free(m->slabs);
    free(m->places);
    free(m->gains);
}

/* Drops what greedy choice left without a sample of its own, the latest grown first. Returns how
 * many remain. */
static size_t prune(const improver *m) {
    size_t taken = 0;
    for (size_t c = m->selection->count; c-- > 0;) {
        psplat_candidate *candidate = &m->selection->candidates[c];
        if (!candidate->taken) continue;
        if (is_needed(m, candidate)) {
            ++taken;
            continue;
        }
        candidate->taken = 0;
        count_covers(m, candidate, -1);
    }
    return taken;
}

psplat_result psplat_improve(psplat_selection *selection, const psplat_improvement *what) {
    improver m = {.selection = selection, .what = what};
    int failed = !improver_begin(&m);
    size_t taken = failed ? 0 : prune(&m);
    if (taken && what->moves) {
        size_t slabs = taken / SLAB_SIZE;
        m.slab_count = slabs < 1 ? 1 : slabs > MOST_SLABS ? MOST_SLABS : slabs;
        cut(&m, what->axis);
        for (size_t c = 0; c < selection->count; ++c)
            m.slabs[c] = slab_of_candidate(&m, &selection->candidates[c]);
        long end = (long)m.slab_count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1) reduction(| : failed)
#endif
        for (long i = 0; i < end; ++i) failed |= !improve_slab(&m, (uint8_t)i, taken);
        if (!failed) prune(&m); /* what others came to cover */
    }
    improver_end(&m);
    return failed ? PSPLAT_ERROR_MEMORY : PSPLAT_OK;
}
