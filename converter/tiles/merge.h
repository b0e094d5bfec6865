/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * merge.h - the tileset of all finished tasks of a plan.
 */
#ifndef PHONGSPLAT_TILES_MERGE_H
#define PHONGSPLAT_TILES_MERGE_H

#include <phongsplat/splat.h>

#include "tiles/plan.h"
#include "tiles/record.h"

#include <stddef.h>

/* What a tileset has. */
typedef struct psplat_tile_summary {
    size_t tiles, levels, splats, finest_splats, bytes; /* finest_splats: of tiles without children;
                                                           bytes: of all contents */
    double error;                                       /* of the root */
    size_t broken_tasks, broken[PSPLAT_PROMISE_COUNT];  /* tasks that break any promise, and each */
    psplat_tile_record first_broken; /* of those the first, without its tiles; in the order of the
                                        plan */
} psplat_tile_summary;

/* Reads the records of all tasks, checks that their contents are there, links tiles to the next
 * coarser ones, raises errors to those below, and writes tileset.json and what it names, the first
 * one last. Errors: PSPLAT_ERROR_READ (records or contents are missing; the text names the first),
 * those of psplat_tile_record_read, PSPLAT_ERROR_NO_SPLATS (no tile at all), PSPLAT_ERROR_WRITE,
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_merge(const psplat_tile_plan *plan, const char *directory,
                                psplat_tile_summary *summary, psplat_error *error);

#endif
