/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * placed.h - the splats of an asset where its nodes place them, in double.
 */
#ifndef PHONGSPLAT_PLACED_H
#define PHONGSPLAT_PLACED_H

#include "stages.h"

#include <phongsplat/phongsplat.h>

typedef struct psplat_placed {
    psplat_measured splats;  /* without a locator and a tolerance */
    double depth;            /* greatest depth of a field */
    psplat_locator *locator; /* finds the regions themselves */
} psplat_placed;

/* Splats of all batches, in the coordinates of the scene less origin, axes orthogonal again and
 * clip lines and normals with them (spec 4). Those of singular transforms are not there: they draw
 * nothing. Without a transform other than a translation they are what is stored. Errors: MEMORY,
 * RANGE. */
psplat_result psplat_placed_create(const psplat_asset *asset, const double origin[3],
                                   psplat_placed *placed, psplat_error *error);
/* Makes placed->splats find regions from as far as reach. MEMORY is the only failure. */
psplat_result psplat_placed_reach(psplat_placed *placed, double reach);
/* Accepts a zero-initialised struct. */
void psplat_placed_free(psplat_placed *placed);

#endif
