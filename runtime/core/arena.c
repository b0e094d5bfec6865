/* SPDX-License-Identifier: MIT
 *
 * arena.c - the arena's blocks as a linked list, each with a header before its bytes.
 */
#include "core/arena.h"

#include "core/memory.h"

#include <stddef.h>
#include <string.h>

/* The header of a block. It lies before the bytes that were handed out, or stands alone and points
 * to a block that psplat_arena_adopt took over. */
struct psplat_block {
    psplat_block *next;
    size_t size;   /* bytes of this block, header included */
    void *adopted; /* NULL where the block itself holds the bytes */
    size_t adopted_size;
};

/* The size of the header is rounded up, so that the bytes after it are aligned for any type. */
enum {
    ALIGNMENT = _Alignof(max_align_t),
    HEADER = (sizeof(psplat_block) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT
};

static void *resize_with_libc(void *user, void *memory, size_t old_size, size_t new_size) {
    (void)user;
    return psplat_resize(&(psplat_allocator){0}, memory, old_size, new_size);
}

psplat_allocator psplat_allocator_default(const psplat_allocator *allocator) {
    if (allocator && allocator->resize) return *allocator;
    return (psplat_allocator){.resize = resize_with_libc};
}

void *psplat_arena_reserve(psplat_arena *arena, size_t count, size_t size) {
    if (size && count > (SIZE_MAX - HEADER) / size) return NULL;
    size_t total = HEADER + count * size;
    psplat_block *block = arena->allocator.resize(arena->allocator.user, NULL, 0, total);
    if (!block) return NULL;
    *block = (psplat_block){.next = arena->blocks, .size = total};
    arena->blocks = block;
    return (char *)block + HEADER;
}

void *psplat_arena_take(psplat_arena *arena, size_t count, size_t size) {
    void *memory = psplat_arena_reserve(arena, count, size);
    if (memory) memset(memory, 0, count * size);
    return memory;
}

psplat_result psplat_arena_adopt(psplat_arena *arena, void *memory, size_t size) {
    if (!memory) return PSPLAT_OK;
    if (!psplat_arena_take(arena, 0, 0)) {
        arena->allocator.resize(arena->allocator.user, memory, size, 0);
        return PSPLAT_ERROR_MEMORY;
    }
    arena->blocks->adopted = memory;
    arena->blocks->adopted_size = size;
    return PSPLAT_OK;
}

void psplat_arena_release(psplat_arena *arena) {
    psplat_allocator allocator = arena->allocator;
    while (arena->blocks) {
        psplat_block *block = arena->blocks;
        arena->blocks = block->next;
        if (block->adopted)
            allocator.resize(allocator.user, block->adopted, block->adopted_size, 0);
        allocator.resize(allocator.user, block, block->size, 0);
    }
}
