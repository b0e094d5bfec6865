/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * block_boxes.h - boxes around blocks of a list whose neighbours are mostly neighbours in space, as
 * triangles of a mesh are: a search of the whole list for what is near a point skips most blocks,
 * and meets the rest in the order of the list.
 */
#ifndef PHONGSPLAT_BASE_BLOCK_BOXES_H
#define PHONGSPLAT_BASE_BLOCK_BOXES_H

#include <phongsplat/splat.h>

#include <stddef.h>

/* The items of a block. */
enum { PSPLAT_BLOCK_ITEMS = 64 };

/* The boxes of a list: block i is of the items from i PSPLAT_BLOCK_ITEMS on. */
typedef struct psplat_block_boxes {
    double (*lows)[3], (*highs)[3]; /* count of each */
    size_t count, item_count;
} psplat_block_boxes;

/* Makes empty boxes for so many items, which psplat_block_boxes_free frees. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_block_boxes_create(size_t item_count, psplat_block_boxes *boxes);

/* Widens the box of an item's block to a point. */
void psplat_block_boxes_add(psplat_block_boxes *boxes, size_t item, const double point[3]);

/* Returns the first item, from one on, whose block's box meets the cube around a point with this
 * half side, or item_count. */
size_t psplat_block_boxes_next(const psplat_block_boxes *boxes, size_t item, const double point[3],
                               double reach);

/* Frees what boxes owns, and zeroes it. */
void psplat_block_boxes_free(psplat_block_boxes *boxes);

#endif
