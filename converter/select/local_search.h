/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * local_search.h - large-neighbourhood search for a set cover of fewer candidates.
 */
#ifndef PHONGSPLAT_SELECT_LOCAL_SEARCH_H
#define PHONGSPLAT_SELECT_LOCAL_SEARCH_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "features/surface.h"
#include "select/selection.h"

#include <stdint.h>

typedef struct psplat_local_search_desc {
    const psplat_samples *samples;
    size_t moves; /* the number of exchanges tried; 0: only drops candidates that are not needed */
    size_t focus; /* moves start at samples from this index on; samples->count: anywhere */
    int axis;     /* 0, 1 or 2: the axis along which the surface is cut into slabs for the cores */
    uint64_t seed;
    int strict; /* 1: keeps only moves that save a candidate; 0: also those that save none */
    const psplat_surface
        *surface; /* of whose apron no sample has to be covered; NULL: it has none */
} psplat_local_search_desc;

/* Exchanges taken candidates for others of the pool, so that fewer cover the same samples. Never
 * takes more than before, nor leaves a sample uncovered that was covered. The result does not
 * depend on the number of threads. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_local_search(psplat_selection *selection,
                                  const psplat_local_search_desc *desc);

#endif
