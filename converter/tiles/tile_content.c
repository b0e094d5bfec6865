/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tile_content.c - the content of a tile.
 *
 * All tiles of a level take their splats from one conversion with one grid, of which each file
 * holds a part, beginning at its own least position. So splats are the same numbers wherever they
 * appear, and what two neighbours both have does not shine.
 */
#include "tiles/tile_content.h"

#include "base/region_distance.h"
#include "base/vector.h"
#include "export/glb_writer.h"
#include "tiles/splat_extent.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The part of a bound by which rounding to single precision may exceed it. */
static const double rounding_slack = 1e-6;

/* ---- what is known of it --------------------------------------------------------------------- */

static void widen_box(double box[6], const double low[3], const double high[3]) {
    for (int k = 0; k < 3; ++k) {
        box[k] = min2(box[k], low[k]);
        box[k + 3] = max2(box[k + 3], high[k]);
    }
}

/* Stores the box of all that a part shows, in the coordinates of the source. */
static void find_bounds(const psplat_tile_source *source, const psplat_tile_part *part,
                        double box[6]) {
    const psplat_fallback_mesh *f = source->fallback;
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) box[k] = HUGE_VAL, box[k + 3] = -HUGE_VAL;
    for (size_t i = 0; i < part->splat_count; ++i)
        if (psplat_splat_extent_box(&source->regions[part->splats[i]], low, high))
            widen_box(box, low, high);
    for (size_t i = 0; i < 3 * part->triangle_count; ++i) {
        size_t corner = 3 * (size_t)part->triangles[i / 3] + i % 3;
        for (int k = 0; k < 3; ++k) low[k] = (double)f->vertices[f->indices[corner]].position[k];
        widen_box(box, low, low);
    }
    if (!(box[0] <= box[3])) /* The lines of all its splats leave nothing. */
        for (int k = 0; k < 3; ++k)
            box[k] = box[k + 3] = source->regions[part->splats[0]].center[k];
    for (int k = 0; k < 6; ++k) box[k] += source->splats->origin[k % 3];
}

/* Returns whether all materials that a part may have show their front alone. */
static int is_one_sided(const psplat_splats *splats) {
    for (size_t i = 0; i < splats->material_count; ++i)
        if (splats->materials[i].double_sided) return 0;
    return 1;
}

void psplat_tile_describe(const psplat_tile_source *source, const psplat_tile_part *part,
                          psplat_tile *tile) {
    double bound = 0;
    *tile = (psplat_tile){.level = source->level, .splats = part->splat_count};
    memcpy(tile->path, part->cell.path, sizeof tile->path);
    memcpy(tile->region, part->cell.low, sizeof part->cell.low);
    memcpy(tile->region + 3, part->cell.high, sizeof part->cell.high);
    find_bounds(source, part, tile->bounds);
    for (size_t i = 0; i < part->splat_count; ++i)
        bound = max2(bound, source->observations->bounds[part->splats[i]]);
    tile->error = max2(bound, source->tolerance) * (1 + rounding_slack) + source->deviation;
    if (is_one_sided(source->splats)) {
        const psplat_normal_cone cone =
            psplat_splat_extent_cone(source->regions, part->splats, part->splat_count);
        memcpy(tile->cone, cone.axis, sizeof cone.axis);
        tile->cone[3] = cone.cosine;
    }
    snprintf(tile->content, sizeof tile->content, "tiles/%d-%s.glb", tile->level,
             *tile->path ? tile->path : "root");
}

/* Returns how far an open point, with the distance of the nearest of all splats, is from those of a
 * part, whose cell is so far from it. */
static double distance_to_part(const psplat_tile_source *source, const psplat_tile_part *part,
                               const double point[3], double width, double aside) {
    double least = HUGE_VAL;
    if (width + aside <= source->margin) return width; /* The part has that splat. */
    for (size_t i = 0; i < part->splat_count; ++i)
        least = min2(least, psplat_region_distance(&source->regions[part->splats[i]], point));
    return least;
}

/* Raises the errors of tiles to the distances of the points that no splat covers, each of which
 * stands for others, which may lie in other cells. */
static void add_open(const psplat_tile_source *source, const psplat_tile_part *parts,
                     psplat_tile *tiles, size_t count) {
    const psplat_observations *o = source->observations;
    for (size_t i = 0; i < o->open_count; ++i) {
        const double *point = o->open + 3 * i;
        double place[3];
        along3(place, source->splats->origin, 1, point);
        for (size_t t = 0; t < count; ++t) {
            double aside = psplat_tile_cell_distance(&parts[t].cell, place);
            if (aside > source->open_reach + source->deviation) continue;
            double error = distance_to_part(source, &parts[t], point, o->widths[i], aside) +
                           source->open_reach + source->deviation;
            tiles[t].error = max2(tiles[t].error, error);
        }
    }
}

psplat_result psplat_tile_add_observations(const psplat_tile_source *source,
                                           const psplat_cell_tree *tree,
                                           const psplat_tile_part *parts, psplat_tile *tiles,
                                           size_t count) {
    const psplat_observations *o = source->observations;
    size_t *samples = calloc(count + 1, sizeof *samples);
    if (!samples) return PSPLAT_ERROR_MEMORY;
    for (size_t i = 0; i < o->sample_count; ++i) {
        size_t at = psplat_cell_tree_part(tree, o->points + 3 * i);
        if (at == SIZE_MAX || o->degrees[i] < 0) continue;
        tiles[at].normal_error += o->degrees[i] * o->degrees[i];
        ++samples[at];
    }
    for (size_t i = 0; i < count; ++i)
        if (samples[i]) tiles[i].normal_error = sqrt(tiles[i].normal_error / (double)samples[i]);
    free(samples);
    add_open(source, parts, tiles, count);
    return PSPLAT_OK;
}

/* ---- its file -------------------------------------------------------------------------------- */

/* Copies the elements of an array that a part has. Returns NULL when out of memory or where there
 * is no array. */
static void *copy_some(const void *from, size_t size, const psplat_tile_part *part) {
    char *copy = from ? malloc((part->splat_count + 1) * size) : NULL;
    for (size_t i = 0; copy && i < part->splat_count; ++i)
        memcpy(copy + i * size, (const char *)from + part->splats[i] * size, size);
    return copy;
}

/* Counts the splats of each run that a part has, and leaves out runs of which it has none. */
static void count_runs(const psplat_splats *all, const psplat_tile_part *part,
                       psplat_splats *some) {
    size_t at = 0, end = 0;
    for (size_t r = 0; r < all->run_count; ++r) {
        psplat_run run = all->runs[r];
        end += run.count;
        run.count = 0;
        for (; at < part->splat_count && part->splats[at] < end; ++at) ++run.count;
        if (run.count) some->runs[some->run_count++] = run;
    }
}

static void free_some(psplat_splats *some) {
    free(some->splats);
    free(some->finishes);
    free(some->texcoords);
    free(some->runs);
}

/* Makes the splats of a part; free_some frees them. The materials are those of all. Returns 0 when
 * out of memory. */
static int take_splats(const psplat_splats *all, const psplat_tile_part *part,
                       psplat_splats *some) {
    *some = *all;
    some->count = part->splat_count;
    some->run_count = 0;
    some->splats = copy_some(all->splats, sizeof *all->splats, part);
    some->finishes = copy_some(all->finishes, sizeof *all->finishes, part);
    some->texcoords = copy_some(all->texcoords, sizeof *all->texcoords, part);
    some->runs = malloc((all->run_count + 1) * sizeof *some->runs);
    if (!some->splats || !some->runs || !some->finishes != !all->finishes ||
        !some->texcoords != !all->texcoords)
        return 0;
    count_runs(all, part, some);
    return 1;
}

/* Adds the triangles of a part that lie in a primitive of all, from index *at on. */
static void take_primitive(const psplat_fallback_mesh *all, const psplat_fallback_primitive *from,
                           const psplat_tile_part *part, size_t *at, uint32_t *places,
                           psplat_fallback_mesh *some) {
    psplat_fallback_primitive primitive = *from;
    primitive.first = some->index_count;
    for (; *at < part->triangle_count; ++*at) {
        size_t first = 3 * (size_t)part->triangles[*at];
        if (first >= from->first + from->count) break;
        for (size_t k = 0; k < 3; ++k) {
            uint32_t vertex = all->indices[first + k];
            if (places[vertex] == UINT32_MAX) {
                places[vertex] = (uint32_t)some->vertex_count;
                some->vertices[some->vertex_count++] = all->vertices[vertex];
            }
            some->indices[some->index_count++] = places[vertex];
        }
    }
    primitive.count = some->index_count - primitive.first;
    if (primitive.count) some->primitives[some->primitive_count++] = primitive;
}

/* Makes the simplified mesh of a part, which psplat_fallback_mesh_free frees. Returns 0 when out of
 * memory. */
static int take_fallback(const psplat_fallback_mesh *all, const psplat_tile_part *part,
                         psplat_fallback_mesh *some) {
    size_t corners = 3 * part->triangle_count, at = 0;
    uint32_t *places = malloc((all->vertex_count + 1) * sizeof *places);
    *some = *all;
    some->vertices = malloc((corners + 1) * sizeof *some->vertices);
    some->indices = malloc((corners + 1) * sizeof *some->indices);
    some->primitives = malloc((all->primitive_count + 1) * sizeof *some->primitives);
    some->vertex_count = some->index_count = some->primitive_count = 0;
    int ok = places && some->vertices && some->indices && some->primitives;
    if (ok) memset(places, 0xff, all->vertex_count * sizeof *places);
    for (size_t i = 0; ok && i < all->primitive_count; ++i)
        take_primitive(all, &all->primitives[i], part, &at, places, some);
    free(places);
    return ok;
}

psplat_result psplat_tile_pack(const psplat_tile_source *source, const psplat_tile_part *part,
                               uint8_t **data, size_t *size, psplat_error *error) {
    psplat_splats some;
    psplat_fallback_mesh fallback = {0};
    const psplat_write_desc written = {.codec = source->codec,
                                       .fallbacks = source->fallback ? &fallback : NULL};
    psplat_result result = PSPLAT_OK;
    *data = NULL;
    if (!take_splats(source->splats, part, &some) ||
        (source->fallback && !take_fallback(source->fallback, part, &fallback)))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a tile");
    if (!result) result = psplat_glb_write(&some, NULL, &written, data, size, error);
    free_some(&some);
    psplat_fallback_mesh_free(&fallback);
    return result;
}
