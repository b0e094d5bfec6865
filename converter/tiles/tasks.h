/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tasks.h - the blocks of a tileset as tasks: leaf blocks, the inner blocks above them, and what
 * each needs of others.
 */
#ifndef PHONGSPLAT_TILES_TASKS_H
#define PHONGSPLAT_TILES_TASKS_H

#include <phongsplat/splat.h>

#include "tiles/blocks.h"
#include "tiles/cell.h"

#include <stddef.h>

/* Room for the name of a task, r and the path of its cell, and a zero. */
enum { PSPLAT_TASK_NAME = PSPLAT_MOST_BLOCK_DEPTH + 2 };

/* The index of no task. */
#define PSPLAT_NO_TASK SIZE_MAX

/* What a task needs of another one. */
typedef struct psplat_tile_need {
    size_t task;
    int is_original; /* 1: the triangles of a leaf; 0: its simplified mesh, which has to be there */
} psplat_tile_need;

/* A task: a block to be converted. Leaf blocks are those of tiles/blocks.h. Where two halves of a
 * cell have blocks, the cell is an inner block, which converts their simplified meshes. */
typedef struct psplat_tile_task {
    char name[PSPLAT_TASK_NAME];
    psplat_tile_cell cell, reach; /* of the block; reach is the cell with its apron */
    size_t leaf;                  /* the leaf block, or SIZE_MAX for an inner one */
    size_t children[2];           /* of an inner one: tasks */
    double low[3], high[3]; /* the box of the triangles that it owns; low > high without any */
    int wave;               /* 0: needs no other task; else one more than that of any it needs */
    psplat_tile_need *needs;
    size_t need_count;
} psplat_tile_task;

typedef struct psplat_tile_tasks {
    psplat_tile_task *list; /* by wave and path; the last is above all others */
    size_t count;
} psplat_tile_tasks;

/* Makes the tasks of leaf blocks. apron is its width in longest sides of a block's cell. A leaf
 * needs the triangles of all leaves that may meet its reach. An inner block needs the simplified
 * meshes of the blocks of the next finer cells there, and, where a leaf's cell is as large as its
 * own or larger, that leaf's triangles. Fails only with PSPLAT_ERROR_MEMORY; *tasks is then empty.
 */
psplat_result psplat_tile_tasks_make(const psplat_tile_leaves *leaves, double apron,
                                     psplat_tile_tasks *tasks);

/* Returns the task of this name, or PSPLAT_NO_TASK. */
size_t psplat_tile_tasks_find(const psplat_tile_tasks *tasks, const char *name);

void psplat_tile_tasks_free(psplat_tile_tasks *tasks);

#endif
