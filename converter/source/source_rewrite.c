/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_rewrite.c - a growing buffer that replaces the content of a source file.
 */
#include "source/source_rewrite.h"

#include "source/source_file.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Makes room for size more bytes and the 0 after them. */
static psplat_result reserve(psplat_rewrite *rewrite, size_t size, psplat_error *error) {
    if (rewrite->size + size < rewrite->capacity) return PSPLAT_OK;
    size_t capacity = (rewrite->size + size + 4096) * 2;
    char *larger = realloc(rewrite->data, capacity);
    if (!larger)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu bytes", capacity);
    rewrite->data = larger;
    rewrite->capacity = capacity;
    return PSPLAT_OK;
}

psplat_result psplat_rewrite_bytes(psplat_rewrite *rewrite, const void *bytes, size_t size,
                                   psplat_error *error) {
    psplat_result result = reserve(rewrite, size, error);
    if (result) return result;
    memcpy(rewrite->data + rewrite->size, bytes, size);
    rewrite->size += size;
    rewrite->data[rewrite->size] = 0;
    return PSPLAT_OK;
}

psplat_result psplat_rewrite_text(psplat_rewrite *rewrite, psplat_error *error, const char *format,
                                  ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    psplat_result result = reserve(rewrite, (size_t)length, error);
    if (result) return result;
    va_start(arguments, format);
    vsnprintf(rewrite->data + rewrite->size, (size_t)length + 1, format, arguments);
    va_end(arguments);
    rewrite->size += (size_t)length;
    return PSPLAT_OK;
}

void psplat_rewrite_replace(psplat_rewrite *rewrite, psplat_source *source) {
    free(source->data);
    source->data = rewrite->data;
    source->size = rewrite->size;
    *rewrite = (psplat_rewrite){0};
}
