/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * selection.c - a pool of candidates: its memory, new candidates on all cores, and which are taken.
 */
#include "select/selection.h"

#include "features/samples.h"
#include "fit/candidate.h"
#include "fit/fit_context.h"
#include "fit/grow_candidate.h"

#include <stdlib.h>

/* The most candidates that are grown as a trial. Chosen by hand. */
enum { TRIALS = 128 };

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

psplat_result psplat_selection_copy(const psplat_selection *selection, psplat_selection *copy) {
    *copy = (psplat_selection){0};
    for (size_t i = 0; i < selection->count; ++i) {
        psplat_candidate candidate;
        if (psplat_candidate_copy(&selection->candidates[i], &candidate) &&
            psplat_selection_push(copy, &candidate))
            continue;
        psplat_candidate_free(&candidate);
        psplat_selection_free(copy);
        return PSPLAT_ERROR_MEMORY;
    }
    return PSPLAT_OK;
}

size_t psplat_selection_taken(const psplat_selection *selection) {
    size_t count = 0;
    for (size_t i = 0; i < selection->count; ++i) count += selection->candidates[i].taken != 0;
    return count;
}

uint32_t *psplat_selection_count_covers(const psplat_selection *selection, size_t samples) {
    uint32_t *covers = calloc(samples + 1, sizeof *covers);
    for (size_t i = 0; covers && i < selection->count; ++i) {
        const psplat_candidate *candidate = &selection->candidates[i];
        for (size_t k = 0; k < candidate->covered_count; ++k) ++covers[candidate->covered[k]];
    }
    return covers;
}

void psplat_selection_drop_untaken(psplat_selection *selection) {
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

/* Seeds and the candidates that grow around them. */
typedef struct grow_job {
    const uint32_t *seeds;
    psplat_candidate *grown;
} grow_job;

static psplat_result grow_one(const psplat_fit_context *context, size_t index, void *user) {
    const grow_job *n = user;
    return psplat_candidate_grow(context, n->seeds[index], &n->grown[index]);
}

psplat_result psplat_selection_grow(const psplat_fit_context *context, const uint32_t *seeds,
                                    size_t count, psplat_selection *selection) {
    psplat_candidate *grown = calloc(count + 1, sizeof *grown);
    if (!grown) return PSPLAT_ERROR_MEMORY;
    grow_job n = {seeds, grown};
    psplat_result result = psplat_fit_each(context, count, grow_one, &n);
    for (size_t i = 0; i < count; ++i) {
        if (!result && !psplat_selection_push(selection, &grown[i])) result = PSPLAT_ERROR_MEMORY;
        psplat_candidate_free(&grown[i]);
    }
    free(grown);
    return result;
}

psplat_result psplat_selection_grow_trials(const psplat_fit_context *context,
                                           psplat_selection *selection) {
    uint32_t seeds[TRIALS];
    size_t samples = context->samples->count, count = samples < TRIALS ? samples : TRIALS;
    for (size_t i = 0; i < count; ++i) seeds[i] = (uint32_t)(i * samples / count);
    return psplat_selection_grow(context, seeds, count, selection);
}
