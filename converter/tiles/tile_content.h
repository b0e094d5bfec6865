/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile_content.h - the content of a tile: those of a conversion's splats that its cell gets, as a
 * GLB, and what is known of them.
 */
#ifndef PHONGSPLAT_TILES_TILE_CONTENT_H
#define PHONGSPLAT_TILES_TILE_CONTENT_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "export/fallback_mesh.h"
#include "export/meshopt_codec.h"
#include "splats/splats.h"
#include "tiles/cell_tree.h"
#include "tiles/tile.h"
#include "verify/observations.h"

#include <stdint.h>

/* A level of a block, which its tiles share. Owns nothing. */
typedef struct psplat_tile_source {
    const psplat_splats *splats;
    const psplat_region *regions;            /* of the splats */
    const psplat_observations *observations; /* of the verification */
    const psplat_fallback_mesh *fallback;    /* or NULL */
    const psplat_codec *codec;               /* or NULL */
    double tolerance;  /* what each point of the surface that is not open is covered within */
    double deviation;  /* of the mesh from the source */
    double margin;     /* of the cut: each part has all splats that reach this near to its cell */
    double open_reach; /* how far an open point may be from the one that stands for it */
    int level;
} psplat_tile_source;

/* Stores what is known of the splats of a part: all of *tile but its bytes, and but what samples
 * tell: normal_error is 0, and error knows of no open points. */
void psplat_tile_describe(const psplat_tile_source *source, const psplat_tile_part *part,
                          psplat_tile *tile);

/* Adds what was measured at samples and at open points to the tiles of a level, whose parts (count)
 * are those of the last cut of the tree. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_add_observations(const psplat_tile_source *source,
                                           const psplat_cell_tree *tree,
                                           const psplat_tile_part *parts, psplat_tile *tiles,
                                           size_t count);

/* Makes the GLB of a part: *data (*size bytes) is malloc'ed and owned by the caller. A splat has
 * the same values in all tiles that get it. Errors: those of psplat_glb_write. */
psplat_result psplat_tile_pack(const psplat_tile_source *source, const psplat_tile_part *part,
                               uint8_t **data, size_t *size, psplat_error *error);

#endif
