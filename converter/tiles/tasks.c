/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tasks.c - the blocks of a tileset as tasks.
 *
 * The blocks are the tree of the leaves' paths without its nodes of one child (a Patricia tree).
 */
#include "tiles/tasks.h"

#include "base/vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct builder {
    const psplat_tile_leaves *leaves;
    double apron;
    psplat_tile_task *list;
    size_t count, root;
} builder;

static psplat_tile_cell grown(const psplat_tile_cell *cell, double apron) {
    psplat_tile_cell reach = *cell;
    int axis = psplat_tile_cell_axis(cell);
    double width = apron * (cell->high[axis] - cell->low[axis]);
    for (int k = 0; k < 3; ++k) {
        reach.low[k] -= width;
        reach.high[k] += width;
        reach.holds_high[k] = 1;
    }
    return reach;
}

/* Appends the task of a path. */
static psplat_tile_task *add(builder *b, const char *path) {
    psplat_tile_task *task = &b->list[b->count++];
    *task = (psplat_tile_task){.leaf = SIZE_MAX, .children = {PSPLAT_NO_TASK, PSPLAT_NO_TASK}};
    psplat_tile_cell_find(&b->leaves->root, path, &task->cell);
    task->reach = grown(&task->cell, b->apron);
    snprintf(task->name, sizeof task->name, "r%s", path);
    return task;
}

static void unite_boxes(psplat_tile_task *task, const psplat_tile_task *with) {
    for (int k = 0; k < 3; ++k) {
        task->low[k] = min2(task->low[k], with->low[k]);
        task->high[k] = max2(task->high[k], with->high[k]);
    }
}

/* Makes the task of leaves from begin to end, whose paths are equal up to depth, and those below
 * it. Returns its index. */
static size_t add_tree(builder *b, size_t begin, size_t end, size_t depth) {
    const psplat_tile_leaf *leaves = b->leaves->leaves;
    char path[PSPLAT_MOST_BLOCK_DEPTH + 1];
    if (end - begin == 1) {
        psplat_tile_task *task = add(b, leaves[begin].path);
        task->leaf = begin;
        memcpy(task->low, leaves[begin].low, sizeof task->low);
        memcpy(task->high, leaves[begin].high, sizeof task->high);
        return b->count - 1;
    }
    while (leaves[begin].path[depth] == leaves[end - 1].path[depth]) ++depth;
    size_t middle = begin;
    while (leaves[middle].path[depth] == '0') ++middle;
    size_t lower = add_tree(b, begin, middle, depth + 1);
    size_t upper = add_tree(b, middle, end, depth + 1);
    memcpy(path, leaves[begin].path, depth);
    path[depth] = 0;
    psplat_tile_task *task = add(b, path);
    task->children[0] = lower;
    task->children[1] = upper;
    memcpy(task->low, b->list[lower].low, sizeof task->low);
    memcpy(task->high, b->list[lower].high, sizeof task->high);
    unite_boxes(task, &b->list[upper]);
    return b->count - 1;
}

/* Returns whether triangles of a task may meet a cell. */
static int may_meet(const psplat_tile_task *task, const psplat_tile_cell *reach) {
    for (int k = 0; k < 3; ++k)
        if (!(task->low[k] <= reach->high[k] && task->high[k] >= reach->low[k])) return 0;
    return 1;
}

/* Lists what a task needs of another one and those below it, and takes the waves of what it waits
 * for. needs is NULL in a first pass that only counts. */
static void find_needs(const builder *b, psplat_tile_task *task, size_t other,
                       psplat_tile_need *needs) {
    const psplat_tile_task *o = &b->list[other];
    if (!may_meet(o, &task->reach)) return;
    int is_leaf = o->leaf != SIZE_MAX, is_finer = o->cell.depth > task->cell.depth;
    if (!is_leaf && (!is_finer || task->leaf != SIZE_MAX)) {
        find_needs(b, task, o->children[0], needs);
        find_needs(b, task, o->children[1], needs);
        return;
    }
    int is_original = task->leaf != SIZE_MAX || !is_finer;
    if (needs) needs[task->need_count] = (psplat_tile_need){other, is_original};
    ++task->need_count;
    if (!is_original && task->wave <= o->wave) task->wave = o->wave + 1;
}

/* Adds what the children of an inner block have although they own no triangles near it: nothing,
 * but the block waits for them. */
static void wait_for_children(const builder *b, psplat_tile_task *task) {
    for (int i = 0; i < 2; ++i)
        if (task->children[i] != PSPLAT_NO_TASK && task->wave <= b->list[task->children[i]].wave)
            task->wave = b->list[task->children[i]].wave + 1;
}

/* Finds what tasks need, finer cells first, so that their waves are known. */
static int find_all_needs(builder *b) {
    for (size_t depth = PSPLAT_MOST_BLOCK_DEPTH + 1; depth-- > 0;)
        for (size_t i = 0; i < b->count; ++i) {
            psplat_tile_task *task = &b->list[i];
            if (task->cell.depth != depth) continue;
            find_needs(b, task, b->root, NULL);
            task->needs = malloc((task->need_count + 1) * sizeof *task->needs);
            if (!task->needs) return 0;
            task->need_count = 0;
            find_needs(b, task, b->root, task->needs);
            wait_for_children(b, task);
        }
    return 1;
}

static int compare_tasks(const void *left, const void *right) {
    const psplat_tile_task *const *a = left, *const *b = right;
    if ((*a)->wave != (*b)->wave) return (*a)->wave < (*b)->wave ? -1 : 1;
    return strcmp((*a)->name, (*b)->name);
}

static size_t renumbered(const size_t *numbers, size_t task) {
    return task == PSPLAT_NO_TASK ? task : numbers[task];
}

/* Sorts the tasks by wave and path. */
static int sort_tasks(builder *b) {
    const psplat_tile_task **order = malloc((b->count + 1) * sizeof *order);
    size_t *numbers = malloc((b->count + 1) * sizeof *numbers);
    psplat_tile_task *sorted = malloc((b->count + 1) * sizeof *sorted);
    int has_memory = order && numbers && sorted;
    for (size_t i = 0; i < b->count && has_memory; ++i) order[i] = &b->list[i];
    if (has_memory) qsort(order, b->count, sizeof *order, compare_tasks);
    for (size_t i = 0; i < b->count && has_memory; ++i) numbers[order[i] - b->list] = i;
    for (size_t i = 0; i < b->count && has_memory; ++i) {
        sorted[i] = *order[i];
        for (int k = 0; k < 2; ++k)
            sorted[i].children[k] = renumbered(numbers, sorted[i].children[k]);
        for (size_t k = 0; k < sorted[i].need_count; ++k)
            sorted[i].needs[k].task = numbers[sorted[i].needs[k].task];
    }
    free(order);
    free(numbers);
    if (has_memory) {
        free(b->list);
        b->list = sorted;
    }
    return has_memory;
}

psplat_result psplat_tile_tasks_make(const psplat_tile_leaves *leaves, double apron,
                                     psplat_tile_tasks *tasks) {
    builder b = {.leaves = leaves, .apron = apron};
    *tasks = (psplat_tile_tasks){0};
    b.list = calloc(2 * leaves->count + 1, sizeof *b.list);
    if (!b.list) return PSPLAT_ERROR_MEMORY;
    b.root = add_tree(&b, 0, leaves->count, 0);
    int has_memory = find_all_needs(&b) && sort_tasks(&b);
    *tasks = (psplat_tile_tasks){b.list, b.count};
    if (!has_memory) psplat_tile_tasks_free(tasks);
    return has_memory ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

size_t psplat_tile_tasks_find(const psplat_tile_tasks *tasks, const char *name) {
    for (size_t i = 0; i < tasks->count; ++i)
        if (!strcmp(tasks->list[i].name, name)) return i;
    return PSPLAT_NO_TASK;
}

void psplat_tile_tasks_free(psplat_tile_tasks *tasks) {
    for (size_t i = 0; i < tasks->count; ++i) free(tasks->list[i].needs);
    free(tasks->list);
    *tasks = (psplat_tile_tasks){0};
}
