/* SPDX-License-Identifier: MIT
 *
 * upload.c - turns what has arrived into models, and destroys models that are not used to make
 * room.
 */
#include "tileset/slots.h"

#include "asset/pack.h"

/* ---- eviction ------------------------------------------------------------------------------- */

static void destroy_models(psplat_tiles *tiles, psplat_renderer *renderer, uint32_t node) {
    const psplat_tile_node *n = &tiles->nodes[node];
    for (uint32_t i = 0; i < n->content_count; ++i) {
        psplat_tile_load *load = &tiles->loads[n->first_content + i];
        if (load->progress != PSPLAT_TILE_UPLOADED) continue;
        tiles->models->destroy(renderer, load->model);
        psplat_tiles_give_bytes(tiles, load->bytes);
        load->model = NULL;
        load->bytes = 0;
        load->progress = PSPLAT_TILE_ABSENT;
    }
}

/* Destroys the tile that was used least recently. Returns 0 where there is none but the root and
 * those of the last select. */
static int evict(psplat_tiles *tiles, psplat_renderer *renderer) {
    uint32_t node = tiles->oldest;
    if (node == PSPLAT_TILE_NONE || node == 0 || tiles->uses[node].used == tiles->frame) return 0;
    tiles->resident -= (size_t)psplat_tile_is_ready(tiles, node);
    destroy_models(tiles, renderer, node);
    tiles->uses[node].uploaded = 0;
    psplat_tile_unlist(tiles, node);
    return 1;
}

/* Makes room for what is under way and for the requests that come next. */
static void make_room(psplat_tiles *tiles, psplat_renderer *renderer) {
    size_t need = psplat_tile_slots_outstanding(tiles), free_slots = 0;
    for (size_t i = 0; i < tiles->max_requests; ++i)
        free_slots += psplat_tile_slot_state_of(&tiles->slots[i]) == PSPLAT_SLOT_FREE;
    for (size_t i = tiles->next_request; i < tiles->request_count && free_slots--; ++i) {
        size_t bytes = psplat_tile_expected_bytes(tiles, tiles->requests[i]);
        if (need > tiles->max_bytes || bytes > tiles->max_bytes - need) break;
        need += bytes;
    }
    while (atomic_load(&tiles->bytes) + need > tiles->max_bytes && evict(tiles, renderer)) continue;
}

/* ---- one tile ------------------------------------------------------------------------------- */

static size_t texture_bytes(size_t splats, int row_splats, int floats) {
    size_t row = (size_t)row_splats;
    return (splats + row - 1) / row * row * (size_t)floats * sizeof(float);
}

size_t psplat_tile_model_bytes(const psplat_asset *asset) {
    size_t count = psplat_asset_all_batch_count(asset), bytes = 0;
    for (size_t i = 0; i < count; ++i) {
        const psplat_batch *batch = psplat_asset_batch(asset, i);
        int is_twin = 0;
        for (size_t k = 0; k < i && !is_twin; ++k)
            is_twin = psplat_asset_batch(asset, k)->primitive == batch->primitive;
        if (is_twin) continue;
        psplat_packing p = psplat_packing_of(batch);
        const int floats[] = {p.splat_floats, p.clip_floats, p.finish_floats, p.texcoord_floats};
        for (int k = 0; k < 4; ++k)
            bytes += texture_bytes(batch->splat_count, p.row_splats, floats[k]);
    }
    return bytes;
}

static int is_double_sided(const psplat_asset *asset) {
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        if (psplat_asset_batch(asset, i)->material.double_sided) return 1;
    return 0;
}

/* Counts a model whose bytes were taken already, and destroys its asset. */
static void keep_model(psplat_tile_slot *slot, psplat_model *model) {
    psplat_tiles *tiles = slot->tiles;
    psplat_tile_load *load = &tiles->loads[slot->content];
    psplat_model_info info = tiles->models->describe(model);
    load->model = model;
    load->bytes = info.bytes;
    load->splats = (uint32_t)info.splat_count;
    load->failures = 0;
    load->is_double_sided = is_double_sided(slot->asset);
    size_t both = atomic_load(&slot->bytes) + info.bytes;
    load->need = both > slot->peak ? both : slot->peak;
    tiles->splat_bytes += (double)load->need;
    tiles->splat_total += (double)info.splat_count;
    tiles->content_bytes += (double)load->need;
    tiles->content_total += 1;
    psplat_tile_slot_end(slot, PSPLAT_TILE_UPLOADED);
}

/* Takes note of a content that has been uploaded; with the last one its tile can be drawn. */
static void complete(psplat_tiles *tiles, uint32_t node) {
    psplat_tile_node *n = &tiles->nodes[node];
    psplat_tile_use *use = &tiles->uses[node];
    use->used = tiles->frame; /* nothing that is uploaded now makes room for the next */
    psplat_tile_enlist(tiles, node);
    if (++use->uploaded < n->content_count) return;
    ++tiles->resident;
    n->splats = 0;
    use->sides = PSPLAT_SIDES_SINGLE;
    for (uint32_t i = 0; i < n->content_count; ++i) {
        const psplat_tile_load *load = &tiles->loads[n->first_content + i];
        n->splats += load->splats;
        if (load->is_double_sided) use->sides = PSPLAT_SIDES_DOUBLE;
    }
}

/* A tile for which there is no room is asked for again when there is; one that does not fit beside
 * the root alone never is. */
static void turn_away(psplat_tile_slot *slot, size_t bytes) {
    psplat_tiles *tiles = slot->tiles;
    psplat_tile_load *load = &tiles->loads[slot->content];
    size_t all = atomic_load(&slot->bytes) + bytes, kept = 0;
    const psplat_tile_node *root = &tiles->nodes[0];
    for (uint32_t i = 0; tiles->contents[slot->content].node && i < root->content_count; ++i)
        kept += tiles->loads[root->first_content + i].bytes;
    load->need = all > load->need ? all : load->need;
    if (all > tiles->max_bytes - kept)
        psplat_tile_slot_end(slot, PSPLAT_TILE_FAILED);
    else
        psplat_tile_slot_postpone(slot);
}

/* Takes bytes of the budget, for which tiles may have to go. Returns 0 where there is no room. */
static int take_room(psplat_tiles *tiles, psplat_renderer *renderer, size_t bytes) {
    while (!psplat_tiles_take_bytes(tiles, bytes))
        if (!evict(tiles, renderer)) return 0;
    return 1;
}

/* Keeps a model for which so many bytes were taken, or destroys it where it has more and there is
 * no room for them: how large decoded images are is not known before. */
static void settle(psplat_tile_slot *slot, psplat_renderer *renderer, psplat_model *model,
                   size_t taken) {
    psplat_tiles *tiles = slot->tiles;
    size_t bytes = tiles->models->describe(model).bytes;
    if (bytes > taken && !take_room(tiles, renderer, bytes - taken)) {
        tiles->models->destroy(renderer, model);
        psplat_tiles_give_bytes(tiles, taken);
        turn_away(slot, bytes);
        return;
    }
    if (taken > bytes) psplat_tiles_give_bytes(tiles, taken - bytes);
    uint32_t node = tiles->contents[slot->content].node;
    keep_model(slot, model);
    complete(tiles, node);
}

/* Uploads what a slot holds, which takes so many bytes without the images. */
static psplat_result upload(psplat_tile_slot *slot, psplat_renderer *renderer, size_t bytes,
                            psplat_error *error) {
    psplat_tiles *tiles = slot->tiles;
    psplat_model *model = NULL;
    if (!take_room(tiles, renderer, bytes)) {
        turn_away(slot, bytes);
        return PSPLAT_OK;
    }
    psplat_result result = tiles->models->create(renderer, slot->asset, &model, error);
    if (result == PSPLAT_OK) {
        settle(slot, renderer, model, bytes);
        return PSPLAT_OK;
    }
    psplat_tiles_give_bytes(tiles, bytes);
    if (result == PSPLAT_ERROR_MEMORY || result == PSPLAT_ERROR_GRAPHICS ||
        result == PSPLAT_ERROR_ARGUMENT) /* not the file's fault */
        psplat_tile_slot_postpone(slot);
    else
        psplat_tile_slot_end(slot, PSPLAT_TILE_FAILED);
    return result;
}

/* ---- all of them ---------------------------------------------------------------------------- */

/* What has arrived after the tile above it was destroyed is no use. */
static int is_orphan(const psplat_tiles *tiles, uint32_t content) {
    uint32_t parent = tiles->nodes[tiles->contents[content].node].parent;
    return parent != PSPLAT_TILE_NONE && tiles->nodes[parent].content_count &&
           !psplat_tile_is_ready(tiles, parent);
}

/* What the last selection did not want comes after all that it did. */
static int is_more_important(const psplat_tiles *tiles, uint32_t a, uint32_t b) {
    int wants_a = tiles->uses[tiles->contents[a].node].used == tiles->frame;
    int wants_b = tiles->uses[tiles->contents[b].node].used == tiles->frame;
    double pa = tiles->loads[a].priority, pb = tiles->loads[b].priority;
    if (wants_a != wants_b) return wants_a;
    return pa > pb || (pa == pb && a < b);
}

/* Returns the most important of the assets that have arrived, or NULL. */
static psplat_tile_slot *find_best(psplat_tiles *tiles) {
    psplat_tile_slot *best = NULL;
    for (size_t i = 0; i < tiles->max_requests; ++i) {
        psplat_tile_slot *slot = &tiles->slots[i];
        if (psplat_tile_slot_state_of(slot) != PSPLAT_SLOT_ARRIVED) continue;
        if (slot->is_tileset) continue; /* it arrived after the last collection */
        if (is_orphan(tiles, slot->content))
            psplat_tile_slot_end(slot, PSPLAT_TILE_ABSENT);
        else if (!best || is_more_important(tiles, slot->content, best->content))
            best = slot;
    }
    return best;
}

psplat_result psplat_tiles_upload(psplat_tiles *tiles, psplat_renderer *renderer, size_t max_bytes,
                                  psplat_error *error) {
    if (!tiles) return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "tiles must not be NULL");
    psplat_result result = PSPLAT_OK;
    psplat_tile_slots_collect(tiles);
    for (size_t uploaded = 0; result == PSPLAT_OK;) {
        psplat_tile_slot *slot = find_best(tiles);
        size_t bytes = slot ? psplat_tile_model_bytes(slot->asset) : 0;
        if (!slot || (uploaded && (uploaded > max_bytes || bytes > max_bytes - uploaded))) break;
        uploaded += bytes;
        result = upload(slot, renderer, bytes, error);
    }
    make_room(tiles, renderer);
    return result;
}
