/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * block_boxes.c - boxes around blocks of a list.
 */
#include "base/block_boxes.h"

#include "base/vector.h"

#include <math.h>
#include <stdlib.h>

psplat_result psplat_block_boxes_create(size_t item_count, psplat_block_boxes *boxes) {
    size_t count = item_count / PSPLAT_BLOCK_ITEMS + (item_count % PSPLAT_BLOCK_ITEMS > 0);
    *boxes = (psplat_block_boxes){.lows = malloc((count + 1) * sizeof *boxes->lows),
                                  .highs = malloc((count + 1) * sizeof *boxes->highs),
                                  .count = count,
                                  .item_count = item_count};
    if (!boxes->lows || !boxes->highs) {
        psplat_block_boxes_free(boxes);
        return PSPLAT_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) boxes->lows[i][k] = HUGE_VAL, boxes->highs[i][k] = -HUGE_VAL;
    return PSPLAT_OK;
}

void psplat_block_boxes_add(psplat_block_boxes *boxes, size_t item, const double point[3]) {
    double *low = boxes->lows[item / PSPLAT_BLOCK_ITEMS];
    double *high = boxes->highs[item / PSPLAT_BLOCK_ITEMS];
    for (int k = 0; k < 3; ++k) low[k] = min2(low[k], point[k]), high[k] = max2(high[k], point[k]);
}

static int meets(const psplat_block_boxes *boxes, size_t block, const double point[3],
                 double reach) {
    const double *low = boxes->lows[block], *high = boxes->highs[block];
    for (int k = 0; k < 3; ++k)
        if (!(low[k] <= point[k] + reach && high[k] >= point[k] - reach)) return 0;
    return 1;
}

size_t psplat_block_boxes_next(const psplat_block_boxes *boxes, size_t item, const double point[3],
                               double reach) {
    size_t block = item / PSPLAT_BLOCK_ITEMS;
    if (item % PSPLAT_BLOCK_ITEMS) return item < boxes->item_count ? item : boxes->item_count;
    while (block < boxes->count && !meets(boxes, block, point, reach)) ++block;
    return block < boxes->count ? block * PSPLAT_BLOCK_ITEMS : boxes->item_count;
}

void psplat_block_boxes_free(psplat_block_boxes *boxes) {
    free(boxes->lows);
    free(boxes->highs);
    *boxes = (psplat_block_boxes){0};
}
