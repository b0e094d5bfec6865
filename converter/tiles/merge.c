/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * merge.c - the tileset of all finished tasks of a plan.
 */
#define _XOPEN_SOURCE 700

#include "tiles/merge.h"

#include "base/output.h"
#include "base/path.h"
#include "tiles/plan_folder.h"
#include "tiles/record.h"
#include "tiles/tileset.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* The names of missing tasks that an error has. */
enum { NAMES_SHOWN = 4 };

typedef struct merge {
    const psplat_tile_plan *plan;
    const char *directory;
    char shown[PSPLAT_SHOWN_PATH]; /* directory, for errors */
    psplat_tile *tiles;
    size_t count;
    psplat_tile_summary *summary;
    char *head; /* the text of tileset.json, which is written last */
    size_t head_size;
} merge;

static psplat_result fail_memory(psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for the tileset");
}

/* Returns the size of a file, or -1. */
static long long size_of(const char *directory, const char *name, const char *suffix) {
    struct stat status;
    char *path = psplat_tile_path(directory, name, suffix);
    long long size = path && !stat(path, &status) ? (long long)status.st_size : -1;
    free(path);
    return size;
}

/* ---- records --------------------------------------------------------------------------------- */

/* Refuses where records are missing. */
static psplat_result check_records(const merge *m, const char *work, psplat_error *error) {
    const psplat_tile_tasks *tasks = &m->plan->tasks;
    char names[NAMES_SHOWN * (PSPLAT_TASK_NAME + 2) + 8] = "";
    size_t missing = 0;
    for (size_t i = 0; i < tasks->count; ++i) {
        if (size_of(work, tasks->list[i].name, ".record") >= 0) continue;
        if (missing < NAMES_SHOWN) strcat(strcat(names, " "), tasks->list[i].name);
        if (missing == NAMES_SHOWN) strcat(names, " ...");
        ++missing;
    }
    if (!missing) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: %zu of %zu tasks are not done:%s",
                       m->shown, missing, tasks->count, names);
}

/* Counts the promises that a task breaks. */
static void count_broken(psplat_tile_summary *summary, const psplat_tile_record *record) {
    if (!psplat_tile_is_broken(&record->broken)) return;
    for (int i = 0; i < PSPLAT_PROMISE_COUNT; ++i)
        summary->broken[i] += record->broken.promises[i] != 0;
    if (summary->broken_tasks++) return;
    summary->first_broken = *record;
    summary->first_broken.tiles = NULL;
    summary->first_broken.tile_count = 0;
}

static psplat_result take_record(merge *m, const char *work, const psplat_tile_task *task,
                                 psplat_error *error) {
    psplat_tile_record record;
    char *path = psplat_tile_path(work, task->name, ".record");
    if (!path) return fail_memory(error);
    psplat_result result = psplat_tile_record_read(path, m->plan->hash, &record, error);
    free(path);
    if (result) return result;
    count_broken(m->summary, &record);
    psplat_tile *larger = realloc(m->tiles, (m->count + record.tile_count + 1) * sizeof *m->tiles);
    if (!larger) result = fail_memory(error);
    if (larger) m->tiles = larger;
    for (size_t i = 0; i < record.tile_count && !result; ++i) {
        const psplat_tile *tile = &record.tiles[i];
        if (size_of(m->directory, tile->content, "") != (long long)tile->bytes)
            result = psplat_fail(error, PSPLAT_ERROR_READ, 0,
                                 "%s: %s: is missing or not of %zu bytes; run task %s again",
                                 m->shown, tile->content, tile->bytes, task->name);
        else
            m->tiles[m->count++] = *tile;
    }
    psplat_tile_record_free(&record);
    return result;
}

static psplat_result take_records(merge *m, psplat_error *error) {
    char *work = psplat_tile_path(m->directory, "work", "");
    if (!work) return fail_memory(error);
    psplat_result result = check_records(m, work, error);
    for (size_t i = 0; i < m->plan->tasks.count && !result; ++i)
        result = take_record(m, work, &m->plan->tasks.list[i], error);
    free(work);
    if (!result && !m->count)
        result =
            psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: no triangle has an area", m->shown);
    return result;
}

/* Numbers levels from the coarsest one on, as tilesets do. Returns how many there are. */
static int number_levels(merge *m) {
    int coarsest = 0;
    for (size_t i = 0; i < m->count; ++i)
        if (m->tiles[i].level > coarsest) coarsest = m->tiles[i].level;
    for (size_t i = 0; i < m->count; ++i) m->tiles[i].level = coarsest - m->tiles[i].level;
    return coarsest + 1;
}

/* ---- tileset --------------------------------------------------------------------------------- */

static psplat_result write_file(const merge *m, const char *name, const char *text, size_t size,
                                psplat_error *error) {
    char *path = psplat_tile_path(m->directory, name, "");
    if (!path) return fail_memory(error);
    psplat_result result = psplat_output_write(path, text, size, 1, error);
    free(path);
    return result;
}

static psplat_result take_tileset(void *user, const char *name, const char *text, size_t size,
                                  psplat_error *error) {
    merge *m = user;
    if (strcmp(name, "tileset.json") != 0) return write_file(m, name, text, size, error);
    m->head = malloc(size + 1);
    if (!m->head) return fail_memory(error);
    memcpy(m->head, text, size);
    m->head_size = size;
    return PSPLAT_OK;
}

static psplat_result summarise(const merge *m, const size_t *parents, psplat_tile_summary *summary,
                               psplat_error *error) {
    uint8_t *has_children = calloc(m->count + 1, 1);
    if (!has_children) return fail_memory(error);
    for (size_t i = 0; i < m->count; ++i)
        if (parents[i] != SIZE_MAX) has_children[parents[i]] = 1;
    summary->tiles = m->count;
    summary->error = m->tiles[0].error;
    for (size_t i = 0; i < m->count; ++i) {
        summary->splats += m->tiles[i].splats;
        summary->bytes += m->tiles[i].bytes;
        if (!has_children[i]) summary->finest_splats += m->tiles[i].splats;
    }
    free(has_children);
    return PSPLAT_OK;
}

static psplat_result write_tileset(merge *m, psplat_tile_summary *summary, psplat_error *error) {
    size_t *parents = malloc((m->count + 1) * sizeof *parents);
    psplat_result result =
        parents ? psplat_tileset_arrange(m->tiles, m->count, parents, error) : fail_memory(error);
    if (!result)
        result = psplat_tileset_write(m->tiles, m->count, parents, 0, take_tileset, m, error);
    if (!result) result = write_file(m, "tileset.json", m->head, m->head_size, error);
    if (!result) result = summarise(m, parents, summary, error);
    free(parents);
    return result;
}

psplat_result psplat_tile_merge(const psplat_tile_plan *plan, const char *directory,
                                psplat_tile_summary *summary, psplat_error *error) {
    merge m = {.plan = plan, .directory = directory, .summary = summary};
    *summary = (psplat_tile_summary){0};
    psplat_path_shorten(directory, m.shown);
    psplat_result result = take_records(&m, error);
    if (!result) {
        summary->levels = (size_t)number_levels(&m);
        result = write_tileset(&m, summary, error);
    }
    free(m.tiles);
    free(m.head);
    return result;
}
