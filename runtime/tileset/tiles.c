/* SPDX-License-Identifier: MIT
 *
 * tiles.c - opens and destroys tilesets, and tells numbers about them.
 */
#include "tileset/slots.h"

#include "core/memory.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { DEFAULT_REQUESTS = 16, MAX_REQUESTS = 65536 };

static const size_t default_bytes = (size_t)512 << 20;

/* The most bytes of a tileset.json, as of JSON in general. */
static const size_t max_file_size = (size_t)1 << 31;

/* ---- reading the file ----------------------------------------------------------------------- */

static psplat_result read_with_stdio(void *user, const char *path, uint64_t offset, void *data,
                                     size_t size, size_t *got, psplat_error *error) {
    (void)user;
    FILE *file = offset <= LONG_MAX ? fopen(path, "rb") : NULL;
    if (!file) return psplat_fail(error, PSPLAT_ERROR_READ, 0, "cannot read %.150s", path);
    int is_wrong = fseek(file, (long)offset, SEEK_SET) != 0;
    *got = is_wrong ? 0 : fread(data, 1, size, file);
    is_wrong = is_wrong || ferror(file);
    fclose(file);
    return is_wrong ? psplat_fail(error, PSPLAT_ERROR_READ, 0, "cannot read %.150s", path)
                    : PSPLAT_OK;
}

static psplat_result size_with_stdio(void *user, const char *path, uint64_t *size,
                                     psplat_error *error) {
    (void)user;
    FILE *file = fopen(path, "rb");
    long end = file && !fseek(file, 0, SEEK_END) ? ftell(file) : -1;
    if (file) fclose(file);
    if (end < 0) return psplat_fail(error, PSPLAT_ERROR_READ, 0, "cannot read %.150s", path);
    *size = (uint64_t)end;
    return PSPLAT_OK;
}

/* A file that grows in memory while it is read. */
typedef struct text {
    char *data;
    size_t size, capacity;
} text;

static psplat_result read_text(const psplat_tiles *tiles, const psplat_tiles_source *source,
                               const char *path, text *out, psplat_error *error) {
    for (;;) {
        size_t got = 0, to = out->capacity ? 2 * out->capacity : 65536;
        char *data = psplat_resize(&tiles->allocator, out->data, out->capacity, to);
        if (!data) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a tileset");
        out->data = data;
        out->capacity = to;
        psplat_result result = source->read(source->user, path, out->size, out->data + out->size,
                                            to - out->size, &got, error);
        if (result != PSPLAT_OK) return result;
        int is_end = got < to - out->size;
        out->size += got;
        if (is_end) return PSPLAT_OK;
        if (out->size > max_file_size)
            return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0, "%.150s is too large", path);
    }
}

/* ---- opening -------------------------------------------------------------------------------- */

static const char *file_name(const char *path) {
    const char *name = path;
    for (const char *c = path; *c; ++c)
        if (*c == '/' || *c == '\\') name = c + 1;
    return name;
}

static int is_archive(const char *path) {
    size_t length = strlen(path);
    const char *end = path + length - (length < 4 ? 0 : 4);
    return end[0] == '.' && end[1] == '3' && (end[2] | 32) == 't' && (end[3] | 32) == 'z';
}

/* Reads the tileset.json of an archive, whose bytes are *begin of the text. */
static psplat_result read_from_archive(psplat_tiles *tiles, const psplat_tiles_source *source,
                                       const char *path, text *out, const void **begin,
                                       psplat_error *error) {
    size_t got = 0;
    psplat_result result =
        psplat_tile_archive_open(source, path, &tiles->allocator, &tiles->archive, error);
    if (result) return result;
    const psplat_tile_entry *entry = psplat_tile_archive_find(&tiles->archive, "tileset.json");
    if (!entry || !entry->is_stored)
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                           "%.150s: there is no tileset.json that is stored as it is", path);
    if (entry->span <= max_file_size)
        out->data = psplat_resize(&tiles->allocator, NULL, 0, (size_t)entry->span);
    if (!out->data) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a tileset");
    out->capacity = (size_t)entry->span;
    out->size = (size_t)entry->size;
    result = source->read(source->user, path, entry->offset, out->data, out->capacity, &got, error);
    if (result) return result;
    return psplat_tile_archive_unpack(out->data, got, entry->size, begin, error);
}

/* Reads a tileset.json, from an archive if path is that of one. */
static psplat_result read_file(psplat_tiles *tiles, const psplat_tiles_source *given,
                               const char *path, text *file, const void **begin,
                               psplat_error *error) {
    const psplat_tiles_source stdio = {.read = read_with_stdio, .size = size_with_stdio};
    const psplat_tiles_source *source = given->read ? given : &stdio;
    if (is_archive(path)) return read_from_archive(tiles, source, path, file, begin, error);
    psplat_result result = read_text(tiles, source, path, file, error);
    *begin = file->data;
    return result;
}

static psplat_result open_tree(psplat_tiles *tiles, const psplat_tiles_source *source,
                               const char *path, psplat_error *error) {
    psplat_tileset_place place = {.error = HUGE_VAL,
                                  .allocator = psplat_allocator_default(&tiles->allocator)};
    for (int i = 0; i < 4; ++i) place.transform[5 * i] = 1.0;
    text file = {0};
    const void *begin = NULL;
    psplat_tileset tileset;
    if (error) *error = (psplat_error){0};
    psplat_result result = read_file(tiles, source, path, &file, &begin, error);
    place.archive = tiles->archive.name ? &tiles->archive : NULL;
    place.path = place.archive ? "tileset.json" : file_name(path);
    if (result && error && !error->text[0])
        psplat_fail(error, result, 0, "%s: %.150s", psplat_result_text(result), path);
    if (!result) result = psplat_tileset_read(begin, file.size, &place, &tileset, error);
    if (file.data) psplat_resize(&tiles->allocator, file.data, file.capacity, 0);
    if (result) return result;
    result = psplat_tiles_graft(tiles, &tileset, PSPLAT_TILE_NONE, error);
    if (!result) return PSPLAT_OK;
    psplat_arena_release(&tileset.kept);
    psplat_arena_release(&tileset.scratch);
    return result;
}

static psplat_result check_desc(const psplat_tiles_desc *desc, psplat_error *error) {
    if (desc->max_requests > MAX_REQUESTS)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%zu requests are more than %d",
                           desc->max_requests, MAX_REQUESTS);
    if (!(desc->fade_seconds >= 0) || !isfinite(desc->fade_seconds))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "fade_seconds is negative or not finite");
    return PSPLAT_OK;
}

psplat_result psplat_tiles_open(const psplat_tiles_desc *desc, const char *path,
                                psplat_tiles **tiles, psplat_error *error) {
    static const psplat_tile_models models = {psplat_model_create, psplat_model_destroy,
                                              psplat_model_describe};
    const psplat_tiles_desc defaults = {0};
    if (tiles) *tiles = NULL;
    if (!tiles || !path)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "path and tiles are required");
    if (!desc) desc = &defaults;
    psplat_result result = check_desc(desc, error);
    if (result) return result;
    psplat_tiles *made = psplat_allocate(&desc->allocator, 1, sizeof *made);
    if (!made) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a tileset");
    made->allocator = desc->allocator;
    made->models = &models;
    made->max_bytes = desc->max_bytes ? desc->max_bytes : default_bytes;
    made->max_requests = desc->max_requests ? desc->max_requests : DEFAULT_REQUESTS;
    made->fade_seconds = desc->fade_seconds;
    made->newest = made->oldest = PSPLAT_TILE_NONE;
    made->frame = 1; /* so that 0 is a frame long ago */
    atomic_init(&made->bytes, 0);
    result = psplat_tile_slots_create(made, error);
    if (!result) result = open_tree(made, &desc->source, path, error);
    if (result)
        psplat_tiles_destroy(made, NULL);
    else
        *tiles = made;
    return result;
}

void psplat_tiles_destroy(psplat_tiles *tiles, psplat_renderer *renderer) {
    if (!tiles) return;
    psplat_tile_slots_destroy(tiles);
    for (size_t i = 0; i < tiles->content_count; ++i)
        if (tiles->loads[i].model) tiles->models->destroy(renderer, tiles->loads[i].model);
    psplat_tiles_free_tree(tiles);
    if (tiles->archive.name) psplat_arena_release(&tiles->archive.arena);
    psplat_allocator allocator = tiles->allocator;
    if (tiles->items)
        psplat_resize(&allocator, tiles->items, tiles->item_capacity * sizeof *tiles->items, 0);
    psplat_resize(&allocator, tiles, sizeof *tiles, 0);
}

/* ---- numbers -------------------------------------------------------------------------------- */

void psplat_tiles_bounds(const psplat_tiles *tiles, double min[3], double max[3]) {
    const psplat_tile_volume *volume = &tiles->nodes[0].volume;
    for (int i = 0; i < 3; ++i) {
        const double direction[3] = {i == 0, i == 1, i == 2};
        double reach = psplat_tile_reach(volume, direction);
        min[i] = volume->center[i] - reach;
        max[i] = volume->center[i] + reach;
    }
}

psplat_tiles_state psplat_tiles_describe(const psplat_tiles *tiles) {
    if (!tiles) return (psplat_tiles_state){0};
    psplat_tiles_state state = tiles->state;
    state.wanted = tiles->request_count - tiles->next_request;
    state.failed = tiles->failed;
    state.tiles = tiles->node_count;
    state.resident = tiles->resident;
    state.bytes = atomic_load(&tiles->bytes);
    for (size_t i = 0; i < tiles->max_requests; ++i) {
        enum psplat_tile_slot_state now = psplat_tile_slot_state_of(&tiles->slots[i]);
        state.under_way += now == PSPLAT_SLOT_UNDER_WAY || now == PSPLAT_SLOT_DECODING;
        state.waiting += now == PSPLAT_SLOT_ARRIVED;
    }
    return state;
}
