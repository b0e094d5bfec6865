/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * placed_splats.h - the splats of an asset with the transforms of its nodes applied, in double.
 */
#ifndef PHONGSPLAT_COMPARE_PLACED_SPLATS_H
#define PHONGSPLAT_COMPARE_PLACED_SPLATS_H

#include "base/region_tree.h"
#include "measure/measured_splats.h"

#include <phongsplat/phongsplat.h>

typedef struct psplat_placed_splats {
    psplat_measured_splats splats;   /* its tree and tolerance are set by ..._reach below */
    double depth;                    /* greatest depth tolerance, a length */
    psplat_region_tree *region_tree; /* tree of the regions without any margin */
} psplat_placed_splats;

/* Transforms the splats of all batches to the coordinates of the scene minus origin: axes become
 * orthogonal again, and surfaces, clip lines and normals follow them (spec 4). Splats under a
 * singular transform are left out, since they draw nothing. A pure translation changes nothing but
 * the centres. The caller frees *placed with psplat_placed_splats_free. Errors: MEMORY, RANGE. */
psplat_result psplat_placed_splats_create(const psplat_asset *asset, const double origin[3],
                                          psplat_placed_splats *placed, psplat_error *error);
/* The same for several assets (count) that are shown together. */
psplat_result psplat_placed_splats_create_all(const psplat_asset *const *assets, size_t count,
                                              const double origin[3], psplat_placed_splats *placed,
                                              psplat_error *error);
/* Builds the tree of placed->splats, which finds the splats within reach (a length) of a point.
 * Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_placed_splats_reach(psplat_placed_splats *placed, double reach);
/* Accepts a zero-initialised struct. */
void psplat_placed_splats_free(psplat_placed_splats *placed);

#endif
