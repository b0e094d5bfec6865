/* SPDX-License-Identifier: MIT
 *
 * arena.h - blocks from the host's allocator that are given back all at once, so that a reader
 * that fails in the middle has one thing to release and can leak nothing.
 */
#ifndef PHONGSPLAT_ARENA_H
#define PHONGSPLAT_ARENA_H

#include <phongsplat/phongsplat.h>

typedef struct psplat_block psplat_block;

/* Zero-initialised but for the allocator, whose resize is not NULL (psplat_allocator_default). */
typedef struct psplat_arena {
    psplat_allocator allocator;
    psplat_block *blocks;
} psplat_arena;

/* The C library where allocator is NULL or zero-initialised, else the allocator itself. */
psplat_allocator psplat_allocator_default(const psplat_allocator *allocator);

/* count * size zeroed bytes, aligned for any type; count may be 0. NULL when out of memory or
 * when the product is not representable. */
void *psplat_arena_take(psplat_arena *arena, size_t count, size_t size);

/* The same without zeroing: for what is written at once, whose pages are not worth touching twice.
 */
void *psplat_arena_reserve(psplat_arena *arena, size_t count, size_t size);

/* Makes the arena owner of a block that came from its allocator. On failure (PSPLAT_ERROR_MEMORY)
 * the block has been freed. */
psplat_result psplat_arena_adopt(psplat_arena *arena, void *memory, size_t size);

/* Frees everything; the arena is then empty and usable. */
void psplat_arena_release(psplat_arena *arena);

#endif
