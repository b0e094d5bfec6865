/* SPDX-License-Identifier: MIT
 *
 * slots.c - hands requests over between threads, and counts the bytes of what is decoded while it
 * is allocated, so that max_bytes holds at every moment.
 */
#include "tileset/slots.h"

#include "core/memory.h"

#include <math.h>
#include <string.h>

/* Frames after which a request is made again double with each failure, up to this power of two. */
enum { MAX_DOUBLINGS = 8 };

/* What a splat and a tile are expected to take before any has arrived. */
static const double first_splat_bytes = 400.0, first_content_bytes = 256.0 * 1024.0;

/* ---- bytes --------------------------------------------------------------------------------- */

int psplat_tiles_take_bytes(psplat_tiles *tiles, size_t bytes) {
    size_t now = atomic_load_explicit(&tiles->bytes, memory_order_relaxed);
    do {
        if (bytes > tiles->max_bytes || now > tiles->max_bytes - bytes) return 0;
    } while (!atomic_compare_exchange_weak(&tiles->bytes, &now, now + bytes));
    return 1;
}

void psplat_tiles_give_bytes(psplat_tiles *tiles, size_t bytes) {
    atomic_fetch_sub(&tiles->bytes, bytes);
}

static int take(psplat_tile_slot *slot, size_t bytes) {
    size_t now = atomic_load_explicit(&slot->bytes, memory_order_relaxed) + bytes;
    if (!psplat_tiles_take_bytes(slot->tiles, bytes)) {
        slot->refused = now > slot->refused ? now : slot->refused;
        return 0;
    }
    atomic_store_explicit(&slot->bytes, now, memory_order_relaxed);
    slot->peak = now > slot->peak ? now : slot->peak;
    return 1;
}

static void give(psplat_tile_slot *slot, size_t bytes) {
    size_t now = atomic_load_explicit(&slot->bytes, memory_order_relaxed);
    atomic_store_explicit(&slot->bytes, now - bytes, memory_order_relaxed);
    psplat_tiles_give_bytes(slot->tiles, bytes);
}

/* The allocator of a slot's asset. A block that grows counts twice while it is copied. */
static void *resize_counted(void *user, void *memory, size_t old_size, size_t new_size) {
    psplat_tile_slot *slot = user;
    if (new_size && !take(slot, new_size)) return NULL;
    void *resized = psplat_resize(&slot->tiles->allocator, memory, old_size, new_size);
    if (new_size && !resized)
        give(slot, new_size);
    else if (memory)
        give(slot, old_size);
    return resized;
}

size_t psplat_tile_expected_bytes(const psplat_tiles *tiles, uint32_t content) {
    const psplat_tile_content *c = &tiles->contents[content];
    const psplat_tile_load *load = &tiles->loads[content];
    const psplat_tile_node *node = &tiles->nodes[c->node];
    if (load->need) return load->need;
    if (c->is_tileset) return 0;
    double splat =
        tiles->splat_total > 0 ? tiles->splat_bytes / tiles->splat_total : first_splat_bytes;
    double mean = tiles->content_total > 0 ? tiles->content_bytes / tiles->content_total
                                           : first_content_bytes;
    double bytes = node->splats ? splat * node->splats / node->content_count : mean;
    return bytes < (double)tiles->max_bytes ? (size_t)bytes : tiles->max_bytes;
}

/* ---- states -------------------------------------------------------------------------------- */

enum { STATE_MASK = (1 << PSPLAT_SLOT_BITS) - 1 };

enum psplat_tile_slot_state psplat_tile_slot_state_of(const psplat_tile_slot *slot) {
    uint32_t state = atomic_load_explicit(&slot->state, memory_order_acquire);
    return (enum psplat_tile_slot_state)(state & STATE_MASK);
}

/* Sets the state and keeps the number of the request; publishes what was written before. */
static void set_state(psplat_tile_slot *slot, enum psplat_tile_slot_state to) {
    uint32_t state = atomic_load_explicit(&slot->state, memory_order_relaxed);
    atomic_store_explicit(&slot->state, (state & ~(uint32_t)STATE_MASK) | (uint32_t)to,
                          memory_order_release);
}

/* Returns the slot of a request after it went from UNDER_WAY to another state, or NULL where it was
 * not under way. Of several threads that try, one succeeds. */
static psplat_tile_slot *claim(psplat_tiles *tiles, uint64_t tile, enum psplat_tile_slot_state to) {
    uint64_t index = tile >> 32;
    uint32_t request = (uint32_t)tile;
    if (!tiles || index >= tiles->max_requests) return NULL;
    psplat_tile_slot *slot = &tiles->slots[index];
    uint32_t expected = request << PSPLAT_SLOT_BITS | PSPLAT_SLOT_UNDER_WAY;
    uint32_t wanted = request << PSPLAT_SLOT_BITS | (uint32_t)to;
    return atomic_compare_exchange_strong(&slot->state, &expected, wanted) ? slot : NULL;
}

psplat_result psplat_tile_slots_create(psplat_tiles *tiles, psplat_error *error) {
    tiles->slots = psplat_allocate(&tiles->allocator, tiles->max_requests, sizeof *tiles->slots);
    if (!tiles->slots)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu requests",
                           tiles->max_requests);
    for (size_t i = 0; i < tiles->max_requests; ++i) {
        atomic_init(&tiles->slots[i].state, PSPLAT_SLOT_FREE);
        atomic_init(&tiles->slots[i].bytes, 0);
        tiles->slots[i].tiles = tiles;
    }
    return PSPLAT_OK;
}

static void drop_arrival(psplat_tile_slot *slot) {
    psplat_asset_destroy(slot->asset);
    slot->asset = NULL;
    if (!slot->is_tileset) return;
    psplat_arena_release(&slot->tileset.kept);
    psplat_arena_release(&slot->tileset.scratch);
}

void psplat_tile_slots_destroy(psplat_tiles *tiles) {
    for (size_t i = 0; tiles->slots && i < tiles->max_requests; ++i)
        if (psplat_tile_slot_state_of(&tiles->slots[i]) == PSPLAT_SLOT_ARRIVED)
            drop_arrival(&tiles->slots[i]);
    if (tiles->slots)
        psplat_resize(&tiles->allocator, tiles->slots, tiles->max_requests * sizeof *tiles->slots,
                      0);
}

psplat_tile_slot *psplat_tile_slot_find(psplat_tiles *tiles) {
    for (size_t i = 0; i < tiles->max_requests; ++i)
        if (psplat_tile_slot_state_of(&tiles->slots[i]) == PSPLAT_SLOT_FREE)
            return &tiles->slots[i];
    return NULL;
}

uint64_t psplat_tile_slot_begin(psplat_tile_slot *slot, uint32_t content, size_t reserved) {
    psplat_tiles *tiles = slot->tiles;
    const psplat_tile_content *c = &tiles->contents[content];
    const psplat_tile_node *node = &tiles->nodes[c->node];
    uint32_t state = atomic_load_explicit(&slot->state, memory_order_relaxed);
    uint32_t request = (state >> PSPLAT_SLOT_BITS) + 1;
    slot->content = content;
    slot->reserved = reserved;
    slot->peak = slot->refused = 0;
    slot->is_tileset = c->is_tileset;
    slot->stored = c->stored;
    slot->place = (psplat_tileset_place){.path = c->path,
                                         .referrer = c->file,
                                         .error = node->error,
                                         .archive = tiles->archive.name ? &tiles->archive : NULL,
                                         .allocator = psplat_allocator_default(&tiles->allocator)};
    memcpy(slot->place.transform, tiles->transforms[node->transform], sizeof slot->place.transform);
    tiles->loads[content].progress = PSPLAT_TILE_IN_SLOT;
    atomic_store_explicit(&slot->state, request << PSPLAT_SLOT_BITS | PSPLAT_SLOT_UNDER_WAY,
                          memory_order_release);
    request = request << PSPLAT_SLOT_BITS >> PSPLAT_SLOT_BITS;
    return (uint64_t)(slot - tiles->slots) << 32 | request;
}

void psplat_tile_slot_end(psplat_tile_slot *slot, psplat_tile_progress progress) {
    psplat_tile_load *load = &slot->tiles->loads[slot->content];
    psplat_asset_destroy(slot->asset);
    slot->asset = NULL;
    load->progress = progress;
    if (progress == PSPLAT_TILE_FAILED) ++slot->tiles->failed;
    set_state(slot, PSPLAT_SLOT_FREE);
}

void psplat_tile_slot_postpone(psplat_tile_slot *slot) {
    psplat_tile_load *load = &slot->tiles->loads[slot->content];
    uint32_t doublings = load->failures < MAX_DOUBLINGS ? load->failures : MAX_DOUBLINGS;
    load->again = slot->tiles->frame + (1u << doublings);
    ++load->failures;
    psplat_tile_slot_end(slot, PSPLAT_TILE_ABSENT);
}

/* ---- collecting ---------------------------------------------------------------------------- */

/* Remembers that max_bytes refused so many bytes of an asset, and some more, since it was not
 * complete. What did not fit beside the root alone never will. */
static void remember_refusal(psplat_tile_slot *slot) {
    const psplat_tiles *tiles = slot->tiles;
    psplat_tile_load *load = &slot->tiles->loads[slot->content];
    uint32_t root = tiles->nodes[0].first_content, node = tiles->contents[slot->content].node;
    size_t kept = 0, need = slot->refused + slot->refused / 4;
    for (uint32_t i = 0; node && i < tiles->nodes[0].content_count; ++i)
        kept += tiles->loads[root + i].bytes;
    if (slot->refused > tiles->max_bytes - kept) {
        psplat_tile_slot_end(slot, PSPLAT_TILE_FAILED);
        return;
    }
    if (need > tiles->max_bytes - kept) need = tiles->max_bytes - kept;
    load->need = need > load->need ? need : load->need;
    psplat_tile_slot_postpone(slot);
}

static void graft(psplat_tile_slot *slot) {
    psplat_tiles *tiles = slot->tiles;
    uint32_t node = tiles->contents[slot->content].node;
    psplat_result result = psplat_tiles_graft(tiles, &slot->tileset, node, NULL);
    if (result) drop_arrival(slot);
    if (!result)
        psplat_tile_slot_end(slot, PSPLAT_TILE_UPLOADED);
    else if (result == PSPLAT_ERROR_MEMORY)
        psplat_tile_slot_postpone(slot);
    else
        psplat_tile_slot_end(slot, PSPLAT_TILE_FAILED);
}

void psplat_tile_slots_collect(psplat_tiles *tiles) {
    for (size_t i = 0; i < tiles->max_requests; ++i) {
        psplat_tile_slot *slot = &tiles->slots[i];
        switch (psplat_tile_slot_state_of(slot)) {
        case PSPLAT_SLOT_ARRIVED:
            if (slot->is_tileset) graft(slot);
            break;
        case PSPLAT_SLOT_FAILED:
            psplat_tile_slot_end(slot, PSPLAT_TILE_FAILED);
            break;
        case PSPLAT_SLOT_RETRY:
            if (slot->refused)
                remember_refusal(slot);
            else
                psplat_tile_slot_postpone(slot);
            break;
        default:
            break;
        }
    }
}

size_t psplat_tile_slots_outstanding(const psplat_tiles *tiles) {
    size_t sum = 0;
    for (size_t i = 0; i < tiles->max_requests; ++i) {
        const psplat_tile_slot *slot = &tiles->slots[i];
        if (psplat_tile_slot_state_of(slot) == PSPLAT_SLOT_FREE) continue;
        size_t bytes = atomic_load_explicit(&slot->bytes, memory_order_relaxed);
        if (slot->reserved > bytes) sum += slot->reserved - bytes;
    }
    return sum;
}

/* ---- from any thread ----------------------------------------------------------------------- */

static psplat_result decode(psplat_tile_slot *slot, const void *bytes, size_t size,
                            psplat_error *error) {
    if (slot->place.archive) {
        psplat_result result = psplat_tile_archive_unpack(bytes, size, slot->stored, &bytes, error);
        if (result) return result;
        size = (size_t)slot->stored;
    }
    if (slot->is_tileset)
        return psplat_tileset_read(bytes, size, &slot->place, &slot->tileset, error);
    const psplat_asset_desc desc = {.allocator = {.resize = resize_counted, .user = slot},
                                    .only_draws = 1};
    return psplat_asset_open_memory(bytes, size, &desc, &slot->asset, error);
}

psplat_result psplat_tiles_supply(psplat_tiles *tiles, uint64_t tile, const void *bytes,
                                  size_t size, psplat_error *error) {
    if (!bytes && size)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "bytes must not be NULL");
    psplat_tile_slot *slot = claim(tiles, tile, PSPLAT_SLOT_DECODING);
    if (!slot) return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the request is not under way");
    psplat_result result = decode(slot, bytes, size, error);
    if (!result)
        set_state(slot, PSPLAT_SLOT_ARRIVED);
    else
        set_state(slot, result == PSPLAT_ERROR_MEMORY ? PSPLAT_SLOT_RETRY : PSPLAT_SLOT_FAILED);
    return result;
}

void psplat_tiles_fail(psplat_tiles *tiles, uint64_t tile, int is_final) {
    claim(tiles, tile, is_final ? PSPLAT_SLOT_FAILED : PSPLAT_SLOT_RETRY);
}
