/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * record.h - what a finished task leaves: the tiles that it wrote, and what blocks above need to
 * know.
 */
#ifndef PHONGSPLAT_TILES_RECORD_H
#define PHONGSPLAT_TILES_RECORD_H

#include <phongsplat/splat.h>

#include "tiles/tile.h"
#include "verify/report.h"

#include <stddef.h>
#include <stdint.h>

/* The promises that conversions of a task break. */
typedef struct psplat_tile_broken {
    int promises[PSPLAT_PROMISE_COUNT]; /* 1: a level breaks it */
    psplat_promise first;               /* of the first level that breaks any; with none, all of
                                           this is 0 */
    double position[3];                 /* where, in the coordinates of the source */
    double tolerance_percent;           /* of that level, in % of the diagonal */
} psplat_tile_broken;

/* Returns whether any promise is broken. */
int psplat_tile_is_broken(const psplat_tile_broken *broken);

/* Returns what messages call a promise. */
const char *psplat_tile_promise_name(psplat_promise promise);

/* A record. Levels of its tiles count upwards to coarser ones: 0 is the finest of the whole
 * tileset, since nobody knows yet how many there will be. Zero-initialise it. */
typedef struct psplat_tile_record {
    char task[PSPLAT_CELL_PATH + 1];
    int coarsest;     /* the level of its coarsest tiles */
    double deviation; /* of the block's simplified mesh from the source, a length */
    psplat_tile_broken broken;
    psplat_tile *tiles;
    size_t tile_count;
} psplat_tile_record;

/* Writes a record of the plan with this hash; the file is whole or not there. Errors:
 * PSPLAT_ERROR_WRITE, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_record_write(const psplat_tile_record *record, uint64_t plan,
                                       const char *path, psplat_error *error);

/* Reads a record. Errors: PSPLAT_ERROR_READ (there is none), PSPLAT_ERROR_UNSUPPORTED (of another
 * version), PSPLAT_ERROR_FORMAT (of another plan, or not whole), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_record_read(const char *path, uint64_t plan, psplat_tile_record *record,
                                      psplat_error *error);

void psplat_tile_record_free(psplat_tile_record *record);

#endif
