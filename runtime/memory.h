/* SPDX-License-Identifier: MIT
 *
 * memory.h - the injected allocator, or the C library where none was given.
 */
#ifndef PHONGSPLAT_MEMORY_H
#define PHONGSPLAT_MEMORY_H

#include <phongsplat/phongsplat.h>

/* As psplat_allocator.resize. */
void *psplat_resize(const psplat_allocator *allocator, void *memory, size_t old_size,
                    size_t new_size);

/* count * size bytes of zeros, at least one; NULL when out of memory or when the product overflows.
 */
void *psplat_allocate(const psplat_allocator *allocator, size_t count, size_t size);

#endif
