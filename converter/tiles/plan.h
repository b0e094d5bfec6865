/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plan.h - how a source that is larger than memory becomes a tileset: its blocks, and the tasks
 * that convert them.
 *
 * Leaf blocks (tiles/blocks.h) are converted at the finest levels. Inner blocks (tiles/tasks.h)
 * convert the simplified meshes of those below at coarser levels, up to one that has all. A
 * directory OUT/ holds, besides the tileset,
 *
 *     plan               what this header describes, as text
 *     tasks, tasks-N     the names of all tasks, and of those of wave N, one a line; a task needs
 *                        none but tasks of waves before its own
 *     Makefile           builds all
 *     work/triangles     the triangles of all leaf blocks
 *     work/TASK.mesh     the simplified mesh of a finished block (tiles/block_mesh.h)
 *     work/TASK.record   its tiles (tiles/record.h)
 */
#ifndef PHONGSPLAT_TILES_PLAN_H
#define PHONGSPLAT_TILES_PLAN_H

#include <phongsplat/splat.h>

#include "select/conversion.h"
#include "tiles/blocks.h"
#include "tiles/tasks.h"

#include <stdint.h>

/* What the user asks for. */
typedef struct psplat_tile_options {
    psplat_convert_desc convert; /* of the finest level, as a share of the source's diagonal */
    int no_compress;             /* 1: contents are not compressed */
    int has_fallback;            /* 1: contents have a simplified mesh */
    uint64_t most_triangles;     /* of a leaf block */
    uint64_t most_splats;        /* of a tile whose cell could be halved; 0: 1024 */
    double apron;                /* its width, in longest sides of a block's cell */
} psplat_tile_options;

/* A plan. Zero-initialise it. */
typedef struct psplat_tile_plan {
    psplat_tile_options options;
    psplat_material material;        /* of all triangles */
    char *input;                     /* its absolute path */
    uint64_t input_size, input_hash; /* the hash is of parts of it */
    psplat_tile_leaves leaves;
    psplat_tile_tasks tasks;
    double diagonal; /* of the source's box */
    uint64_t hash;   /* of the text of the plan */
} psplat_tile_plan;

/* Sorts the triangles of a file into blocks and writes the plan and all that belongs to it to a
 * directory, which is made where it does not exist. program is what the Makefile calls
 * unless its variable PHONGSPLAT is set. A directory
 * with a plan of the same input and options and with work/triangles stays as it is; one with
 * another plan, or with that one alone, is refused unless overwrite is set; one with anything else
 * is refused. Everything is made in OUT/work.new/ first. Then what the plan before had made is
 * deleted (tiles/plan_folder.h), so that a failure before that leaves the directory as it was.
 * Errors: those of psplat_tile_leaves_sort; PSPLAT_ERROR_WRITE. */
psplat_result psplat_tile_plan_make(const char *input, const psplat_tile_options *options,
                                    const char *program, const char *directory, int overwrite,
                                    psplat_tile_plan *plan, psplat_error *error);

/* Reads the plan of a directory. Errors: PSPLAT_ERROR_READ, PSPLAT_ERROR_UNSUPPORTED (of another
 * version), PSPLAT_ERROR_FORMAT (it is not whole), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_tile_plan_read(const char *directory, psplat_tile_plan *plan,
                                    psplat_error *error);

/* Refuses (PSPLAT_ERROR_FORMAT) a plan whose input is there but another than when it was made. An
 * input that is not there is not needed. */
psplat_result psplat_tile_plan_check_input(const psplat_tile_plan *plan, psplat_error *error);

void psplat_tile_plan_free(psplat_tile_plan *plan);

#endif
