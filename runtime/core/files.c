/* SPDX-License-Identifier: MIT
 *
 * files.c - reads whole files with stdio, as psplat_files in phongsplat.h promises.
 */
#include "core/files.h"

#include <stdio.h>

/* Changes the block's size to new_size bytes. Returns 0 on failure, which leaves the block as it
 * was. */
static int resize_block(const psplat_allocator *allocator, void **data, size_t *capacity,
                        size_t new_size) {
    void *resized = allocator->resize(allocator->user, *data, *capacity, new_size);
    if (!resized && new_size) return 0;
    *data = resized;
    *capacity = new_size;
    return 1;
}

/* Reads to the end into a block that doubles. The size is not asked for in advance, because pipes
 * and the files of /proc do not know it. */
static psplat_result read_stream(FILE *file, const psplat_allocator *allocator, size_t max_size,
                                 void **data, size_t *capacity) {
    size_t size = 0;
    for (;;) {
        if (size == *capacity) {
            size_t target = size < 65536 ? 65536 : size > SIZE_MAX / 2 ? SIZE_MAX : 2 * size;
            /* One byte beyond the limit tells a file of the limit's size from a longer one. */
            if (max_size < SIZE_MAX && target > max_size + 1) target = max_size + 1;
            if (!resize_block(allocator, data, capacity, target)) return PSPLAT_ERROR_MEMORY;
        }
        size_t got = fread((char *)*data + size, 1, *capacity - size, file);
        size += got;
        if (size > max_size) return PSPLAT_ERROR_RANGE;
        if (ferror(file)) return PSPLAT_ERROR_READ;
        if (feof(file)) break;
    }
    return resize_block(allocator, data, capacity, size) ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

static psplat_result read_with_stdio(void *user, const psplat_allocator *allocator,
                                     const char *path, size_t max_size, void **data, size_t *size) {
    (void)user;
    FILE *file = fopen(path, "rb");
    if (!file) return PSPLAT_ERROR_READ;
    void *block = NULL;
    size_t capacity = 0;
    psplat_result result = read_stream(file, allocator, max_size, &block, &capacity);
    fclose(file);
    if (result) {
        if (block) allocator->resize(allocator->user, block, capacity, 0);
        return result;
    }
    *data = block;
    *size = capacity;
    return PSPLAT_OK;
}

psplat_files psplat_files_default(const psplat_files *files) {
    if (files && files->read) return *files;
    return (psplat_files){.read = read_with_stdio};
}
