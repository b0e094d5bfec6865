/* SPDX-License-Identifier: MIT
 *
 * shown_asset.c - the assets that are shown: it takes over finished loads, places the models and
 * keeps the errors to be reported.
 */
#include "viewer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *shown_asset_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* ---- placing ------------------------------------------------------------------------------ */

/* Scales the sphere to radius 1 and moves its centre to x on the row. */
static void place_on_row(const sphere *from, double x, double transform[16], sphere *to) {
    double scale = from->radius > 0 ? 1 / from->radius : 1;
    *to = (sphere){{x, 0, 0}, from->radius * scale};
    memset(transform, 0, 16 * sizeof *transform);
    for (int i = 0; i < 3; ++i) {
        transform[i * 5] = scale;
        transform[12 + i] = to->center[i] - scale * from->center[i];
    }
    transform[15] = 1;
}

/* Enlarges a so that it also encloses b. The result is not the least such sphere, but exact where
 * one lies within the other. */
static void join(sphere *a, const sphere *b) {
    double offset[3], square = 0;
    for (int i = 0; i < 3; ++i) {
        offset[i] = b->center[i] - a->center[i];
        square += offset[i] * offset[i];
    }
    double distance = sqrt(square);
    if (distance + b->radius <= a->radius) return;
    if (distance + a->radius <= b->radius) {
        *a = *b;
        return;
    }
    double radius = 0.5 * (distance + a->radius + b->radius);
    for (int i = 0; i < 3; ++i) a->center[i] += (radius - a->radius) / distance * offset[i];
    a->radius = radius;
}

void shown_assets_arrange(shown_assets *s) {
    size_t placed = 0;
    s->item_count = s->splat_count = 0;
    s->bounds = (sphere){.radius = 0};
    for (size_t i = 0; i < s->entry_count; ++i) {
        shown_asset *entry = &s->entries[i];
        if (!entry->model && !entry->tiles) continue;
        psplat_item item = {.model = entry->model, .pose = entry->pose};
        sphere bounds = entry->bounds;
        if (s->is_side_by_side)
            place_on_row(&entry->bounds, 2.1 * (double)placed, item.transform, &bounds);
        if (placed++)
            join(&s->bounds, &bounds);
        else
            s->bounds = bounds;
        s->splat_count += entry->splat_count;
        memcpy(entry->tiles_transform, item.transform, sizeof item.transform);
        if (entry->model) s->items[s->item_count++] = item;
    }
}

int shown_assets_are_empty(const shown_assets *s) {
    return !s->item_count && !shown_tiles_exist(s);
}

/* ---- loads -------------------------------------------------------------------------------- */

static void free_pose(shown_asset *entry) {
    psplat_pose_destroy(entry->pose);
    psplat_asset_destroy(entry->asset);
    entry->pose = NULL;
    entry->asset = NULL;
}

/* Keeps the asset where it has animations, for its pose. */
static void take_pose(shown_asset *entry, loaded_file *file) {
    free_pose(entry);
    if (!psplat_asset_animation_count(file->asset)) return;
    if (psplat_pose_create(file->asset, &entry->pose, NULL)) return;
    decoded_images_free(file);
    entry->asset = file->asset;
    file->asset = NULL;
}

static void free_tiles(const shown_assets *s, shown_asset *entry) {
    tile_reader_destroy(entry->reader);
    psplat_tiles_destroy(entry->tiles, s->renderer);
    entry->reader = NULL;
    entry->tiles = NULL;
}

static void free_entries(shown_assets *s, shown_asset *entries, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        psplat_model_destroy(s->renderer, entries[i].model);
        free_pose(&entries[i]);
        free_tiles(s, &entries[i]);
        free(entries[i].path);
    }
    free(entries);
}

/* Takes a tileset over, with threads that read its tiles. */
static void take_tiles(const shown_assets *s, shown_asset *entry, loaded_file *file) {
    char path[MAX_PATH] = "";
    tileset_path(file->path, path, sizeof path);
    tile_reader *reader = tile_reader_create(file->tiles, path, s->wake);
    if (!reader) {
        psplat_fail(&entry->error, PSPLAT_ERROR_MEMORY, 0, "no thread to read tiles on");
        return;
    }
    free_tiles(s, entry);
    entry->tiles = file->tiles;
    entry->reader = reader;
    entry->bounds = file->bounds;
    file->tiles = NULL;
}

/* Replaces the entry's model where the file could be opened, else notes the error. */
static void update_entry(shown_assets *s, shown_asset *entry, loaded_file *file) {
    psplat_model *model = NULL;
    entry->error = file->error;
    if (file->tiles) take_tiles(s, entry, file);
    if (!file->asset) return;
    s->uploading = file;
    psplat_result result = psplat_model_create(s->renderer, file->asset, &model, &entry->error);
    s->uploading = NULL;
    if (result) return;
    psplat_model_destroy(s->renderer, entry->model);
    entry->model = model;
    entry->bounds = file->bounds;
    entry->splat_count = file->splat_count;
    entry->error = (psplat_error){0};
    take_pose(entry, file);
}

static shown_change reload(shown_assets *s, load *l) {
    for (size_t i = 0; i < l->count; ++i)
        for (size_t k = 0; k < s->entry_count; ++k)
            if (!strcmp(s->entries[k].path, l->files[i].path))
                update_entry(s, &s->entries[k], &l->files[i]);
    *s->refused_path = 0;
    shown_assets_arrange(s);
    return SHOWN_RELOADED;
}

static shown_change refuse(shown_assets *s, const char *path, const psplat_error *error) {
    snprintf(s->refused_path, sizeof s->refused_path, "%s", path);
    s->refused = *error;
    return SHOWN_RELOADED;
}

/* Shows a new set of files. A set of which no file can be shown changes nothing but the error. */
static shown_change replace(shown_assets *s, load *l) {
    shown_asset *entries = calloc(l->count, sizeof *entries);
    psplat_item *items = calloc(l->count, sizeof *items);
    size_t shown = 0;
    for (size_t i = 0; i < l->count && entries && items; ++i) {
        update_entry(s, &entries[i], &l->files[i]);
        entries[i].path = l->files[i].path;
        l->files[i].path = NULL;
        shown += entries[i].model || entries[i].tiles;
    }
    if (!shown) {
        psplat_error memory = {.code = PSPLAT_ERROR_MEMORY};
        int is_ready = entries && items;
        shown_change change = refuse(s, is_ready ? entries[0].path : l->files[0].path,
                                     is_ready ? &entries[0].error : &memory);
        free_entries(s, entries, is_ready ? l->count : 0);
        free(items);
        return change;
    }
    free_entries(s, s->entries, s->entry_count);
    free(s->items);
    s->entries = entries;
    s->items = items;
    s->entry_count = l->count;
    *s->refused_path = 0;
    shown_assets_arrange(s);
    return SHOWN_OPENED;
}

shown_change shown_assets_take(shown_assets *s, load *l) {
    shown_change change = l->is_reload ? reload(s, l) : replace(s, l);
    load_destroy(l);
    return change;
}

void shown_assets_clear(shown_assets *s) {
    free_entries(s, s->entries, s->entry_count);
    free(s->items);
    free(s->frame_items);
    *s = (shown_assets){.renderer = s->renderer, .wake = s->wake};
}

const psplat_error *shown_assets_error(const shown_assets *s, const char **path) {
    *path = s->refused_path;
    if (*s->refused_path) return &s->refused;
    for (size_t i = 0; i < s->entry_count; ++i)
        if (s->entries[i].error.code) {
            *path = s->entries[i].path;
            return &s->entries[i].error;
        }
    return NULL;
}
