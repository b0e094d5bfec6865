/* SPDX-License-Identifier: MIT
 *
 * fuzz_tileset.c - reads any bytes as a tileset.json, or as an archive where they begin with PK,
 * draws some frames of it without GL, and supplies what is wanted: of an archive the bytes that are
 * asked for; else external tilesets are the input itself, contents a splat, the input, or nothing,
 * as their names say. A hash of the bytes chooses budgets and views, and which inputs run
 * out of memory.
 */
#include "fuzz.h"

#include "tileset/slots.h"

#include <math.h>
#include <string.h>

typedef struct input {
    const uint8_t *data;
    size_t size;
} input;

static psplat_result read_input(void *user, const char *path, uint64_t offset, void *data,
                                size_t size, size_t *got, psplat_error *error) {
    const input *in = user;
    size_t rest = offset < in->size ? in->size - (size_t)offset : 0;
    (void)error;
    FUZZ_DEMAND(!strcmp(path, "dir/tileset.json") || !strcmp(path, "dir/scene.3tz"));
    *got = size < rest ? size : rest;
    if (*got) memcpy(data, in->data + offset, *got);
    return PSPLAT_OK;
}

static psplat_result size_input(void *user, const char *path, uint64_t *size, psplat_error *error) {
    (void)path;
    (void)error;
    *size = ((const input *)user)->size;
    return PSPLAT_OK;
}

/* ---- models without GL ----------------------------------------------------------------------- */

static psplat_result make_model(psplat_renderer *renderer, const psplat_asset *asset,
                                psplat_model **model, psplat_error *error) {
    psplat_model_info *info = calloc(1, sizeof *info);
    (void)renderer;
    (void)error;
    FUZZ_DEMAND(info);
    info->batch_count = info->splat_count = psplat_asset_batch_count(asset);
    info->bytes = psplat_tile_model_bytes(asset);
    *model = (psplat_model *)info;
    return PSPLAT_OK;
}

static void destroy_model(psplat_renderer *renderer, psplat_model *model) {
    (void)renderer;
    free(model);
}

static psplat_model_info describe_model(const psplat_model *model) {
    return *(const psplat_model_info *)model;
}

static const psplat_tile_models models = {make_model, destroy_model, describe_model};

/* A file with one splat; its quotation marks are written as \'. */
static const char splat[] =
    "{'asset':{'version':'2.0'},'extensionsUsed':['PSPLAT_surface_splats'],'nodes':[{'mesh':0"
    "}],'meshes':[{'primitives':[{'mode':0,'attributes':{'POSITION':0,'NORMAL':1,'_PSPLAT_sur"
    "face_splats:ROTATION':2,'_PSPLAT_surface_splats:SCALE':3},'extensions':{'PSPLAT_surface_"
    "splats':{'version':1,'clipLines':0,'depthTolerance':0.01,'positionExtent':[0,0,0]}}}]}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':1,'type':'VEC3'},{'bufferView'"
    ":1,'componentType':5126,'count':1,'type':'VEC3'},{'bufferView':2,'componentType':5126,'c"
    "ount':1,'type':'VEC4'},{'bufferView':3,'componentType':5126,'count':1,'type':'VEC2'}],'b"
    "ufferViews':[{'buffer':0,'byteOffset':0,'byteLength':12},{'buffer':0,'byteOffset':12,'by"
    "teLength':12},{'buffer':0,'byteOffset':24,'byteLength':16},{'buffer':0,'byteOffset':40,'"
    "byteLength':8}],'buffers':[{'byteLength':48,'uri':'data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAgD8AAAA/'}]}";

/* ---- promises -------------------------------------------------------------------------------- */

/* Computes FNV-1a, by Fowler, Noll and Vo. */
static uint32_t hash_of(const uint8_t *data, size_t size) {
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ data[i]) * 16777619u;
    return hash ^ hash >> 16;
}

/* Demands that a path is relative and stays in its directory. */
static void check_path(const char *path) {
    FUZZ_DEMAND(path[0] && path[0] != '/' && !strchr(path, '\\'));
    for (const char *part = path; part; part = strchr(part, '/') ? strchr(part, '/') + 1 : NULL) {
        size_t length = strcspn(part, "/");
        FUZZ_DEMAND(length > 0);
        FUZZ_DEMAND(!(length == 1 && part[0] == '.'));
        FUZZ_DEMAND(!(length == 2 && part[0] == '.' && part[1] == '.'));
    }
}

static void supply(psplat_tiles *tiles, const input *in, const psplat_tile_request *request) {
    psplat_error error = {0};
    psplat_result result;
    check_path(request->path);
    if (tiles->archive.name) {
        FUZZ_DEMAND(request->offset <= in->size && request->size <= in->size - request->offset);
        psplat_tiles_supply(tiles, request->tile, in->data + request->offset, (size_t)request->size,
                            NULL);
        return;
    }
    FUZZ_DEMAND(request->priority >= -1);
    uint32_t hash = hash_of((const uint8_t *)request->path, strlen(request->path));
    if (hash % 7 == 0) {
        psplat_tiles_fail(tiles, request->tile, (int)(hash / 7 % 2));
        return;
    }
    if (hash % 5 && !strstr(request->path, ".json")) {
        char text[sizeof splat];
        for (size_t i = 0; i < sizeof splat; ++i) text[i] = splat[i] == '\'' ? '"' : splat[i];
        result = psplat_tiles_supply(tiles, request->tile, text, sizeof splat - 1, &error);
        /* A name such as x.JSON is a tileset's too, which this is not. */
        int is_model = strstr(request->path, ".glb") || strstr(request->path, ".gltf");
        FUZZ_DEMAND(!result || result == PSPLAT_ERROR_MEMORY || !is_model);
    } else {
        result = psplat_tiles_supply(tiles, request->tile, in->data, in->size, &error);
    }
    FUZZ_DEMAND(!result || (error.code == result && error.text[0]));
}

static void check_tree(const psplat_tiles *t) {
    double min[3], max[3];
    psplat_tiles_bounds(t, min, max);
    for (int i = 0; i < 3; ++i) FUZZ_DEMAND(isfinite(min[i]) && min[i] <= max[i]);
    for (uint32_t i = 0; i < t->node_count; ++i) {
        const psplat_tile_node *n = &t->nodes[i];
        FUZZ_DEMAND((n->parent == PSPLAT_TILE_NONE) == (i == 0));
        FUZZ_DEMAND(n->content_count || i == 0);
        FUZZ_DEMAND(n->content_count || n->child_count);
        FUZZ_DEMAND(isfinite(n->error) && n->error >= 0 && n->transform < t->transform_count);
        for (uint32_t k = 0; k < n->child_count; ++k) {
            FUZZ_DEMAND(t->nodes[n->first_child + k].parent == i);
            FUZZ_DEMAND(t->nodes[n->first_child + k].error <= n->error);
        }
        for (uint32_t k = 0; k < n->content_count; ++k)
            FUZZ_DEMAND(t->contents[n->first_content + k].node == i);
    }
}

/* Draws frames from a place that wanders towards the tileset. */
static void draw(psplat_tiles *tiles, const input *in, uint32_t hash) {
    psplat_view view = {.width = 100, .height = 80};
    double tangent = 0.1 + 0.01 * (hash % 100);
    for (int i = 0; i < 4; ++i) view.view[5 * i] = 1;
    view.projection[0] = view.projection[5] = 1 / tangent;
    view.projection[10] = view.projection[11] = -1;
    view.projection[14] = -0.02;
    psplat_tiles_view v = {.view = &view, .max_splats = hash >> 3 & 1 ? 4 : 0};
    for (int frame = 0; frame < 12; ++frame) {
        psplat_tile_request requests[4];
        size_t items = 0;
        view.view[14] = -pow(2, 8 - frame);
        v.seconds = frame;
        v.pixels = frame % 3;
        psplat_result result = psplat_tiles_select(tiles, &v, NULL);
        FUZZ_DEMAND(!result || result == PSPLAT_ERROR_MEMORY);
        size_t count = psplat_tiles_wanted(tiles, requests, 4);
        for (size_t i = 0; i < count; ++i) supply(tiles, in, &requests[i]);
        FUZZ_DEMAND(!psplat_tiles_upload(tiles, NULL, 1000, NULL));
        psplat_tiles_state s = psplat_tiles_describe(tiles);
        FUZZ_DEMAND(s.bytes <= tiles->max_bytes && s.resident <= s.tiles);
        FUZZ_DEMAND(s.missing + s.over_budget + s.leaves <= s.tiles);
        const psplat_item *list = psplat_tiles_items(tiles, &items);
        for (size_t i = 0; i < items; ++i)
            for (int k = 0; k < 16; ++k) FUZZ_DEMAND(isfinite(list[i].transform[k]));
    }
    check_tree(tiles);
}

enum { NO_MEMORY, WAYS = 16, MOST_ALLOCATIONS = 200 };

/* Files that refer to themselves by other names make a tree of up to 12 inputs' depth here, whose
 * breadth the number of requests bounds. */
enum { MOST_FILES = 50 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint32_t hash = hash_of(data, size);
    int fails = hash % WAYS == NO_MEMORY;
    fuzz_meter meter = {.fail_at = fails ? 1 + hash / WAYS % MOST_ALLOCATIONS : 0};
    input in = {data, size};
    const psplat_tiles_desc desc = {.allocator = fuzz_meter_allocator(&meter),
                                    .source = {read_input, &in, size_input},
                                    .max_bytes = hash >> 5 & 1 ? 100000 : 10000000,
                                    .max_requests = 3,
                                    .fade_seconds = hash >> 6 & 1 ? 3 : 0};
    psplat_tiles *tiles = NULL;
    psplat_error error = {0};
    fuzz_meter_start(&meter);
    int is_archive = size > 2 && data[0] == 'P' && data[1] == 'K';
    psplat_result result =
        psplat_tiles_open(&desc, is_archive ? "dir/scene.3tz" : "dir/tileset.json", &tiles, &error);
    fuzz_meter_stop(&meter, 1.0);
    FUZZ_DEMAND((result == PSPLAT_OK) == (tiles != NULL));
    FUZZ_DEMAND(meter.peak <= 200000 + 160 * size);
    if (tiles) {
        tiles->models = &models;
        check_tree(tiles);
        draw(tiles, &in, hash);
        FUZZ_DEMAND(meter.peak <= tiles->max_bytes + MOST_FILES * (200000 + 160 * size));
        fuzz_meter_stop(&meter, 2.0);
    } else {
        FUZZ_DEMAND(error.code == result && error.text[0] && error.offset <= size);
    }
    psplat_tiles_destroy(tiles, NULL);
    FUZZ_DEMAND(meter.bytes == 0);
    return 0;
}
