/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_crossings.h - creases and borders that lie too deep inside a splat of their own patch.
 */
#ifndef PHONGSPLAT_MEASURE_CREASE_CROSSINGS_H
#define PHONGSPLAT_MEASURE_CREASE_CROSSINGS_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "features/surface.h"
#include "measure/measured_splats.h"

#include <stdint.h>

/* A crease that lies inside a splat of its own patch. */
typedef struct psplat_crease_crossing {
    uint32_t edge; /* 3 * triangle + k of the crease, on the splat's side */
    uint32_t splat;
    double depth;    /* greatest distance, in the splat's plane, from the crease to its outline */
    double point[3]; /* on the crease, at the greatest depth */
} psplat_crease_crossing;

/* Finds the crossings deeper than limit, a length, and stores them in *crossings (*count, malloc'ed
 * and owned by the caller) in the order of splats and then edges. *greatest becomes the greatest
 * depth of the crossings stored or, where there are none, of those up to limit. The samples tell
 * which patches a splat covers most of; creases of other patches are left out. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_crease_crossings_find(const psplat_surface *surface,
                                           const psplat_samples *samples,
                                           const psplat_measured_splats *measured, double limit,
                                           psplat_crease_crossing **crossings, size_t *count,
                                           double *greatest);

#endif
