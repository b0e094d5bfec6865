/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_spill.h - whether what a splat shows beyond a crease can be seen to be wrong.
 */
#ifndef PHONGSPLAT_MEASURE_CREASE_SPILL_H
#define PHONGSPLAT_MEASURE_CREASE_SPILL_H

#include <phongsplat/splat.h>

#include "features/surface.h"
#include "measure/measured_splats.h"

#include <stddef.h>
#include <stdint.h>

/* A crease that lies inside a splat of its own sheet. */
typedef struct psplat_crease_crossing {
    uint32_t edge; /* 3 * triangle + k of the crease, on the splat's side */
    uint32_t splat;
    double depth;    /* greatest distance, in the splat's plane, from the crease to its outline, of
                        the points of the crease within the tolerance of the splat's surface */
    double point[3]; /* on the crease, at the greatest depth */
} psplat_crease_crossing;

/* Drops the crossings beyond whose crease the splat shows nothing but surface: each of its points
 * there, farther than the tolerance from the crease, lies within the tolerance of a triangle of the
 * splat's own material whose normal differs from that of the splat's surface by less than 30
 * degrees, the angle at which an edge becomes a crease. So the creases of another sheet close by do
 * not count, nor those across which shading turns too little to be seen. The crossings are sorted
 * by splat; those left keep their order. *count becomes their number. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_drop_unseen_crossings(const psplat_surface *surface,
                                           const psplat_measured_splats *measured,
                                           psplat_crease_crossing *crossings, size_t *count);

#endif
