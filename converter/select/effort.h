/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * effort.h - what the effort of a conversion buys.
 */
#ifndef PHONGSPLAT_SELECT_EFFORT_H
#define PHONGSPLAT_SELECT_EFFORT_H

#include "select/conversion.h"

/* How often a conversion tries to get better. */
typedef struct psplat_effort {
    int search_rounds; /* of relaxation and local search after the greedy cover, which save splats;
                          0 or more */
    int ray_rounds;    /* in which rays look for gaps between splats (finish/close_rays.h), at most;
                          1 or more */
} psplat_effort;

/* Returns what desc->effort, which has to be in its range, asks for. */
psplat_effort psplat_effort_of(const psplat_convert_desc *desc);

#endif
