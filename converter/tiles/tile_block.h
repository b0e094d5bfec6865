/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile_block.h - the tiles of a block: of a mesh that is converted in one piece, level by level.
 */
#ifndef PHONGSPLAT_TILES_TILE_BLOCK_H
#define PHONGSPLAT_TILES_TILE_BLOCK_H

#include <phongsplat/splat.h>

#include "export/meshopt_codec.h"
#include "mesh/mesh.h"
#include "select/conversion.h"
#include "tiles/cell.h"
#include "tiles/tile.h"
#include "verify/report.h"

#include <stdint.h>

/* The most splats of a tile whose cell could be halved, by default. Smaller cells overlap their
 * neighbours more, larger ones fit views less. */
enum { PSPLAT_MOST_TILE_SPLATS = 1024 };

/* What a block is. Zeros are the defaults of what may be NULL or 0. Owns nothing. */
typedef struct psplat_tile_block_desc {
    const psplat_mesh *mesh;      /* with its apron: the triangles near the cell */
    const psplat_tile_cell *root; /* of all tiles */
    const char *path;             /* of the block's cell; NULL: the root */
    /* The options of the finest level; those of coarser ones follow from them. tolerance_percent is
     * in % of diagonal, which is that of the whole source, or 0: that of the mesh. owned and
     * is_written_in_parts are ignored, and so is bake_textures: textures are always baked. */
    const psplat_convert_desc *convert;
    int finest;  /* the level with these options; -1: that for which the coarsest is level 0 */
    size_t most; /* splats of a tile whose cell could be halved; 0: PSPLAT_MOST_TILE_SPLATS */
    /* How far the mesh and the source are apart, both ways, in the mesh's units: it is added to all
     * errors. 0: the mesh is the source. */
    double deviation;
    const psplat_codec *codec; /* of the contents; NULL: they are not compressed */
    int has_fallback;          /* 1: contents have a simplified mesh for viewers without splats */
    /* Returns whether a cell of the block may be halved; NULL: every one may. A tree of blocks says
     * 0 for the cells of the blocks below, whose tiles would not nest otherwise. */
    int (*may_halve)(void *user, const psplat_tile_cell *cell);
    /* Takes the content (size bytes of GLB) of a tile, whose members are all set. It is called in
     * the order of the tiles, from one thread. Its failure ends the block. */
    psplat_result (*write)(void *user, const psplat_tile *tile, const uint8_t *data, size_t size,
                           psplat_error *error);
    void *user;
} psplat_tile_block_desc;

/* One level of a block. */
typedef struct psplat_tile_level {
    int level;
    size_t tiles, splats, tile_splats, bytes; /* tile_splats: with those of several tiles counted
                                                 for each; bytes: of all contents */
    double error;                             /* the greatest of its tiles */
    psplat_report report;                     /* of the conversion */
} psplat_tile_level;

/* The tiles of a block, coarsest level first and by path within a level. */
typedef struct psplat_tile_block {
    psplat_tile *tiles;
    size_t tile_count;
    psplat_tile_level *levels; /* coarsest first */
    size_t level_count;
} psplat_tile_block;

/* Converts the block at the finest level and then with tolerances that double, until one tile holds
 * all of it, or until coarser levels save next to nothing. A cell of a level is halved while more
 * than `most` splats reach it, and at least where the level above halved it. The result
 * is the same for any number of threads. psplat_tile_block_free frees *block. Errors: those of
 * psplat_convert, of psplat_scene_write and of write; *block is empty then. */
psplat_result psplat_tile_block_make(const psplat_tile_block_desc *desc, psplat_tile_block *block,
                                     psplat_error *error);

/* Frees what the block holds, and zeroes it. */
void psplat_tile_block_free(psplat_tile_block *block);

#endif
