/* SPDX-License-Identifier: MIT
 *
 * memory.c - the only file of the runtime that calls realloc and free.
 */
#include "core/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *psplat_resize(const psplat_allocator *allocator, void *memory, size_t old_size,
                    size_t new_size) {
    if (allocator->resize) return allocator->resize(allocator->user, memory, old_size, new_size);
    if (new_size) return realloc(memory, new_size);
    free(memory);
    return NULL;
}

void *psplat_allocate(const psplat_allocator *allocator, size_t count, size_t size) {
    if (size && count > SIZE_MAX / size) return NULL;
    size_t bytes = count * size;
    if (bytes == 0) bytes = 1;
    void *memory = psplat_resize(allocator, NULL, 0, bytes);
    if (memory) memset(memory, 0, bytes);
    return memory;
}
