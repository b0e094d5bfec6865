/* SPDX-License-Identifier: MIT
 *
 * marked_tiles.h - the tiles of a view that splats may cover. The resolve pass draws no others:
 * where splats are few and large, it is the pass that costs most, and a rectangle around a model
 * has up to twice the pixels that the model covers.
 */
#ifndef PHONGSPLAT_RENDERER_MARKED_TILES_H
#define PHONGSPLAT_RENDERER_MARKED_TILES_H

#include "renderer/screen_extent.h"

#include <stdint.h>

enum { PSPLAT_TILES = 64 }; /* along the longer side of a view, at most */

typedef struct psplat_marked_tiles {
    int size;                    /* of a tile, pixels */
    uint64_t rows[PSPLAT_TILES]; /* bit i of row k: the tile at size * i, size * k */
} psplat_marked_tiles;

/* Marks no tile of a view of so many pixels. */
void psplat_marked_tiles_clear(psplat_marked_tiles *tiles, int width, int height);

/* Marks the tiles that a rectangle meets, which lies in the view. */
void psplat_marked_tiles_add(psplat_marked_tiles *tiles, const psplat_screen_extent *extent);

/* Takes marked tiles away that make up a rectangle, and returns its pixels, as far as they lie in
 * `within`. It is empty where no tile is left. */
psplat_screen_extent psplat_marked_tiles_take(psplat_marked_tiles *tiles,
                                              const psplat_screen_extent *within);

#endif
