/* SPDX-License-Identifier: MIT
 *
 * slots.h - requests under way. A slot holds what a decoding thread needs, so that no such thread
 * looks at the tree, and its state hands it over between threads.
 */
#ifndef PHONGSPLAT_TILESET_SLOTS_H
#define PHONGSPLAT_TILESET_SLOTS_H

#include "tileset/tree.h"

/* Makes room for max_requests slots; frees them with what has arrived. */
psplat_result psplat_tile_slots_create(psplat_tiles *tiles, psplat_error *error);
void psplat_tile_slots_destroy(psplat_tiles *tiles);

/* Returns the state of a slot, with what another thread wrote before it set that. */
enum psplat_tile_slot_state psplat_tile_slot_state_of(const psplat_tile_slot *slot);

/* Returns a free slot, or NULL. */
psplat_tile_slot *psplat_tile_slot_find(psplat_tiles *tiles);

/* Begins a request for a content in a free slot, and returns its number. */
uint64_t psplat_tile_slot_begin(psplat_tile_slot *slot, uint32_t content, size_t reserved);

/* Frees a slot with its asset. The content is in the given progress afterwards. */
void psplat_tile_slot_end(psplat_tile_slot *slot, psplat_tile_progress progress);

/* Does the same for a content that is to be requested again later. */
void psplat_tile_slot_postpone(psplat_tile_slot *slot);

/* Adds bytes to those in memory. Returns 0 where max_bytes forbids it. */
int psplat_tiles_take_bytes(psplat_tiles *tiles, size_t bytes);
void psplat_tiles_give_bytes(psplat_tiles *tiles, size_t bytes);

/* Deals with what other threads have finished: failures and external tilesets. Assets stay in their
 * slots. */
void psplat_tile_slots_collect(psplat_tiles *tiles);

/* Returns the bytes that requests under way are expected to take beyond what they have. */
size_t psplat_tile_slots_outstanding(const psplat_tiles *tiles);

/* Returns the bytes that a content is expected to take. */
size_t psplat_tile_expected_bytes(const psplat_tiles *tiles, uint32_t content);

/* Returns the bytes that psplat_model_create takes on the GPU but for images (upload.c). */
size_t psplat_tile_model_bytes(const psplat_asset *asset);

#endif
