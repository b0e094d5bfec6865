/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * blocks.h - the triangles of a file, sorted into blocks: cells that each hold few enough of them.
 *
 * A block owns the triangles whose centroids lie in its cell, so that every triangle is stored
 * once. What a block needs around its cell is read from its neighbours.
 */
#ifndef PHONGSPLAT_TILES_BLOCKS_H
#define PHONGSPLAT_TILES_BLOCKS_H

#include <phongsplat/splat.h>

#include "import/triangle_stream.h"
#include "mesh/mesh.h"
#include "tiles/cell.h"

#include <stddef.h>
#include <stdint.h>

/* The greatest depth of the cell of a block. */
enum { PSPLAT_MOST_BLOCK_DEPTH = PSPLAT_MOST_CELL_DEPTH };

/* A block of triangles. */
typedef struct psplat_tile_leaf {
    char path[PSPLAT_MOST_BLOCK_DEPTH + 1]; /* of its cell */
    uint64_t first, count;                  /* the triangles that it owns, in the store */
    double low[3], high[3];                 /* their box; low > high where it owns none */
} psplat_tile_leaf;

/* All blocks, and what their triangles have in common. Zero-initialise it. */
typedef struct psplat_tile_leaves {
    psplat_tile_cell root;
    psplat_tile_leaf *leaves; /* in the order of their paths; each meets a triangle */
    size_t count;
    uint64_t triangles;
    int is_single, has_normals, has_colors; /* what the store has of a triangle */
    int is_closed; /* each edge has as many triangles on its left as on its right; wrong only where
                      64 random bits are all 0 */
} psplat_tile_leaves;

/* Sorts the triangles of a stream into blocks of at most `most` (> 0) triangles, unless a cell of
 * 2^-22 of the root's longest side has more, and writes them to the file `store`, block by block
 * and in each in the order of the stream. Reads the stream by a counting sort (Knuth, The Art of
 * Computer Programming 3, section 5.2) three times: the box, the counts of small cells, the
 * triangles; and once more for every few levels by which the blocks of very uneven triangles are
 * deeper. Takes memory for the counts, for a few kilobytes of each block, and no more for more
 * triangles. The store has its name once it is whole. Errors: those of the stream,
 * PSPLAT_ERROR_NO_SPLATS (no triangle), PSPLAT_ERROR_WRITE, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_leaves_sort(psplat_triangle_stream *stream, uint64_t most,
                                      const char *store, psplat_tile_leaves *leaves,
                                      psplat_error *error);

/* Returns the bytes of a triangle in the store. */
size_t psplat_tile_leaves_stride(const psplat_tile_leaves *leaves);

/* Takes a triangle that was read from the store. A return other than 0 means that memory ran out.
 */
typedef int psplat_take_triangle(void *user, const psplat_stream_triangle *triangle);

/* Reads the triangles of one block from the store, in their order. Errors: PSPLAT_ERROR_READ,
 * PSPLAT_ERROR_FORMAT (the store has not the bytes that it should), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_leaf_read(const psplat_tile_leaves *leaves, size_t leaf,
                                    const char *store, psplat_take_triangle *take, void *user,
                                    psplat_error *error);

void psplat_tile_leaves_free(psplat_tile_leaves *leaves);

#endif
