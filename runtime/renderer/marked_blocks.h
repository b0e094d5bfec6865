/* SPDX-License-Identifier: MIT
 *
 * marked_blocks.h - the blocks of a view that splats may cover. The resolve pass draws no others:
 * where splats are few and large, it is the pass that costs most, and a rectangle around a model
 * has up to twice the pixels that the model covers.
 */
#ifndef PHONGSPLAT_RENDERER_MARKED_BLOCKS_H
#define PHONGSPLAT_RENDERER_MARKED_BLOCKS_H

#include "renderer/screen_extent.h"

#include <stdint.h>

enum { PSPLAT_BLOCKS = 64 }; /* along the longer side of a view, at most */

typedef struct psplat_marked_blocks {
    int size;                     /* of a block, pixels */
    uint64_t rows[PSPLAT_BLOCKS]; /* bit i of row k: the block at size * i, size * k */
} psplat_marked_blocks;

/* Marks no block of a view of so many pixels. */
void psplat_marked_blocks_clear(psplat_marked_blocks *blocks, int width, int height);

/* Marks the blocks that a rectangle meets, which lies in the view. */
void psplat_marked_blocks_add(psplat_marked_blocks *blocks, const psplat_screen_extent *extent);

/* Takes marked blocks away that make up a rectangle, and returns its pixels, as far as they lie in
 * `within`. It is empty where no block is left. */
psplat_screen_extent psplat_marked_blocks_take(psplat_marked_blocks *blocks,
                                               const psplat_screen_extent *within);

#endif
