/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * improve.c - fewer candidates for the same samples: large-neighbourhood search.
 *
 * Shaw (1998) on a set cover: take a handful of neighbouring candidates out, cover what they alone
 * covered anew with a greedy choice from the pool in which chance has some say, and keep the result
 * where it is no larger. Moves that change nothing but the places are kept too: they lead out of
 * dead ends. Every move first drops what its neighbourhood does not need.
 */
#include "stages.h"

#include <stdlib.h>
#include <string.h>

/* Candidates taken out at once, and how often a candidate looks for neighbours. */
enum { LEAST_REMOVED = 2, MOST_REMOVED = 13, LOOKS = 24 };

/* How far chance may raise a gain. */
static const double whim = 0.25;

typedef struct improver {
    psplat_selection *selection;
    size_t sample_count;
    size_t *first;       /* of each sample's candidates in incident; sample_count + 1 */
    uint32_t *incident;  /* candidates that cover a sample */
    uint16_t *covers;    /* per sample: taken candidates covering it */
    uint8_t *open;       /* per sample: to be covered by this move */
    uint32_t *taken;     /* candidates taken, taken_count */
    uint32_t *places;    /* per candidate: where it is in taken */
    uint32_t *gains;     /* per candidate: open samples it covers */
    uint32_t *touched;   /* candidates that had a gain in this move */
    uint32_t *open_list; /* samples opened by this move */
    size_t taken_count, touched_count, open_count;
    size_t focus; /* moves start at samples from this index on; sample_count: anywhere */
    uint64_t random;
} improver;

/* One move: what it took out, what it put in. */
typedef struct exchange {
    uint32_t removed[MOST_REMOVED], added[MOST_REMOVED];
    size_t removed_count, added_count;
} exchange;

static size_t draw(improver *m, size_t count) {
    return (size_t)(psplat_random_next(&m->random) % count);
}

static void include(improver *m, uint32_t c) {
    psplat_candidate *candidate = &m->selection->candidates[c];
    for (size_t i = 0; i < candidate->covered_count; ++i) m->covers[candidate->covered[i]]++;
    candidate->taken = 1;
    m->places[c] = (uint32_t)m->taken_count;
    m->taken[m->taken_count++] = c;
}

static void exclude(improver *m, uint32_t c) {
    psplat_candidate *candidate = &m->selection->candidates[c];
    for (size_t i = 0; i < candidate->covered_count; ++i) m->covers[candidate->covered[i]]--;
    candidate->taken = 0;
    uint32_t last = m->taken[--m->taken_count];
    m->taken[m->places[c]] = last;
    m->places[last] = m->places[c];
}

static int is_needed(const improver *m, uint32_t c) {
    const psplat_candidate *candidate = &m->selection->candidates[c];
    for (size_t i = 0; i < candidate->covered_count; ++i)
        if (m->covers[candidate->covered[i]] < 2) return 1;
    return 0;
}

/* ---- a move -------------------------------------------------------------------------------- */

static void remove_one(improver *m, exchange *e, uint32_t c) {
    const psplat_candidate *candidate = &m->selection->candidates[c];
    e->removed[e->removed_count++] = c;
    exclude(m, c);
    for (size_t i = 0; i < candidate->covered_count; ++i) {
        uint32_t sample = candidate->covered[i];
        if (m->covers[sample] || m->open[sample]) continue;
        m->open[sample] = 1;
        m->open_list[m->open_count++] = sample;
    }
}

static uint32_t first_removed(improver *m) {
    if (m->focus < m->sample_count) {
        size_t sample = m->focus + draw(m, m->sample_count - m->focus);
        for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i)
            if (m->selection->candidates[m->incident[i]].taken) return m->incident[i];
    }
    return m->taken[draw(m, m->taken_count)];
}

/* Takes out a random candidate and its neighbours: others that cover some sample of those out. */
static void remove_neighbors(improver *m, exchange *e) {
    size_t wanted = LEAST_REMOVED + draw(m, MOST_REMOVED - LEAST_REMOVED);
    remove_one(m, e, first_removed(m));
    for (size_t at = 0; at < e->removed_count && e->removed_count < wanted; ++at) {
        const psplat_candidate *candidate = &m->selection->candidates[e->removed[at]];
        if (!candidate->covered_count) continue;
        for (int look = 0; look < LOOKS && e->removed_count < wanted; ++look) {
            uint32_t sample = candidate->covered[draw(m, candidate->covered_count)];
            if (m->open[sample]) continue; /* none taken covers it any more */
            for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i)
                if (m->selection->candidates[m->incident[i]].taken) {
                    remove_one(m, e, m->incident[i]);
                    break;
                }
        }
    }
}

static void count_gains(improver *m) {
    m->touched_count = 0;
    for (size_t k = 0; k < m->open_count; ++k) {
        size_t sample = m->open_list[k];
        for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i) {
            uint32_t c = m->incident[i];
            if (m->gains[c]++ == 0) m->touched[m->touched_count++] = c;
        }
    }
}

/* The candidate of the largest gain, give or take a whim of this move. */
static uint32_t best_candidate(const improver *m, uint64_t whims) {
    uint32_t best = PSPLAT_NONE;
    double most = 0;
    for (size_t i = 0; i < m->touched_count; ++i) {
        uint32_t c = m->touched[i];
        if (!m->gains[c]) continue;
        uint64_t state = whims + c;
        double gain = (double)m->gains[c] * (1 + whim * psplat_random_unit(&state));
        if (gain > most) most = gain, best = c;
    }
    return best;
}

static void close_samples(improver *m, uint32_t c, size_t *left) {
    const psplat_candidate *candidate = &m->selection->candidates[c];
    for (size_t k = 0; k < candidate->covered_count; ++k) {
        size_t sample = candidate->covered[k];
        if (!m->open[sample]) continue;
        m->open[sample] = 0;
        --*left;
        for (size_t i = m->first[sample]; i < m->first[sample + 1]; ++i) --m->gains[m->incident[i]];
    }
}

/* Covers the open samples with at most as many candidates as went out. Returns 0 where that takes
 * more. */
static int recover(improver *m, exchange *e) {
    size_t left = m->open_count;
    uint64_t whims = psplat_random_next(&m->random);
    while (left && e->added_count < e->removed_count) {
        uint32_t best = best_candidate(m, whims);
        if (best == PSPLAT_NONE) return 0;
        e->added[e->added_count++] = best;
        close_samples(m, best, &left);
        include(m, best);
    }
    return left == 0;
}

static void undo(improver *m, const exchange *e) {
    for (size_t i = 0; i < e->added_count; ++i) exclude(m, e->added[i]);
    for (size_t i = 0; i < e->removed_count; ++i) include(m, e->removed[i]);
}

static void move(improver *m) {
    exchange e = {.removed_count = 0};
    m->open_count = 0;
    remove_neighbors(m, &e);
    count_gains(m);
    if (!recover(m, &e)) {
        undo(m, &e);
    } else {
        for (size_t i = 0; i < e.added_count; ++i)
            if (!is_needed(m, e.added[i])) exclude(m, e.added[i]);
    }
    for (size_t i = 0; i < m->open_count; ++i) m->open[m->open_list[i]] = 0;
    for (size_t i = 0; i < m->touched_count; ++i) m->gains[m->touched[i]] = 0;
}

/* ---- setting up ---------------------------------------------------------------------------- */

static int index_samples(improver *m) {
    const psplat_selection *selection = m->selection;
    m->first = calloc(m->sample_count + 2, sizeof *m->first);
    if (!m->first) return 0;
    size_t *starts = m->first + 1; /* shifted by one, so that filling leaves first right */
    for (size_t c = 0; c < selection->count; ++c)
        for (size_t i = 0; i < selection->candidates[c].covered_count; ++i)
            starts[selection->candidates[c].covered[i] + 1]++;
    for (size_t i = 0; i < m->sample_count; ++i) starts[i + 1] += starts[i];
    m->incident = malloc((starts[m->sample_count] + 1) * sizeof *m->incident);
    if (!m->incident) return 0;
    for (uint32_t c = 0; c < selection->count; ++c)
        for (size_t i = 0; i < selection->candidates[c].covered_count; ++i)
            m->incident[starts[selection->candidates[c].covered[i]]++] = c;
    return 1;
}

static int improver_begin(improver *m) {
    size_t count = m->selection->count + 1;
    m->covers = calloc(m->sample_count + 1, sizeof *m->covers);
    m->open = calloc(m->sample_count + 1, 1);
    m->open_list = malloc((m->sample_count + 1) * sizeof *m->open_list);
    m->taken = malloc(count * sizeof *m->taken);
    m->places = malloc(count * sizeof *m->places);
    m->gains = calloc(count, sizeof *m->gains);
    m->touched = malloc(count * sizeof *m->touched);
    if (!m->covers || !m->open || !m->open_list || !m->taken || !m->places || !m->gains ||
        !m->touched || !index_samples(m))
        return 0;
    for (uint32_t c = 0; c < m->selection->count; ++c)
        if (m->selection->candidates[c].taken) include(m, c);
    return 1;
}

static void improver_end(improver *m) {
    free(m->first);
    free(m->incident);
    free(m->covers);
    free(m->open);
    free(m->open_list);
    free(m->taken);
    free(m->places);
    free(m->gains);
    free(m->touched);
}

/* Drops what greedy choice left without a sample of its own, the latest taken first. */
static void prune(improver *m) {
    for (size_t i = m->taken_count; i-- > 0;)
        if (!is_needed(m, m->taken[i])) exclude(m, m->taken[i]);
}

psplat_result psplat_improve(psplat_selection *selection, size_t sample_count, size_t focus,
                             size_t moves, uint64_t seed) {
    improver m = {
        .selection = selection, .sample_count = sample_count, .focus = focus, .random = seed};
    int ok = improver_begin(&m);
    if (ok) prune(&m);
    for (size_t i = 0; ok && m.taken_count && i < moves; ++i) move(&m);
    improver_end(&m);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}
