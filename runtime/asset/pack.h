/* SPDX-License-Identifier: MIT
 *
 * pack.h - splats in the form that the GPU takes: the texels of layout.h, and chunks.
 */
#ifndef PHONGSPLAT_ASSET_PACK_H
#define PHONGSPLAT_ASSET_PACK_H

#include "core/arena.h"
#include "core/chunk.h"

/* Says what is stored of each splat: how many floats it takes in each texture, 0 where there is no
 * such texture. */
typedef struct psplat_packing {
    int splat_floats, clip_floats, finish_floats, texcoord_floats;
    int line_floats;       /* of one clip line: 3, or 4 where lines are bent */
    int texcoord_channels; /* of each texel of texture coordinates: 3, or 4 where COLOR_0 has an
                              alpha beside them */
    int is_curved;
    int wide_at, shape_at; /* where a splat's texels of colour and gamma and of its shape begin, in
                              floats; 0: there is none */
    int row_splats;        /* splats in a row of each texture (layout.h) */
    unsigned finish;       /* PSPLAT_FINISH_ bits without COLOR */
} psplat_packing;

/* Returns the packing that follows from a batch's clip_count, is_curved and has_ members. */
psplat_packing psplat_packing_of(const psplat_batch *batch);

/* The splats of one primitive. An array is NULL where a splat has no floats in it. */
typedef struct psplat_packed {
    float *splats, *clips, *finishes, *texcoords;
    psplat_chunk *chunks; /* psplat_chunk_count entries */
} psplat_packed;

/* Allocates all arrays, uninitialised. Returns NULL when out of memory. */
psplat_packed *psplat_packed_reserve(psplat_arena *arena, const psplat_packing *packing,
                                     size_t splat_count);

/* Writes count splats, or finishes, or texture coordinates, one after another. Where colours are
 * stored, the alpha of each splat's colour lies beside its texture coordinates. */
void psplat_pack_splats(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                        float *out);
void psplat_pack_clips(const psplat_packing *packing, const psplat_splat *splats, size_t count,
                       float *out);
void psplat_pack_finishes(const psplat_packing *packing, const psplat_finish *finishes,
                          size_t count, float *out);
void psplat_pack_texcoords(const psplat_packing *packing, const psplat_splat *splats,
                           const psplat_texcoord *texcoords, size_t count, float *out);

/* Returns how far the surface of a splat leaves its tangent plane at the centre, at most and along
 * N, over count packed splats; 0 where they are flat. In the units of the centres. */
float psplat_packed_sagitta(const psplat_packing *packing, const float *splats, size_t count);

/* Writes a sphere around each of count packed splats, or around the ellipse in its tangent plane
 * where that reaches further: centre and radius. */
void psplat_packed_spheres(const psplat_packing *packing, const float *splats, size_t count,
                           float *spheres);

/* Returns how many of count splats, whose clip lines are packed, no line cuts: all of theirs are
 * (1, 0, 1), a tangent of the unit circle, which stands for a line where a splat has fewer than its
 * batch. The shaders compare the same numbers. */
size_t psplat_packed_uncut(const psplat_packing *packing, const float *clips, size_t count);

/* Returns what an asset keeps of a batch's splats where it was opened only for drawing, else
 * NULL. */
const psplat_packed *psplat_asset_packed(const psplat_asset *asset, size_t batch);

#endif
