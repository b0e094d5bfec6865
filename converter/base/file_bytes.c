/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * file_bytes.c - reading a whole file into memory, with a limit of its size.
 */
#include "base/file_bytes.h"

#include "base/path.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads until the end or the limit without asking for the size, so that pipes work too. */
static psplat_result read_stream(FILE *file, const char *path, char **data, size_t *size,
                                 psplat_error *error) {
    size_t capacity = 1 << 16;
    size_t used = 0;
    char *bytes = malloc(capacity + 1);
    while (bytes) {
        used += fread(bytes + used, 1, capacity - used, file);
        if (used < capacity || used > PSPLAT_MAX_SOURCE_BYTES) break;
        capacity *= 2;
        char *larger = realloc(bytes, capacity + 1);
        if (!larger) free(bytes);
        bytes = larger;
    }
    if (!bytes) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", path);
    if (ferror(file) || used > PSPLAT_MAX_SOURCE_BYTES) {
        int large = used > PSPLAT_MAX_SOURCE_BYTES;
        free(bytes);
        if (large) return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%s: over 4 GiB", path);
        return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: %s", path, strerror(errno));
    }
    bytes[used] = 0;
    *data = bytes;
    *size = used;
    return PSPLAT_OK;
}

psplat_result psplat_file_read(const char *path, char **data, size_t *size, psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    FILE *file = fopen(path, "rb");
    if (!file) return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s: %s", shown, strerror(errno));
    psplat_result result = PSPLAT_OK;
    /* A file whose size is known to be too large is refused before it is read. A pipe has no size;
     * read_stream applies the limit to it. */
    if (fseek(file, 0, SEEK_END) == 0) {
        long end = ftell(file);
        if (end > 0 && end != LONG_MAX && (unsigned long)end > PSPLAT_MAX_SOURCE_BYTES)
            result = psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                                 "%s: %ld bytes; at most 4 GiB are read", shown, end);
        rewind(file);
    }
    if (!result) result = read_stream(file, shown, data, size, error);
    fclose(file);
    return result;
}
