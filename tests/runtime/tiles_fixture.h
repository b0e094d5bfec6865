/* SPDX-License-Identifier: MIT
 *
 * tiles_fixture.h - tilesets made in memory, a host that reads them, and models without GL. Include
 * this file after cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_TILES_FIXTURE_H
#define PHONGSPLAT_TEST_TILES_FIXTURE_H

#include "ledger.h"
#include "near.h"
#include "scene_asset.h"
#include "tileset/slots.h"

#include <phongsplat/tiles.h>

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- texts ----------------------------------------------------------------------------------- */

typedef struct world_text {
    char *data;
    size_t size, capacity;
} world_text;

static inline void text_put(world_text *text, const char *format, ...) {
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    assert_true(length >= 0 && (size_t)length < sizeof line);
    if (text->size + (size_t)length >= text->capacity) {
        text->capacity = 2 * text->capacity + sizeof line;
        text->data = realloc(text->data, text->capacity);
        assert_non_null(text->data);
    }
    memcpy(text->data + text->size, line, (size_t)length + 1);
    text->size += (size_t)length;
}

/* ---- a world: files in memory ------------------------------------------------------------------
 */

enum { WORLD_FILES = 256, WORLD_GLBS = 4, WORLD_PATH = 96 };

typedef struct world {
    char paths[WORLD_FILES][WORLD_PATH]; /* of tilesets */
    world_text texts[WORLD_FILES];
    int file_count;
    uint8_t *glbs[WORLD_GLBS]; /* that all contents are, chosen by their paths */
    size_t glb_sizes[WORLD_GLBS];
    uint32_t random;
    /* How make_tree shapes the tree. */
    int depth;          /* of the deepest tiles */
    int external_depth; /* tiles of this depth are external tilesets; 0: none are */
    float missing;      /* probability that a child does not exist */
    float early;        /* probability that a tile has no children */
    int has_extras;     /* 1: tiles tell their splats */
} world;

static inline uint32_t path_hash(const char *path) {
    uint32_t hash = 2166136261u;
    for (; *path; ++path) hash = (hash ^ (uint8_t)*path) * 16777619u;
    return hash ^ hash >> 15;
}

static inline void world_make_glbs(world *w) {
    static const size_t counts[WORLD_GLBS] = {1, 3, 7, 20};
    for (int i = 0; i < WORLD_GLBS; ++i) {
        scene s = scene_blank(counts[i]);
        w->glbs[i] = scene_glb(&s, &w->glb_sizes[i]);
        scene_free(&s);
    }
}

static inline world_text *world_add_file(world *w, const char *path) {
    assert_true(w->file_count < WORLD_FILES);
    snprintf(w->paths[w->file_count], WORLD_PATH, "%s", path);
    return &w->texts[w->file_count++];
}

static inline void world_free(world *w) {
    for (int i = 0; i < w->file_count; ++i) free(w->texts[i].data);
    for (int i = 0; i < WORLD_GLBS; ++i) free(w->glbs[i]);
    memset(w, 0, sizeof *w);
}

/* ---- trees --------------------------------------------------------------------------------- */

typedef struct world_cell {
    double min[3], max[3]; /* y up */
    int depth;
    char path[64];
} world_cell;

/* Half of the cell at the middle of its longest side. */
static inline world_cell cell_half(const world_cell *cell, int which) {
    world_cell half = *cell;
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (cell->max[i] - cell->min[i] > cell->max[axis] - cell->min[axis]) axis = i;
    *(which ? &half.min[axis] : &half.max[axis]) = 0.5 * (cell->min[axis] + cell->max[axis]);
    half.depth = cell->depth + 1;
    size_t length = strlen(half.path);
    half.path[length] = (char)('0' + which);
    half.path[length + 1] = 0;
    return half;
}

static inline void put_tile_start(world_text *text, const world_cell *cell) {
    double c[3], h[3];
    for (int i = 0; i < 3; ++i) {
        c[i] = 0.5 * (cell->min[i] + cell->max[i]);
        h[i] = 0.5 * (cell->max[i] - cell->min[i]);
    }
    text_put(text,
             "{\"boundingVolume\":{\"box\":[%.17g,%.17g,%.17g,%.17g,0,0,0,%.17g,0,0,0,%.17g]},"
             "\"geometricError\":%.17g%s",
             c[0], -c[2], c[1], h[0], h[2], h[1], 0.4 / pow(2, cell->depth / 2.0),
             cell->depth ? "" : ",\"refine\":\"REPLACE\"");
}

static inline void make_tile(world *w, world_text *text, const char *up, const world_cell *cell);

static inline void make_children(world *w, world_text *text, const char *up,
                                 const world_cell *cell) {
    int first = scene_random(&w->random) < w->missing, count = 0;
    int last = !first && scene_random(&w->random) < w->missing ? 0 : 1;
    if (cell->depth >= w->depth || (cell->depth && scene_random(&w->random) < w->early)) return;
    text_put(text, ",\"children\":[");
    for (int i = first; i <= last; ++i) {
        world_cell half = cell_half(cell, i);
        if (count++) text_put(text, ",");
        make_tile(w, text, up, &half);
    }
    text_put(text, "]");
}

/* Writes a tile with what is below it. up leads from the file to the directory of the tileset. */
static inline void make_content_tile(world *w, world_text *text, const char *up,
                                     const world_cell *cell) {
    put_tile_start(text, cell);
    text_put(text, ",\"content\":{\"uri\":\"%st/n%s.glb\"}", up, cell->path);
    if (w->has_extras) {
        static const int counts[WORLD_GLBS] = {1, 3, 7, 20};
        char path[WORLD_PATH];
        snprintf(path, sizeof path, "t/n%s.glb", cell->path);
        text_put(text, ",\"extras\":{\"phongsplat\":{\"splats\":%d}}",
                 counts[path_hash(path) % WORLD_GLBS]);
    }
    make_children(w, text, up, cell);
    text_put(text, "}");
}

static inline void make_file(world *w, const char *path, const char *up, const world_cell *cell) {
    world_text *text = world_add_file(w, path);
    text_put(text, "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\":");
    world_cell root = *cell;
    if (cell->depth) { /* the root of a file needs a refine of its own */
        world_text inner = {0};
        make_content_tile(w, &inner, up, &root);
        text_put(text, "{\"refine\":\"REPLACE\",");
        for (size_t i = 1; i < inner.size; i += 512) text_put(text, "%.512s", inner.data + i);
        free(inner.data);
    } else {
        make_content_tile(w, text, up, &root);
    }
    text_put(text, "}");
}

static inline void make_tile(world *w, world_text *text, const char *up, const world_cell *cell) {
    if (!w->external_depth || cell->depth != w->external_depth) {
        make_content_tile(w, text, up, cell);
        return;
    }
    char path[WORLD_PATH];
    snprintf(path, sizeof path, "ext/x%s.json", cell->path);
    put_tile_start(text, cell);
    text_put(text, ",\"content\":{\"uri\":\"%s%s\"}}", up, path);
    make_file(w, path, "../", cell);
}

/* Makes a tree over the box (-4 -1 -2) ... (4 1 2). */
static inline void world_make_tree(world *w) {
    const world_cell root = {.min = {-4, -1, -2}, .max = {4, 1, 2}};
    if (!w->random) w->random = 2463534242u;
    if (!w->glbs[0]) world_make_glbs(w);
    make_file(w, "tileset.json", "", &root);
}

/* ---- the host ------------------------------------------------------------------------------ */

static inline const world_text *world_find(const world *w, const char *path) {
    for (int i = 0; i < w->file_count; ++i)
        if (!strcmp(w->paths[i], path)) return &w->texts[i];
    return NULL;
}

static inline psplat_result world_read(void *user, const char *path, uint64_t offset, void *data,
                                       size_t size, size_t *got, psplat_error *error) {
    const world_text *text = world_find(user, strncmp(path, "dir/", 4) ? path : path + 4);
    (void)error;
    if (!text) return PSPLAT_ERROR_READ;
    size_t rest = offset < text->size ? text->size - (size_t)offset : 0;
    *got = size < rest ? size : rest;
    if (*got) memcpy(data, text->data + offset, *got);
    return PSPLAT_OK;
}

static inline psplat_result world_supply(const world *w, psplat_tiles *tiles, uint64_t tile,
                                         const char *path, psplat_error *error) {
    const world_text *text = world_find(w, path);
    if (text) return psplat_tiles_supply(tiles, tile, text->data, text->size, error);
    uint32_t which = path_hash(path) % WORLD_GLBS;
    return psplat_tiles_supply(tiles, tile, w->glbs[which], w->glb_sizes[which], error);
}

/* ---- models without GL ----------------------------------------------------------------------- */

typedef struct mock_model {
    psplat_model_info info;
} mock_model;

static inline psplat_result mock_create(psplat_renderer *renderer, const psplat_asset *asset,
                                        psplat_model **model, psplat_error *error) {
    (void)renderer;
    (void)error;
    mock_model *made = calloc(1, sizeof *made);
    assert_non_null(made);
    made->info.batch_count = psplat_asset_batch_count(asset);
    for (size_t i = 0; i < made->info.batch_count; ++i)
        made->info.splat_count += psplat_asset_batch(asset, i)->splat_count;
    made->info.bytes = psplat_tile_model_bytes(asset);
    *model = (psplat_model *)made;
    return PSPLAT_OK;
}

static inline void mock_destroy(psplat_renderer *renderer, psplat_model *model) {
    (void)renderer;
    free(model);
}

static inline psplat_model_info mock_describe(const psplat_model *model) {
    return ((const mock_model *)model)->info;
}

static const psplat_tile_models mock_models = {mock_create, mock_destroy, mock_describe};

static inline psplat_tiles *world_open(world *w, psplat_tiles_desc desc) {
    psplat_error error = {0};
    psplat_tiles *tiles = NULL;
    desc.source = (psplat_tiles_source){.read = world_read, .user = w};
    psplat_result result = psplat_tiles_open(&desc, "dir/tileset.json", &tiles, &error);
    if (result) print_error("%s at byte %zu\n", error.text, error.offset);
    assert_int_equal(result, PSPLAT_OK);
    tiles->models = &mock_models;
    return tiles;
}

/* Selects, reads all that is wanted at once, and uploads, until nothing is wanted any more. Returns
 * the number of requests. */
static inline size_t world_settle(const world *w, psplat_tiles *tiles,
                                  const psplat_tiles_view *view) {
    psplat_tile_request requests[16];
    size_t total = 0;
    for (int round = 0; round < 2000; ++round) {
        assert_int_equal(psplat_tiles_select(tiles, view, NULL), PSPLAT_OK);
        size_t count = psplat_tiles_wanted(tiles, requests, 16);
        for (size_t i = 0; i < count; ++i)
            world_supply(w, tiles, requests[i].tile, requests[i].path, NULL);
        assert_int_equal(psplat_tiles_upload(tiles, NULL, SIZE_MAX, NULL), PSPLAT_OK);
        psplat_tiles_state state = psplat_tiles_describe(tiles);
        total += count;
        if (!count && !state.wanted && !state.waiting) return total;
    }
    fail_msg("the tileset does not settle");
    return total;
}

/* ---- views ----------------------------------------------------------------------------------- */

static inline void cross3(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static inline void unit3(double v[3]) {
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; ++i) v[i] /= length;
}

static inline void view_look_at(psplat_view *view, const double eye[3], const double at[3]) {
    double z[3], x[3], y[3], up[3] = {0.0123, 1, 0.0321};
    for (int i = 0; i < 3; ++i) z[i] = eye[i] - at[i];
    unit3(z);
    cross3(up, z, x);
    unit3(x);
    cross3(z, x, y);
    for (int i = 0; i < 3; ++i) {
        view->view[4 * i] = x[i];
        view->view[4 * i + 1] = y[i];
        view->view[4 * i + 2] = z[i];
        view->view[12 + i] = 0;
        view->view[4 * i + 3] = 0;
    }
    for (int i = 0; i < 3; ++i) {
        view->view[12] -= x[i] * eye[i];
        view->view[13] -= y[i] * eye[i];
        view->view[14] -= z[i] * eye[i];
    }
    view->view[15] = 1;
}

static inline void view_perspective(psplat_view *view, double tangent, double near, double far) {
    memset(view->projection, 0, sizeof view->projection);
    double aspect = (double)view->width / view->height;
    view->projection[0] = 1 / (tangent * aspect);
    view->projection[5] = 1 / tangent;
    view->projection[10] = -(far + near) / (far - near);
    view->projection[11] = -1;
    view->projection[14] = -2 * far * near / (far - near);
}

static inline void view_orthographic(psplat_view *view, double half, double near, double far) {
    memset(view->projection, 0, sizeof view->projection);
    double aspect = (double)view->width / view->height;
    view->projection[0] = 1 / (half * aspect);
    view->projection[5] = 1 / half;
    view->projection[10] = -2 / (far - near);
    view->projection[14] = -(far + near) / (far - near);
    view->projection[15] = 1;
}

/* A random view of the box that make_tree fills: from near and far, from inside, sometimes
 * orthographic. */
static inline psplat_view view_random(uint32_t *random) {
    psplat_view view = {.width = 300 + (int)(500 * scene_random(random)),
                        .height = 200 + (int)(500 * scene_random(random))};
    double eye[3], at[3], distance = pow(10, 2.5 * (double)scene_random(random) - 1);
    for (int i = 0; i < 3; ++i) {
        at[i] = (i == 0 ? 4 : i == 1 ? 1 : 2) * (2 * (double)scene_random(random) - 1);
        eye[i] = 2 * (double)scene_random(random) - 1;
    }
    unit3(eye);
    for (int i = 0; i < 3; ++i) eye[i] = at[i] + distance * eye[i];
    view_look_at(&view, eye, at);
    if (scene_random(random) < 0.25f)
        view_orthographic(&view, 0.5 * distance, 0.01, 3 * distance);
    else
        view_perspective(&view, 0.2 + (double)scene_random(random), 0.01, 1000);
    return view;
}

#endif
