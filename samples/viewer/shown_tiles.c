/* SPDX-License-Identifier: MIT
 *
 * shown_tiles.c - the tiles of a frame: chooses them, asks for what is missing, uploads what has
 * come, and puts their items beside those of the assets.
 */
#include "viewer.h"

#include <stdlib.h>
#include <string.h>

/* How much is uploaded in a frame, so that no frame takes long. */
enum { UPLOAD_BYTES = 8 << 20 };

int shown_tiles_exist(const shown_assets *s) {
    for (size_t i = 0; i < s->entry_count; ++i)
        if (s->entries[i].tiles) return 1;
    return 0;
}

int shown_tiles_have_news(shown_assets *s) {
    int has_news = 0;
    for (size_t i = 0; i < s->entry_count; ++i)
        if (s->entries[i].reader) has_news |= tile_reader_has_news(s->entries[i].reader);
    return has_news;
}

/* Adds the numbers of one tileset to those of all. */
static void add_state(psplat_tiles_state *sum, const psplat_tiles_state *one) {
    sum->drawn += one->drawn;
    sum->splats += one->splats;
    sum->missing += one->missing;
    sum->over_budget += one->over_budget;
    sum->under_way += one->under_way;
    sum->waiting += one->waiting;
    sum->failed += one->failed;
    sum->bytes += one->bytes;
    if (one->error_pixels > sum->error_pixels) sum->error_pixels = one->error_pixels;
}

static psplat_result choose(viewer *v, shown_asset *entry, const psplat_tiles_view *base,
                            psplat_error *error) {
    psplat_tiles_view view = *base;
    memcpy(view.transform, entry->tiles_transform, sizeof view.transform);
    /* A tile that cannot be uploaded is drawn as the one above it, which "failed" counts. */
    psplat_tiles_upload(entry->tiles, v->renderer, UPLOAD_BYTES, NULL);
    psplat_result result = psplat_tiles_select(entry->tiles, &view, error);
    if (result) return result;
    tile_reader_feed(entry->reader);
    psplat_tiles_state state = psplat_tiles_describe(entry->tiles);
    state.error_pixels *= v->settings.pixels / view.pixels;
    add_state(&v->tiles_state, &state);
    return PSPLAT_OK;
}

/* Makes room for the items of all tilesets behind those of the assets. Returns 0 where there is no
 * memory. */
static int reserve_items(shown_assets *s) {
    size_t count = s->item_count, one;
    for (size_t i = 0; i < s->entry_count; ++i)
        if (s->entries[i].tiles) count += (psplat_tiles_items(s->entries[i].tiles, &one), one);
    if (count <= s->frame_capacity) return 1;
    psplat_item *items = realloc(s->frame_items, 2 * count * sizeof *items);
    if (!items) return 0;
    s->frame_items = items;
    s->frame_capacity = 2 * count;
    return 1;
}

static size_t gather_items(shown_assets *s, int *is_fading) {
    size_t count = s->item_count;
    if (count) memcpy(s->frame_items, s->items, count * sizeof *s->items);
    for (size_t i = 0; i < s->entry_count; ++i) {
        size_t of_tiles = 0;
        if (!s->entries[i].tiles) continue;
        const psplat_item *items = psplat_tiles_items(s->entries[i].tiles, &of_tiles);
        for (size_t k = 0; k < of_tiles; ++k) *is_fading |= items[k].fade > 0;
        if (of_tiles) memcpy(s->frame_items + count, items, of_tiles * sizeof *items);
        count += of_tiles;
    }
    return count;
}

psplat_result shown_tiles_choose(viewer *v, const psplat_view *view, double samples,
                                 const psplat_item **items, size_t *count, psplat_error *error) {
    shown_assets *s = &v->shown;
    int is_fading = 0;
    *items = s->items;
    *count = s->item_count;
    v->tiles_state = (psplat_tiles_state){0};
    if (!shown_tiles_exist(s)) return PSPLAT_OK;
    const psplat_tiles_view base = {.view = view,
                                    .pixels = samples * v->settings.pixels,
                                    .max_splats = (size_t)v->options.max_splats,
                                    .seconds = window_seconds()};
    for (size_t i = 0; i < s->entry_count; ++i) {
        if (!s->entries[i].tiles) continue;
        psplat_result result = choose(v, &s->entries[i], &base, error);
        if (result) return result;
    }
    if (!reserve_items(s))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the items of tiles");
    *count = gather_items(s, &is_fading);
    *items = s->frame_items;
    if (v->tiles_state.waiting || is_fading) v->needs_redraw = 1;
    return PSPLAT_OK;
}
