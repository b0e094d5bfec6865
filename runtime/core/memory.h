/* SPDX-License-Identifier: MIT
 *
 * memory.h - memory from the host's allocator, or from the C library where the host gave none.
 */
#ifndef PHONGSPLAT_CORE_MEMORY_H
#define PHONGSPLAT_CORE_MEMORY_H

#include <phongsplat/phongsplat.h>

/* Does what psplat_allocator.resize promises, with the allocator or, where its resize is NULL, with
 * realloc and free. */
void *psplat_resize(const psplat_allocator *allocator, void *memory, size_t old_size,
                    size_t new_size);

/* Allocates count * size bytes of zeros, and at least one byte. Returns NULL where memory runs out
 * or the product overflows. The caller frees the block with psplat_resize. */
void *psplat_allocate(const psplat_allocator *allocator, size_t count, size_t size);

#endif
