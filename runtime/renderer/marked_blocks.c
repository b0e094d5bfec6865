/* SPDX-License-Identifier: MIT
 *
 * marked_blocks.c - bits of blocks; see marked_blocks.h.
 */
#include "renderer/marked_blocks.h"

#include <string.h>

/* Pixels: smaller blocks would be more rectangles than they save pixels, and rasterisers work on
 * groups of pixels, which borders of blocks should not cut. */
enum { LEAST_SIZE = 16, GROUP = 8 };

void psplat_marked_blocks_clear(psplat_marked_blocks *blocks, int width, int height) {
    int longer = width > height ? width : height;
    int size = (longer + PSPLAT_BLOCKS - 1) / PSPLAT_BLOCKS;
    size = (size + GROUP - 1) / GROUP * GROUP;
    memset(blocks, 0, sizeof *blocks);
    blocks->size = size > LEAST_SIZE ? size : LEAST_SIZE;
}

/* Returns the bits first ... last. */
static uint64_t bits(int first, int last) {
    return (~(uint64_t)0 >> (63 - (last - first))) << first;
}

void psplat_marked_blocks_add(psplat_marked_blocks *blocks, const psplat_screen_extent *extent) {
    if (!(extent->x0 < extent->x1)) return;
    int size = blocks->size;
    uint64_t row = bits(extent->x0 / size, (extent->x1 - 1) / size);
    for (int k = extent->y0 / size; k <= (extent->y1 - 1) / size; ++k) blocks->rows[k] |= row;
}

static int least(int a, int b) {
    return a < b ? a : b;
}

static int most(int a, int b) {
    return a > b ? a : b;
}

psplat_screen_extent psplat_marked_blocks_take(psplat_marked_blocks *blocks,
                                               const psplat_screen_extent *within) {
    int row = 0, first = 0, last, size = blocks->size;
    while (row < PSPLAT_BLOCKS && !blocks->rows[row]) ++row;
    if (row == PSPLAT_BLOCKS) return (psplat_screen_extent){0, 0, 0, 0};
    uint64_t left = blocks->rows[row];
    while (!(left >> first & 1)) ++first;
    for (last = first; last < 63 && left >> (last + 1) & 1; ++last) continue;
    /* The run goes on in the next rows as long as it ends at the same blocks there. */
    uint64_t run = bits(first, last), around = bits(most(first - 1, 0), least(last + 1, 63));
    int end = row;
    for (; end < PSPLAT_BLOCKS && (blocks->rows[end] & around) == run; ++end)
        blocks->rows[end] &= ~run;
    return (psplat_screen_extent){most(first * size, within->x0),
                                  least((last + 1) * size, within->x1),
                                  most(row * size, within->y0), least(end * size, within->y1)};
}
