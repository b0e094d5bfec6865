/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile_node.c - the run of one task of a plan.
 *
 * A leaf block is converted from the finest level on, until one tile has all of it. An inner block
 * begins where all simplified meshes that it takes are near enough: one level above the coarsest of
 * their blocks. So its tiles are coarser than all below.
 */
#define _XOPEN_SOURCE 700

#include "tiles/tile_node.h"

#include "base/output.h"
#include "base/vector.h"
#include "export/meshopt_codec.h"
#include "mesh/clean.h"
#include "mesh/mesh.h"
#include "mesh/weld.h"
#include "tiles/block_mesh.h"
#include "tiles/blocks.h"
#include "tiles/plan_folder.h"
#include "tiles/simplify.h"
#include "tiles/tile_block.h"
#include "verify/report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* How far simplified meshes may be from the source, in tolerances of the finest level that is made
 * of them, and how much farther when the borders between them are simplified, too. Conversions get
 * that much less. */
static const double deviation_part = 0.05, united_part = 0.08;
/* The greatest tolerance of which deviations are a part, in diagonals of what a block owns. The
 * coarsest tolerance of a level is half of that (tiles/tile_block.c), and the next one above is
 * what the mesh is simplified for. */
static const double greatest_share = 0.4;
/* The level that tile_block knows as the finest of all. It counts levels up to the finest, records
 * count from there. Chains of blocks may be as deep as cells, each a level above the one below. */
enum { FINEST_LEVEL = 4 * PSPLAT_MOST_CELL_DEPTH };

typedef struct node_run {
    const psplat_tile_plan *plan;
    const psplat_tile_task *task;
    const char *directory;
    char *work; /* the path of work/ */
    int steps;  /* of the block's finest level, above the finest of all */
    double deviation;
    psplat_tile_run *run;
} node_run;

static psplat_result fail_memory(psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for a block");
}

static double tolerance_of(const psplat_tile_plan *plan, int steps) {
    double percent = plan->options.convert.tolerance_percent;
    return ldexp((percent > 0 ? percent : 0.5) / 100 * plan->diagonal, steps);
}

/* Returns the length of which a simplified mesh that a block makes may use a part: the tolerance so
 * many steps above the finest, but no more than a share of what the block has itself. Where stray
 * points make a source much larger than what a block sees, tolerances, which double from block to
 * block above it, are longer than the block. */
static double simplified_tolerance(const node_run *n, int steps) {
    const psplat_tile_task *task = n->task;
    double diagonal[3];
    if (!(task->low[0] <= task->high[0])) return 0; /* It owns no triangle. */
    sub3(diagonal, task->high, task->low);
    return fmin(tolerance_of(n->plan, steps), greatest_share * length3(diagonal));
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static psplat_tile_soup begin_soup(const node_run *n, const psplat_tile_cell *reach) {
    return (psplat_tile_soup){.has_colors = n->plan->leaves.has_colors,
                              .has_normals =
                                  n->plan->leaves.has_normals && n->task->leaf != SIZE_MAX,
                              .reach = reach};
}

/* Adds the triangles that a leaf owns. */
static psplat_result add_leaf(const node_run *n, size_t leaf, psplat_tile_soup *soup,
                              psplat_error *error) {
    char *store = psplat_tile_path(n->work, "triangles", "");
    if (!store) return fail_memory(error);
    psplat_result result =
        psplat_tile_leaf_read(&n->plan->leaves, leaf, store, psplat_tile_soup_add, soup, error);
    free(store);
    return result;
}

/* Adds the simplified mesh of a task. */
static psplat_result add_simplified(node_run *n, size_t task, psplat_tile_soup *soup,
                                    psplat_error *error) {
    psplat_mesh mesh;
    double deviation = 0;
    char *path = psplat_tile_path(n->work, n->plan->tasks.list[task].name, ".mesh");
    if (!path) return fail_memory(error);
    psplat_result result = psplat_tile_mesh_read(path, &mesh, &deviation, error);
    free(path);
    if (result) return result;
    n->deviation = fmax(n->deviation, deviation);
    result = psplat_tile_soup_add_mesh(soup, &mesh) ? fail_memory(error) : PSPLAT_OK;
    psplat_mesh_free(&mesh);
    return result;
}

/* Gathers the mesh of a block with its apron. */
static psplat_result gather_block(node_run *n, psplat_tile_soup *soup, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < n->task->need_count && !result; ++i) {
        const psplat_tile_need *need = &n->task->needs[i];
        result = need->is_original ? add_leaf(n, n->plan->tasks.list[need->task].leaf, soup, error)
                                   : add_simplified(n, need->task, soup, error);
    }
    return result;
}

/* Gathers the triangles that a block owns. */
static psplat_result gather_owned(node_run *n, psplat_tile_soup *soup, psplat_error *error) {
    if (n->task->leaf != SIZE_MAX) return add_leaf(n, n->task->leaf, soup, error);
    psplat_result result = PSPLAT_OK;
    for (int i = 0; i < 2 && !result; ++i)
        result = add_simplified(n, n->task->children[i], soup, error);
    return result;
}

/* ---- conversion ------------------------------------------------------------------------------ */

static void content_name(char name[PSPLAT_TILE_CONTENT], int steps, const char *path) {
    snprintf(name, PSPLAT_TILE_CONTENT, "tiles/%d-r%s.glb", steps, path);
}

static psplat_result write_content(void *user, const psplat_tile *tile, const uint8_t *data,
                                   size_t size, psplat_error *error) {
    const node_run *n = user;
    char name[PSPLAT_TILE_CONTENT];
    content_name(name, FINEST_LEVEL - tile->level, tile->path);
    char *path = psplat_tile_path(n->directory, name, "");
    if (!path) return fail_memory(error);
    psplat_result result = psplat_output_write(path, data, size, 1, error);
    free(path);
    return result;
}

/* Cells at or below those of the blocks below are not halved, since their tiles would not nest. */
static int may_halve(void *user, const psplat_tile_cell *cell) {
    const node_run *n = user;
    for (int i = 0; i < 2; ++i) {
        size_t child = n->task->children[i];
        if (child != PSPLAT_NO_TASK &&
            psplat_tile_path_is_in(cell->path, n->plan->tasks.list[child].cell.path))
            return 0;
    }
    return 1;
}

/* Notes what the report of a level says of broken promises. */
static void take_broken(psplat_tile_broken *broken, const psplat_report *report) {
    if (psplat_report_broken(report) == PSPLAT_PROMISE_COUNT) return;
    if (!psplat_tile_is_broken(broken)) {
        broken->first = report->places[0].promise;
        memcpy(broken->position, report->places[0].position, sizeof broken->position);
        broken->tolerance_percent = report->tolerance_percent;
    }
    for (size_t i = 0; i < report->place_count; ++i)
        broken->promises[report->places[i].promise] = 1;
}

/* Moves the tiles of a block into the record, with its names and numbers of levels. */
static void take_tiles(node_run *n, psplat_tile_block *block) {
    psplat_tile_record *record = &n->run->record;
    record->tiles = block->tiles;
    record->tile_count = block->tile_count;
    record->coarsest = n->steps;
    block->tiles = NULL;
    for (size_t i = 0; i < record->tile_count; ++i) {
        psplat_tile *tile = &record->tiles[i];
        tile->level = FINEST_LEVEL - tile->level;
        if (tile->level > record->coarsest) record->coarsest = tile->level;
        content_name(tile->content, tile->level, tile->path);
    }
    for (size_t i = 0; i < block->level_count; ++i)
        take_broken(&record->broken, &block->levels[i].report);
}

static psplat_result convert_mesh(node_run *n, const psplat_mesh *mesh,
                                  const psplat_convert_desc *convert, psplat_error *error) {
    psplat_tile_block block = {0};
    const psplat_tile_block_desc desc = {
        .mesh = mesh,
        .root = &n->plan->leaves.root,
        .path = n->task->cell.path,
        .convert = convert,
        .finest = FINEST_LEVEL - n->steps,
        .deviation = n->deviation,
        .codec = n->plan->options.no_compress ? NULL : &psplat_meshopt_codec,
        .has_fallback = n->plan->options.has_fallback,
        .most = (size_t)n->plan->options.most_splats,
        .may_halve = may_halve,
        .write = write_content,
        .user = n,
    };
    psplat_error cause = {0};
    psplat_result result = psplat_tile_block_make(&desc, &block, &cause);
    if (result == PSPLAT_ERROR_NO_SPLATS) result = PSPLAT_OK; /* Nothing there has an area. */
    if (result) psplat_fail(error, result, 0, "%s: %.200s", n->task->name, cause.text);
    if (!result) take_tiles(n, &block);
    psplat_tile_block_free(&block);
    return result;
}

/* Returns the options of the block's finest level. */
static psplat_convert_desc options_of(const node_run *n) {
    psplat_convert_desc options = n->plan->options.convert;
    double root = sqrt(ldexp(1, n->steps)); /* as in tile_block.c */
    options.tolerance_percent =
        100 * (tolerance_of(n->plan, n->steps) - n->deviation) / n->plan->diagonal;
    options.diagonal = n->plan->diagonal;
    options.normal_tolerance_degrees = fmin(options.normal_tolerance_degrees * root, 90);
    options.color_tolerance_percent = fmin(options.color_tolerance_percent * root, 100);
    return options;
}

/* Welds triangles, and drops those without area, as conversions do. No splat is made for them, and
 * many on one line make the proofs of a simplification take minutes, since each of them is the
 * nearest to what lies there. */
static psplat_result weld(psplat_mesh *mesh, psplat_error *error) {
    psplat_result result = psplat_mesh_weld(mesh, error);
    if (!result) psplat_mesh_drop_flat(mesh);
    return result;
}

/* Puts a simplified mesh in the place of a welded one that is n->deviation from the source, so that
 * it is at most so far away in the end. Where that leaves nothing, the mesh stays as it is. */
static psplat_result simplify(node_run *n, psplat_mesh *mesh, double most, int keeps_border,
                              psplat_error *error) {
    psplat_mesh simple;
    double step;
    if (!(most > n->deviation)) return PSPLAT_OK;
    if (psplat_tile_simplify(mesh, most - n->deviation, keeps_border, &simple, &step))
        return fail_memory(error);
    psplat_mesh_free(mesh);
    *mesh = simple;
    n->deviation += step;
    return PSPLAT_OK;
}

/* Simplifies the united meshes of blocks once more: their borders have all edges of the source, and
 * slivers beside them, whose normals are far from the surface's. So do borders of the source, which
 * are simplified, too, as nothing has to fit this mesh: those that are handed on keep them. */
static psplat_result simplify_united(node_run *n, psplat_tile_soup *soup, psplat_error *error) {
    psplat_result result = weld(&soup->mesh, error);
    if (result) return result;
    return simplify(n, &soup->mesh, united_part * simplified_tolerance(n, n->steps), 0, error);
}

static psplat_result convert_block(node_run *n, const psplat_convert_desc *progress,
                                   psplat_error *error) {
    psplat_tile_soup soup = begin_soup(n, &n->task->reach);
    psplat_result result = gather_block(n, &soup, error);
    n->run->triangles = soup.mesh.triangle_count;
    if (!result && soup.mesh.triangle_count && n->task->leaf == SIZE_MAX)
        result = simplify_united(n, &soup, error);
    soup.mesh.material = n->plan->material;
    if (!result && soup.mesh.triangle_count) {
        result = psplat_mesh_clean(&soup.mesh, n->task->name, 1, error);
        psplat_convert_desc options = options_of(n);
        options.progress = progress->progress;
        options.user = progress->user;
        if (!result) result = convert_mesh(n, &soup.mesh, &options, error);
        if (result == PSPLAT_ERROR_NO_SPLATS) result = PSPLAT_OK;
    }
    psplat_tile_soup_free(&soup);
    return result;
}

/* ---- the simplified mesh --------------------------------------------------------------------- */

static psplat_result write_simplified(node_run *n, psplat_error *error) {
    psplat_tile_record *record = &n->run->record;
    psplat_tile_soup soup = begin_soup(n, NULL);
    double most = deviation_part * simplified_tolerance(n, record->coarsest + 1);
    char *path = psplat_tile_path(n->work, n->task->name, ".mesh");
    n->deviation = 0; /* of the apron does not count here */
    psplat_result result = path ? gather_owned(n, &soup, error) : fail_memory(error);
    n->run->owned = soup.mesh.triangle_count;
    free(soup.mesh.corner_normals);
    soup.mesh.corner_normals = NULL;
    if (!result && soup.mesh.triangle_count) result = weld(&soup.mesh, error);
    if (!result && soup.mesh.triangle_count) result = simplify(n, &soup.mesh, most, 1, error);
    record->deviation = n->deviation;
    n->run->simplified = soup.mesh.triangle_count;
    if (!result) result = psplat_tile_mesh_write(&soup.mesh, record->deviation, path, error);
    psplat_tile_soup_free(&soup);
    free(path);
    return result;
}

/* ---- the task -------------------------------------------------------------------------------- */

/* Reads the record of a task that this one needs, and lifts the finest level above its coarsest. */
static psplat_result take_record(node_run *n, size_t other, psplat_error *error) {
    const char *name = n->plan->tasks.list[other].name;
    struct stat status;
    psplat_tile_record record;
    char *path = psplat_tile_path(n->work, name, ".record");
    if (!path) return fail_memory(error);
    psplat_result result =
        stat(path, &status)
            ? psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: needs task %s, which is not done",
                          n->task->name, name)
            : psplat_tile_record_read(path, n->plan->hash, &record, error);
    free(path);
    if (result) return result;
    if (n->steps <= record.coarsest) n->steps = record.coarsest + 1;
    psplat_tile_record_free(&record);
    return PSPLAT_OK;
}

static psplat_result take_records(node_run *n, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < n->task->need_count && !result; ++i)
        if (!n->task->needs[i].is_original) result = take_record(n, n->task->needs[i].task, error);
    for (int i = 0; i < 2 && !result; ++i)
        if (n->task->children[i] != PSPLAT_NO_TASK)
            result = take_record(n, n->task->children[i], error);
    return result;
}

/* Returns whether a file is there, of this size unless that is 0. */
static int has_file(const char *directory, const char *name, const char *suffix, size_t size) {
    struct stat status;
    char *path = psplat_tile_path(directory, name, suffix);
    int has = path && !stat(path, &status) && (!size || (size_t)status.st_size == size);
    free(path);
    return has;
}

/* Returns whether no block is above this one, so that nobody needs its mesh. */
static int is_last(const node_run *n) {
    return n->task == &n->plan->tasks.list[n->plan->tasks.count - 1];
}

/* Returns whether all that a run leaves is there, with its record. */
static int is_done(node_run *n, const char *record_path) {
    psplat_tile_record *record = &n->run->record;
    psplat_error ignored = {0};
    if (!has_file(n->work, n->task->name, ".record", 0) ||
        psplat_tile_record_read(record_path, n->plan->hash, record, &ignored))
        return 0;
    int done = !strcmp(record->task, n->task->name) &&
               (has_file(n->work, n->task->name, ".mesh", 0) || is_last(n));
    for (size_t i = 0; i < record->tile_count && done; ++i)
        done = has_file(n->directory, record->tiles[i].content, "", record->tiles[i].bytes);
    if (!done) psplat_tile_record_free(record);
    return done;
}

static psplat_result run_task(node_run *n, const psplat_convert_desc *progress,
                              const char *record_path, psplat_error *error) {
    snprintf(n->run->record.task, sizeof n->run->record.task, "%s", n->task->name);
    psplat_result result = take_records(n, error);
    if (!result) result = convert_block(n, progress, error);
    if (!result && !is_last(n)) result = write_simplified(n, error);
    if (result) return result;
    return psplat_tile_record_write(&n->run->record, n->plan->hash, record_path, error);
}

psplat_result psplat_tile_node_run(const psplat_tile_plan *plan, const char *directory, size_t task,
                                   int (*progress)(void *user, const char *stage, double fraction),
                                   void *user, psplat_tile_run *run, psplat_error *error) {
    const psplat_convert_desc shown = {.progress = progress, .user = user};
    node_run n = {
        .plan = plan, .task = &plan->tasks.list[task], .directory = directory, .run = run};
    *run = (psplat_tile_run){0};
    n.work = psplat_tile_path(directory, "work", "");
    char *path = n.work ? psplat_tile_path(n.work, n.task->name, ".record") : NULL;
    psplat_result result = PSPLAT_OK;
    if (!path)
        result = fail_memory(error);
    else if (is_done(&n, path))
        run->was_done = 1;
    else
        result = run_task(&n, &shown, path, error);
    free(n.work);
    free(path);
    if (result) psplat_tile_record_free(&run->record);
    return result;
}
