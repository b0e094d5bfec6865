/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile.h - what is known of a tile: its cell and level, its content, and how far that errs.
 */
#ifndef PHONGSPLAT_TILES_TILE_H
#define PHONGSPLAT_TILES_TILE_H

#include "tiles/cell.h"

#include <stddef.h>

/* Room for the name of a content with its folder, and a zero. */
enum { PSPLAT_TILE_CONTENT = PSPLAT_CELL_PATH + 32 };

/* A tile: splats that cover the surface in a cell by themselves, within the tolerance of a level.
 * Lengths and positions are those of the source, with Y up as glTF has it. */
typedef struct psplat_tile {
    char path[PSPLAT_CELL_PATH]; /* of the cell */
    int level;                   /* 0: the coarsest; tolerances halve from one to the next */
    double region[6];            /* lower and upper corner of the cell */
    double bounds[6];            /* of all that the content shows */
    double error;                /* proven: each point of the splats is within it of the surface,
                                    and each point of the surface in the cell is of the splats */
    double normal_error;         /* root mean square of the blended normals, degrees; 0 where it
                                    was not measured */
    double cone[4];              /* unit axis, and the least cosine between it and the normals of
                                    all splats' surfaces; absent where that is not above 0 */
    size_t splats, bytes;        /* of the content */
    char content[PSPLAT_TILE_CONTENT]; /* relative to the tileset, as "tiles/2-01.glb" */
} psplat_tile;

#endif
