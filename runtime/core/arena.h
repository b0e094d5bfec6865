/* SPDX-License-Identifier: MIT
 *
 * arena.h - an arena: blocks from the host's allocator that are freed all at once, so that a reader
 * that fails in the middle has one thing to release and can leak nothing.
 */
#ifndef PHONGSPLAT_CORE_ARENA_H
#define PHONGSPLAT_CORE_ARENA_H

#include <phongsplat/phongsplat.h>

typedef struct psplat_block psplat_block;

/* Callers set allocator, whose resize may not be NULL (psplat_allocator_default), and leave blocks
 * NULL. */
typedef struct psplat_arena {
    psplat_allocator allocator;
    psplat_block *blocks;
} psplat_arena;

/* Returns *allocator, or an allocator of the C library where allocator is NULL or zero-initialised.
 */
psplat_allocator psplat_allocator_default(const psplat_allocator *allocator);

/* Returns count * size zeroed bytes, aligned for any type; count may be 0. The arena owns them.
 * Returns NULL where memory runs out or the product overflows. */
void *psplat_arena_take(psplat_arena *arena, size_t count, size_t size);

/* Does what psplat_arena_take does, but leaves the bytes undefined. It is for large blocks that are
 * filled at once, whose pages need not be touched twice. */
void *psplat_arena_reserve(psplat_arena *arena, size_t count, size_t size);

/* Makes the arena the owner of a block of size bytes that came from its allocator, or does nothing
 * where memory is NULL. On failure (PSPLAT_ERROR_MEMORY) the block has been freed. */
psplat_result psplat_arena_adopt(psplat_arena *arena, void *memory, size_t size);

/* Frees all blocks. The arena is then empty and may be used again. */
void psplat_arena_release(psplat_arena *arena);

#endif
