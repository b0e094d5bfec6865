/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * selection.h - a pool of candidates, of which those that are taken make up the selection.
 */
#ifndef PHONGSPLAT_SELECT_SELECTION_H
#define PHONGSPLAT_SELECT_SELECTION_H

#include <phongsplat/splat.h>

#include "fit/candidate.h"
#include "fit/fit_context.h"

#include <stdint.h>

/* A pool of candidates, some of them taken. */
typedef struct psplat_selection {
    psplat_candidate *candidates;
    size_t count, capacity;
} psplat_selection;

/* Appends a candidate, which moves: *candidate is zeroed. Returns 0, and leaves it, when out of
 * memory. */
int psplat_selection_push(psplat_selection *selection, psplat_candidate *candidate);

/* Grows a candidate around each of count seeds (samples), on all cores, and appends them in the
 * order of the seeds, not taken. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_selection_grow(const psplat_fit_context *context, const uint32_t *seeds,
                                    size_t count, psplat_selection *selection);

/* The same around samples that are spread evenly over all, 128 at most, to find how large splats
 * become and what they show. */
psplat_result psplat_selection_grow_trials(const psplat_fit_context *context,
                                           psplat_selection *selection);

/* Frees the candidates that are not taken; the others keep their order. */
void psplat_selection_drop_untaken(psplat_selection *selection);

/* Copies all candidates with what they own into *copy, which the caller frees with
 * psplat_selection_free. Fails only with PSPLAT_ERROR_MEMORY; *copy is empty then. */
psplat_result psplat_selection_copy(const psplat_selection *selection, psplat_selection *copy);

/* Frees all candidates, and zeroes the selection. */
void psplat_selection_free(psplat_selection *selection);

/* Returns how many candidates are taken. */
size_t psplat_selection_taken(const psplat_selection *selection);

/* Returns how many candidates are recorded to cover each sample: samples numbers, which the caller
 * frees; NULL when out of memory. */
uint32_t *psplat_selection_count_covers(const psplat_selection *selection, size_t samples);

#endif
