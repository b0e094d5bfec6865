/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sort_splats.h - the conversion of candidates to splats, in the order of a file.
 */
#ifndef PHONGSPLAT_SELECT_SORT_SPLATS_H
#define PHONGSPLAT_SELECT_SORT_SPLATS_H

#include <phongsplat/splat.h>

#include "appearance/appearance.h"
#include "select/selection.h"
#include "splats/splats.h"

#include <stdint.h>

/* How candidates become splats. */
typedef struct psplat_sort_desc {
    float depth_tolerance, flat_depth_tolerance; /* of runs; lengths; the second is that of plane
                                                    candidates with is_flat */
    const uint32_t *groups;                      /* by triangle: its material; NULL: all are 0 */
    const psplat_kept_textures *kept;            /* by material; NULL: no textures are kept */
    int has_color, has_finish;
} psplat_sort_desc;

/* Converts the taken candidates to splats in single precision. They are sorted by their number of
 * clip lines, then by how many of these are seams, then flat ones, other plane ones and curved
 * ones, then by material, and then along a Morton curve. Curved candidates whose field is not that
 * of their surface (up to the rounding to float) have no slope at the centre; one of them gives its
 * whole run shapes of its own. Sets splats, finishes, texcoords, runs, their counts and has_color,
 * and frees what splats held of these before. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_sort_splats(const psplat_selection *selection, const psplat_sort_desc *storing,
                                 psplat_splats *splats);

#endif
