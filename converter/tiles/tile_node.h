/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile_node.h - the run of one task of a plan: a block becomes tiles, and a simplified mesh for the
 * blocks above.
 */
#ifndef PHONGSPLAT_TILES_TILE_NODE_H
#define PHONGSPLAT_TILES_TILE_NODE_H

#include <phongsplat/splat.h>

#include "tiles/plan.h"
#include "tiles/record.h"

#include <stddef.h>

/* What a run did. */
typedef struct psplat_tile_run {
    psplat_tile_record record; /* of the task; psplat_tile_record_free frees it */
    int was_done;              /* it was there already, so that nothing was done */
    size_t triangles;          /* of the block with its apron */
    size_t owned, simplified;  /* triangles of the block alone, and of its simplified mesh */
} psplat_tile_run;

/* Runs a task unless its record and all that this names are there. Everything is written to a
 * temporary name first, the record last, so that a run that is killed leaves nothing half and may
 * be repeated; equal plans give equal bytes, whatever else runs at the time. progress and user are
 * those of psplat_convert_desc, or NULL. Errors: PSPLAT_ERROR_READ (a task that this one needs is
 * not done; the text names it), those of psplat_tile_block_make, of files of the directory, and
 * PSPLAT_ERROR_WRITE. */
psplat_result psplat_tile_node_run(const psplat_tile_plan *plan, const char *directory, size_t task,
                                   int (*progress)(void *user, const char *stage, double fraction),
                                   void *user, psplat_tile_run *run, psplat_error *error);

#endif
