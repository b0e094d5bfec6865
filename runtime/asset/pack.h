/* SPDX-License-Identifier: MIT
 *
 * pack.h - splats as the GPU takes them: the texels of layout.h, and chunks.
 */
#ifndef PHONGSPLAT_ASSET_PACK_H
#define PHONGSPLAT_ASSET_PACK_H

#include "core/arena.h"
#include "core/chunk.h"

/* What is stored of each splat, and so how many floats it takes in each texture; 0: none there. */
typedef struct psplat_packing {
    int splat_floats, clip_floats, finish_floats;
    unsigned finish; /* PSPLAT_FINISH_ bits but COLOR */
} psplat_packing;

/* Of a batch's clip_count and has_ members. */
psplat_packing psplat_packing_of(const psplat_batch *batch);

/* The splats of one primitive; arrays are NULL where a splat has no floats there. */
typedef struct psplat_packed {
    float *splats, *clips, *finishes;
    psplat_chunk *chunks; /* psplat_chunk_count of them */
} psplat_packed;

/* All arrays, uninitialised; NULL when out of memory. */
psplat_packed *psplat_packed_reserve(psplat_arena *arena, const psplat_packing *packing,
                                     size_t splat_count);

/* Writes count splats, or finishes, one after another. */
void psplat_pack_splats(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                        float *out);
void psplat_pack_clips(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                       float *out);
void psplat_pack_finishes(const psplat_packing *packing, const psplat_finish *finishes,
                          size_t count, float *out);

/* What an asset keeps of a batch's splats where it was opened for drawing alone, else NULL. */
const psplat_packed *psplat_asset_packed(const psplat_asset *asset, size_t batch);

#endif
