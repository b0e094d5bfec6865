/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tileset.c - a tree of tiles as JSON of 3D Tiles 1.1.
 *
 * Coordinates of 3D Tiles have Z up where those of glTF have Y up: (x, y, z) becomes (x, -z, y).
 * Contents stay glTF; their readers turn them.
 */
#include "tiles/tileset.h"

#include "base/json_writer.h"
#include "base/vector.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the tree -------------------------------------------------------------------------------- */

static int compare_keys(int level, const char *path, const psplat_tile *tile) {
    if (level != tile->level) return level < tile->level ? -1 : 1;
    return strcmp(path, tile->path);
}

static int compare_tiles(const void *left, const void *right) {
    const psplat_tile *a = left, *b = right;
    return compare_keys(a->level, a->path, b);
}

/* Returns the index of the tile of a level and path among sorted ones; SIZE_MAX: there is none. */
static size_t find_tile(const psplat_tile *tiles, size_t count, int level, const char *path) {
    size_t begin = 0, end = count;
    while (begin < end) {
        size_t middle = begin + (end - begin) / 2;
        int order = compare_keys(level, path, &tiles[middle]);
        if (!order) return middle;
        if (order < 0)
            end = middle;
        else
            begin = middle + 1;
    }
    return SIZE_MAX;
}

/* Returns the index of the parent of a tile among sorted ones; SIZE_MAX: it has none. */
static size_t find_parent(const psplat_tile *tiles, size_t count, const psplat_tile *tile) {
    for (int level = tile->level - 1; level >= tiles[0].level; --level) {
        char path[PSPLAT_CELL_PATH];
        memcpy(path, tile->path, sizeof path);
        for (size_t length = strlen(path) + 1; length-- > 0;) {
            path[length] = 0;
            size_t found = find_tile(tiles, count, level, path);
            if (found != SIZE_MAX) return found;
        }
    }
    return SIZE_MAX;
}

psplat_result psplat_tileset_arrange(psplat_tile *tiles, size_t count, size_t *parents,
                                     psplat_error *error) {
    if (!count) return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "a tileset without tiles");
    qsort(tiles, count, sizeof *tiles, compare_tiles);
    for (size_t i = 0; i < count; ++i) {
        if (i && !compare_tiles(&tiles[i - 1], &tiles[i]))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "two tiles of level %d and cell '%s'", tiles[i].level,
                               tiles[i].path);
        parents[i] = find_parent(tiles, count, &tiles[i]);
        if (i && parents[i] == SIZE_MAX)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "no tile holds that of level %d and cell '%s'", tiles[i].level,
                               tiles[i].path);
    }
    for (size_t i = count; i-- > 1;)
        tiles[parents[i]].error = max2(tiles[parents[i]].error, tiles[i].error);
    return PSPLAT_OK;
}

/* ---- files ----------------------------------------------------------------------------------- */

/* The state of the writing. */
typedef struct tileset {
    const psplat_tile *tiles;
    const size_t *parents;
    size_t count;
    size_t *first; /* count + 1: where the children of each begin in children */
    size_t *children;
    size_t *files;      /* 0: the tile is in its parent's file; else its own file's number */
    double (*boxes)[6]; /* of all that a tile and its descendants show */
} tileset;

static void tileset_free(tileset *t) {
    free(t->first);
    free(t->children);
    free(t->files);
    free(t->boxes);
}

/* Lists the children of each tile. */
static void list_children(tileset *t) {
    for (size_t i = 1; i < t->count; ++i) ++t->first[t->parents[i] + 1];
    for (size_t i = 0; i < t->count; ++i) t->first[i + 1] += t->first[i];
    for (size_t i = t->count; i-- > 1;) t->children[--t->first[t->parents[i] + 1]] = i;
    /* The beginnings of the lists have moved to the tiles behind. */
    memmove(t->first, t->first + 1, t->count * sizeof *t->first);
    t->first[t->count] = t->count - 1;
}

static void unite_boxes(tileset *t) {
    for (size_t i = 0; i < t->count; ++i)
        memcpy(t->boxes[i], t->tiles[i].bounds, sizeof t->boxes[i]);
    for (size_t i = t->count; i-- > 1;)
        for (int k = 0; k < 3; ++k) {
            double *box = t->boxes[t->parents[i]];
            box[k] = min2(box[k], t->boxes[i][k]);
            box[k + 3] = max2(box[k + 3], t->boxes[i][k + 3]);
        }
}

/* Decides which tiles begin a file: where more than `most` tiles would stand below one, the largest
 * trees of its children get files of their own. Returns 0 when out of memory. */
static int divide(tileset *t, size_t most) {
    size_t *sizes = malloc(t->count * sizeof *sizes), files = 0;
    if (!sizes) return 0;
    for (size_t i = t->count; i-- > 0;) {
        sizes[i] = 1;
        for (size_t k = t->first[i]; k < t->first[i + 1]; ++k) sizes[i] += sizes[t->children[k]];
        while (sizes[i] > most) {
            size_t largest = SIZE_MAX;
            for (size_t k = t->first[i]; k < t->first[i + 1]; ++k)
                if (largest == SIZE_MAX || sizes[t->children[k]] > sizes[largest])
                    largest = t->children[k];
            if (largest == SIZE_MAX || sizes[largest] < 2) break;
            sizes[i] -= sizes[largest] - 1;
            sizes[largest] = 1;
            t->files[largest] = 1;
        }
    }
    for (size_t i = 0; i < t->count; ++i)
        if (t->files[i]) t->files[i] = ++files;
    free(sizes);
    return 1;
}

static int tileset_begin(tileset *t, size_t most) {
    t->first = calloc(t->count + 2, sizeof *t->first);
    t->children = malloc(t->count * sizeof *t->children);
    t->files = calloc(t->count, sizeof *t->files);
    t->boxes = malloc(t->count * sizeof *t->boxes);
    if (!t->first || !t->children || !t->files || !t->boxes) return 0;
    list_children(t);
    unite_boxes(t);
    return divide(t, most ? most : PSPLAT_MOST_TILES_OF_FILE);
}

static void name_file(size_t number, char name[40]) {
    if (number)
        snprintf(name, 40, "tileset-%zu.json", number);
    else
        snprintf(name, 40, "tileset.json");
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* Returns a number times -1, without a negative 0. */
static double negated(double x) {
    return 0 - x;
}

static void write_volume(psplat_writer *json, const double box[6]) {
    double middle[3], half[3];
    for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * box[k] + 0.5 * box[k + 3];
        half[k] = 0.5 * box[k + 3] - 0.5 * box[k];
    }
    const double values[12] = {
        middle[0], negated(middle[2]), middle[1], half[0], 0, 0, 0, half[2], 0, 0, 0, half[1]};
    psplat_writer_open(json, "boundingVolume", '{');
    psplat_writer_numbers(json, "box", values, 12);
    psplat_writer_close(json, '}');
}

static void write_content(psplat_writer *json, const char *uri) {
    psplat_writer_open(json, "content", '{');
    psplat_writer_string(json, "uri", uri);
    psplat_writer_close(json, '}');
}

static void write_extras(psplat_writer *json, const psplat_tile *tile) {
    const double *r = tile->region, *c = tile->cone;
    const double region[6] = {r[0], negated(r[5]), r[1], r[3], negated(r[2]), r[4]};
    const double cone[4] = {c[0], negated(c[2]), c[1], c[3]};
    psplat_writer_open(json, "extras", '{');
    psplat_writer_open(json, "phongsplat", '{');
    psplat_writer_numbers(json, "region", region, 6);
    psplat_writer_count(json, "level", (size_t)tile->level);
    psplat_writer_count(json, "splats", tile->splats);
    psplat_writer_count(json, "bytes", tile->bytes);
    psplat_writer_number(json, "normalError", tile->normal_error);
    if (tile->cone[3] > 0) psplat_writer_numbers(json, "cone", cone, 4);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

/* Writes a tile with all below it that is in the same file; is_root: it begins the file. */
static void write_tile(psplat_writer *json, const tileset *t, size_t i, const char *key,
                       int is_root) {
    char name[40];
    psplat_writer_open(json, key, '{');
    write_volume(json, t->boxes[i]);
    psplat_writer_number(json, "geometricError", t->tiles[i].error);
    if (is_root) psplat_writer_string(json, "refine", "REPLACE");
    if (!is_root && t->files[i]) {
        name_file(t->files[i], name);
        write_content(json, name);
        psplat_writer_close(json, '}');
        return;
    }
    write_content(json, t->tiles[i].content);
    write_extras(json, &t->tiles[i]);
    if (t->first[i + 1] > t->first[i]) {
        psplat_writer_open(json, "children", '[');
        for (size_t k = t->first[i]; k < t->first[i + 1]; ++k)
            write_tile(json, t, t->children[k], NULL, 0);
        psplat_writer_close(json, ']');
    }
    psplat_writer_close(json, '}');
}

/* Returns the error of showing nothing where the first tile's file would be: that of the whole. */
static double error_of_nothing(const psplat_tile *root) {
    double d[3];
    sub3(d, root->region + 3, root->region);
    return max2(length3(d), root->error);
}

static psplat_result write_file(const tileset *t, size_t root, psplat_take_tileset *take,
                                void *user, psplat_error *error) {
    psplat_writer json = {.compact = 1};
    char name[40];
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_open(&json, "asset", '{');
    psplat_writer_string(&json, "version", "1.1");
    psplat_writer_close(&json, '}');
    psplat_writer_number(&json, "geometricError",
                         root ? t->tiles[root].error : error_of_nothing(&t->tiles[0]));
    write_tile(&json, t, root, "root", 1);
    psplat_writer_close(&json, '}');
    if (!psplat_writer_finish(&json))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a tileset");
    name_file(t->files[root], name);
    psplat_result result = take(user, name, json.text, json.size, error);
    free(json.text);
    return result;
}

psplat_result psplat_tileset_write(const psplat_tile *tiles, size_t count, const size_t *parents,
                                   size_t most, psplat_take_tileset *take, void *user,
                                   psplat_error *error) {
    tileset t = {.tiles = tiles, .parents = parents, .count = count};
    psplat_result result = PSPLAT_OK;
    if (!tileset_begin(&t, most))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu tiles", count);
    for (size_t i = 0; i < count && !result; ++i)
        if (!i || t.files[i]) result = write_file(&t, i, take, user, error);
    tileset_free(&t);
    return result;
}
