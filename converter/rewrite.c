/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rewrite.c - a growing block of bytes that in the end replaces the content of a source.
 */
#include "source.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

psplat_result psplat_rewrite_bytes(psplat_rewrite *rewrite, const void *bytes, size_t size,
                                   psplat_error *error) {
    if (rewrite->size + size >= rewrite->capacity) {
        size_t capacity = (rewrite->size + size + 4096) * 2;
        char *larger = realloc(rewrite->data, capacity);
        if (!larger)
            return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu bytes",
                               capacity);
        rewrite->data = larger;
        rewrite->capacity = capacity;
    }
    memcpy(rewrite->data + rewrite->size, bytes, size);
    rewrite->size += size;
    rewrite->data[rewrite->size] = 0;
    return PSPLAT_OK;
}

psplat_result psplat_rewrite_text(psplat_rewrite *rewrite, psplat_error *error, const char *format,
                                  ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return psplat_rewrite_bytes(rewrite, text, (size_t)length, error);
}

void psplat_rewrite_replace(psplat_rewrite *rewrite, psplat_source *source) {
    free(source->data);
    source->data = rewrite->data;
    source->size = rewrite->size;
    *rewrite = (psplat_rewrite){0};
}
