/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile_block.c - the tiles of a block.
 *
 * All levels are converted first, the finest one first, since it is known only in the end how many
 * there are. Then their splats are handed out to cells, the coarsest level first, since no cell of
 * a finer one may hold several of a coarser one.
 */
#include "tiles/tile_block.h"

#include "appearance/alpha_mask.h"
#include "base/vector.h"
#include "export/fallback_mesh.h"
#include "pipeline/convert.h"
#include "pipeline/schedule.h"
#include "splats/splats.h"
#include "tiles/cell_tree.h"
#include "tiles/tile_content.h"
#include "verify/observations.h"
#include "verify/verify.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The coarsest tolerance of a level, in % of the diagonal of the mesh: beyond, nothing is left to
 * be recognised. Chosen by hand, as in select/conversion.c. */
static const double coarsest_percent = 20;
/* The greatest number of splats of a level, as a part of that of the finer one, for which it is
 * worth having. Doubled tolerances need 0.6 to 0.75 times the splats where surfaces curve. Chosen
 * by hand. */
static const double worthwhile_part = 0.9;
/* The share of the time that the finest of the levels left takes. Chosen by hand. */
static const double finest_share = 0.5;

enum { MOST_LEVELS = 40, BATCH = 32 /* contents that are made at a time */ };

/* A converted level, finest first. */
typedef struct level_work {
    psplat_splats splats;
    psplat_region *regions;
    psplat_observations observations;
    psplat_report report;
    psplat_fallback_mesh fallback;
    float *corners; /* of the triangles of the fallback mesh */
    double tolerance;
} level_work;

typedef struct block_work {
    const psplat_tile_block_desc *desc;
    psplat_tile_cell cell;
    psplat_cell_tree *tree;
    level_work *levels[MOST_LEVELS];
    size_t level_count;
    size_t most;        /* splats of a tile */
    double diagonal;    /* of which the options' percentages are */
    double before, now; /* the shares of the time of the levels before, and of the current one */
} block_work;

static void level_free(level_work *level) {
    if (!level) return;
    psplat_splats_free(&level->splats);
    psplat_observations_free(&level->observations);
    psplat_fallback_mesh_free(&level->fallback);
    free(level->regions);
    free(level->corners);
    free(level);
}

/* ---- conversion ------------------------------------------------------------------------------ */

/* Shows all levels as one stage. */
static int show_progress(void *user, const char *stage, double fraction) {
    const block_work *w = user;
    const psplat_convert_desc *options = w->desc->convert;
    double part = psplat_schedule_done(stage, fraction);
    return options->progress(options->user, "converting meshes",
                             w->before + max2(part, 0) * w->now);
}

/* Returns the options of a level so many steps above the finest. A splat that errs by twice the
 * distance is wider by the root of two, and so its normals and colours err by that much more. */
static psplat_convert_desc options_of(block_work *w, size_t steps) {
    psplat_convert_desc options = *w->desc->convert;
    double doubled = ldexp(1, (int)steps), root = sqrt(doubled);
    if (!(options.tolerance_percent > 0))
        options.tolerance_percent = PSPLAT_DEFAULT_TOLERANCE_PERCENT;
    options.tolerance_percent *= doubled;
    options.diagonal = w->diagonal;
    options.normal_tolerance_degrees = min2(options.normal_tolerance_degrees * root, 90);
    options.color_tolerance_percent = min2(options.color_tolerance_percent * root, 100);
    options.bake_textures = 1;
    options.is_written_in_parts = 1;
    options.has_coarse_wires = steps > 0;
    options.unverified = 0;
    options.owned = NULL;
    if (options.progress) {
        options.progress = show_progress;
        options.user = w;
    }
    return options;
}

/* Copies the corners of the triangles of a level's fallback mesh. Returns 0 when out of memory. */
static int copy_corners(level_work *level) {
    const psplat_fallback_mesh *f = &level->fallback;
    level->corners = malloc((f->index_count + 1) * 3 * sizeof *level->corners);
    for (size_t i = 0; level->corners && i < f->index_count; ++i)
        memcpy(level->corners + 3 * i, f->vertices[f->indices[i]].position,
               3 * sizeof *level->corners);
    return level->corners != NULL;
}

/* Returns how near to its cell a tile has all splats: a point of the source is covered by splats
 * that are so far away from the mesh, which is up to its deviation away itself. */
static double margin_of(const block_work *w, const level_work *level) {
    return psplat_verified_cover(level->tolerance) + w->desc->deviation;
}

/* Stores the box, around the cell, in which splats cover the surface. It is before the conversion
 * that it has to be known, whose tolerance is at most this. */
static void find_owned(const block_work *w, level_work *level, double percent, double owned[6]) {
    double own = psplat_mesh_diagonal(w->desc->mesh);
    level->tolerance = min2(percent * w->diagonal, coarsest_percent * own) / 100;
    for (int k = 0; k < 3; ++k) {
        owned[k] = w->cell.low[k] - margin_of(w, level);
        owned[k + 3] = w->cell.high[k] + margin_of(w, level);
    }
}

/* Converts the block with these options. */
static psplat_result convert_level(const block_work *w, const psplat_convert_desc *options,
                                   level_work *level, psplat_error *error) {
    double owned[6];
    psplat_convert_desc desc = *options;
    find_owned(w, level, options->tolerance_percent, owned);
    if (w->cell.depth) desc.owned = owned;
    psplat_result result = psplat_convert_observed(w->desc->mesh, &desc, &level->splats,
                                                   &level->report, &level->observations, error);
    if (result) return result;
    level->tolerance = level->report.tolerance_percent / 100 * level->report.diagonal;
    level->regions = psplat_splat_regions(&level->splats);
    int ok = level->regions != NULL;
    desc.progress = NULL;
    if (ok && w->desc->has_fallback) {
        result = psplat_fallback_mesh_make(w->desc->mesh, &desc, &level->fallback, error);
        if (result) return result;
        ok = copy_corners(level);
    }
    return ok ? PSPLAT_OK : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a level");
}

/* Returns whether a coarser level than the last one is wanted and possible. */
static int wants_coarser(const block_work *w, double mesh_diagonal) {
    const level_work *last = w->levels[w->level_count - 1];
    return w->level_count < MOST_LEVELS && last->splats.count > w->most &&
           2 * last->tolerance <= coarsest_percent / 100 * mesh_diagonal &&
           (w->desc->finest < 0 || w->level_count <= (size_t)w->desc->finest);
}

/* Returns whether a coarser level than the last one has next to nothing less, or nothing at all. */
static int is_in_vain(const block_work *w, const level_work *level, psplat_result result) {
    double before = (double)w->levels[w->level_count - 1]->splats.count;
    if (result) return result == PSPLAT_ERROR_NO_SPLATS;
    return (double)level->splats.count > worthwhile_part * before;
}

/* Converts all levels, finest first. */
static psplat_result convert_levels(block_work *w, psplat_error *error) {
    double mesh_diagonal = psplat_mesh_diagonal(w->desc->mesh);
    psplat_result result = PSPLAT_OK;
    do {
        const psplat_convert_desc options = options_of(w, w->level_count);
        level_work *level = calloc(1, sizeof *level);
        if (!level) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a level");
        w->now = finest_share * (1 - w->before);
        result = convert_level(w, &options, level, error);
        w->before += w->now;
        if (w->level_count && is_in_vain(w, level, result)) {
            level_free(level);
            return PSPLAT_OK;
        }
        w->levels[w->level_count++] = level;
    } while (!result && wants_coarser(w, mesh_diagonal));
    return result;
}

/* ---- tiles ----------------------------------------------------------------------------------- */

/* The tiles of one level. */
typedef struct tiled_level {
    psplat_tile_source source;
    psplat_tile_part *parts;
    psplat_tile *tiles; /* count, not owned */
    size_t count;
} tiled_level;

/* The contents of a batch of tiles. */
typedef struct batch {
    uint8_t *data[BATCH];
    size_t sizes[BATCH];
    psplat_error errors[BATCH];
} batch;

/* Makes the contents of tiles from index first on, at the same time. */
static void pack_batch(const tiled_level *t, size_t first, size_t count, batch *b) {
    long end = (long)count;
#if defined(_OPENMP)
#pragma omp parallel for schedule(dynamic, 1)
#endif
    for (long i = 0; i < end; ++i) {
        psplat_error *error = &b->errors[i];
        error->code = psplat_tile_pack(&t->source, &t->parts[first + (size_t)i], &b->data[i],
                                       &b->sizes[i], error);
    }
}

/* Hands on the contents of a batch in order. */
static psplat_result hand_on(const block_work *w, tiled_level *t, size_t first, size_t count,
                             batch *b, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < count; ++i) {
        psplat_tile *tile = &t->tiles[first + i];
        if (!result && b->errors[i].code)
            result = psplat_fail(error, b->errors[i].code, 0, "%s", b->errors[i].text);
        tile->bytes = b->sizes[i];
        if (!result && w->desc->write)
            result = w->desc->write(w->desc->user, tile, b->data[i], b->sizes[i], error);
        free(b->data[i]);
    }
    return result;
}

static psplat_result write_tiles(const block_work *w, tiled_level *t, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t first = 0; first < t->count && !result; first += BATCH) {
        size_t count = t->count - first < BATCH ? t->count - first : BATCH;
        batch *b = calloc(1, sizeof *b);
        if (!b) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for tiles");
        pack_batch(t, first, count, b);
        result = hand_on(w, t, first, count, b, error);
        free(b);
    }
    return result;
}

/* Appends room for the tiles of a level. Returns 0 when out of memory. */
static int reserve(psplat_tile_block *block, tiled_level *t) {
    psplat_tile *tiles = realloc(block->tiles, (block->tile_count + t->count + 1) * sizeof *tiles);
    if (!tiles) return 0;
    block->tiles = tiles;
    t->tiles = tiles + block->tile_count;
    block->tile_count += t->count;
    return 1;
}

static void describe_level(const level_work *level, const tiled_level *t, psplat_tile_level *to) {
    *to = (psplat_tile_level){.level = t->source.level,
                              .tiles = t->count,
                              .splats = level->splats.count,
                              .report = level->report};
    for (size_t i = 0; i < t->count; ++i) {
        to->tile_splats += t->tiles[i].splats;
        to->bytes += t->tiles[i].bytes;
        to->error = max2(to->error, t->tiles[i].error);
    }
}

/* Cuts a level into parts. */
static psplat_result cut_level(const block_work *w, const level_work *level, int is_coarsest,
                               tiled_level *t, psplat_error *error) {
    const psplat_cut_desc desc = {.regions = level->regions,
                                  .region_count = level->splats.count,
                                  .margin = margin_of(w, level),
                                  .most = is_coarsest ? 0 : w->most,
                                  .triangles = level->corners,
                                  .triangle_count = level->fallback.index_count / 3,
                                  .may_halve = w->desc->may_halve,
                                  .user = w->desc->user};
    if (!psplat_cell_tree_cut(w->tree, &desc, &t->parts, &t->count)) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the cells of tiles");
}

/* Returns what each point of the surface is covered within, but for those that are open. */
static double covered_within(const level_work *level) {
    double tolerance = level->tolerance * (1 + 1e-6); /* as measure/measured_splats.c has it */
    return level->report.unproven_surface_percent > 0 ? psplat_verified_cover(level->tolerance)
                                                      : tolerance;
}

/* Makes the tiles of a level. */
static psplat_result tile_level(const block_work *w, const level_work *level, int number,
                                int is_coarsest, psplat_tile_block *block, psplat_error *error) {
    tiled_level t = {.source = {.splats = &level->splats,
                                .regions = level->regions,
                                .observations = &level->observations,
                                .fallback = w->desc->has_fallback ? &level->fallback : NULL,
                                .codec = w->desc->codec,
                                .tolerance = covered_within(level),
                                .deviation = w->desc->deviation,
                                .margin = margin_of(w, level),
                                .open_reach = psplat_verified_open_reach(level->tolerance),
                                .level = number}};
    psplat_result result = cut_level(w, level, is_coarsest, &t, error);
    if (!result && !reserve(block, &t))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for tiles");
    for (size_t i = 0; i < t.count && !result; ++i)
        psplat_tile_describe(&t.source, &t.parts[i], &t.tiles[i]);
    if (!result && psplat_tile_add_observations(&t.source, w->tree, t.parts, t.tiles, t.count))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for tiles");
    if (!result) result = write_tiles(w, &t, error);
    if (!result) describe_level(level, &t, &block->levels[block->level_count++]);
    psplat_tile_parts_free(t.parts, t.count);
    return result;
}

static psplat_result tile_levels(block_work *w, psplat_tile_block *block, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    int finest = w->desc->finest >= 0 ? w->desc->finest : (int)w->level_count - 1;
    w->tree = psplat_cell_tree_create(w->desc->mesh, &w->cell);
    block->levels = calloc(w->level_count + 1, sizeof *block->levels);
    if (!w->tree || !block->levels)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the cells of tiles");
    for (size_t i = w->level_count; i-- > 0 && !result;)
        result =
            tile_level(w, w->levels[i], finest - (int)i, i == w->level_count - 1, block, error);
    return result;
}

psplat_result psplat_tile_block_make(const psplat_tile_block_desc *desc, psplat_tile_block *block,
                                     psplat_error *error) {
    block_work w = {.desc = desc, .most = desc->most ? desc->most : PSPLAT_MOST_TILE_SPLATS};
    *block = (psplat_tile_block){0};
    if (!psplat_tile_cell_find(desc->root, desc->path ? desc->path : "", &w.cell))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "'%.80s' is no path of a cell",
                           desc->path);
    w.diagonal =
        desc->convert->diagonal > 0 ? desc->convert->diagonal : psplat_mesh_diagonal(desc->mesh);
    psplat_result result = convert_levels(&w, error);
    if (!result) result = tile_levels(&w, block, error);
    for (size_t i = 0; i < w.level_count; ++i) level_free(w.levels[i]);
    psplat_cell_tree_destroy(w.tree);
    if (result) psplat_tile_block_free(block);
    return result;
}

void psplat_tile_block_free(psplat_tile_block *block) {
    free(block->tiles);
    free(block->levels);
    *block = (psplat_tile_block){0};
}
