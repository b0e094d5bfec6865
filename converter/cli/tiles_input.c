/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tiles_input.c - reads the tiles that a view wants, one after another.
 */
#define _XOPEN_SOURCE 700

#include "cli/tiles_input.h"

#include <phongsplat/splat.h>

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* No budget bounds a picture that is drawn once. */
static const size_t unlimited = SIZE_MAX / 4;

enum { REQUESTS = 64 };

static int is_directory(const char *path) {
    struct stat status;
    return !stat(path, &status) && S_ISDIR(status.st_mode);
}

int psplat_tiles_input_expected(const char *path) {
    const char *dot = strrchr(path, '.');
    return (dot && (!strcasecmp(dot, ".json") || !strcasecmp(dot, ".3tz"))) || is_directory(path);
}

/* Returns a directory with the name of a file in it; NULL where there is no memory. */
static char *join(const char *directory, const char *name) {
    size_t size = strlen(directory) + strlen(name) + 2;
    char *path = malloc(size);
    const char *end = directory + strlen(directory);
    if (path)
        snprintf(path, size, "%s%s%s", directory, end > directory && end[-1] != '/' ? "/" : "",
                 name);
    return path;
}

psplat_result psplat_tiles_input_open(const char *path, psplat_tiles_input *input,
                                      psplat_error *error) {
    const psplat_tiles_desc desc = {.max_bytes = unlimited, .max_requests = REQUESTS};
    char *name = is_directory(path) ? join(path, "tileset.json") : strdup(path);
    const char *slash = name ? strrchr(name, '/') : NULL;
    *input = (psplat_tiles_input){0};
    if (name) input->directory = strndup(name, slash ? (size_t)(slash + 1 - name) : 0);
    psplat_result result = input->directory
                               ? psplat_tiles_open(&desc, name, &input->tiles, error)
                               : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    free(name);
    return result;
}

/* Puts the name of a tile's file before the cause of an error. */
static psplat_result name_tile(psplat_result result, const char *path, psplat_error *error) {
    char text[sizeof error->text];
    memcpy(text, error->text, sizeof text);
    return psplat_fail(error, result, error->offset, "%s: %s", path,
                       *text ? text : psplat_result_text(result));
}

/* Reads a part of a file, or all from offset on where *size is 0. The caller frees *bytes. */
static psplat_result read_range(const char *path, uint64_t offset, uint64_t *size, uint8_t **bytes,
                                psplat_error *error) {
    FILE *file = fopen(path, "rb");
    if (!file) return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s", strerror(errno));
    if (!*size && !fseeko(file, 0, SEEK_END)) {
        off_t end = ftello(file);
        *size = end > 0 && (uint64_t)end > offset ? (uint64_t)end - offset : 0;
    }
    *bytes = malloc(*size ? *size : 1);
    int is_read =
        *bytes && !fseeko(file, (off_t)offset, SEEK_SET) && fread(*bytes, 1, *size, file) == *size;
    fclose(file);
    if (is_read) return PSPLAT_OK;
    return *bytes ? psplat_fail(error, PSPLAT_ERROR_READ, 0, "the file cannot be read to its end")
                  : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a tile");
}

static psplat_result read_tile(const psplat_tiles_input *input, const psplat_tile_request *request,
                               psplat_error *error) {
    uint8_t *bytes = NULL;
    uint64_t size = request->size;
    char *path = join(input->directory, request->path);
    psplat_result result = path ? read_range(path, request->offset, &size, &bytes, error)
                                : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory");
    free(path);
    if (!result) result = psplat_tiles_supply(input->tiles, request->tile, bytes, size, error);
    free(bytes);
    return result ? name_tile(result, request->path, error) : PSPLAT_OK;
}

psplat_result psplat_tiles_input_load(const psplat_tiles_input *input, psplat_renderer *renderer,
                                      const psplat_tiles_view *view, psplat_error *error) {
    psplat_result result = psplat_tiles_select(input->tiles, view, error);
    while (!result) {
        psplat_tile_request requests[REQUESTS];
        size_t count = psplat_tiles_wanted(input->tiles, requests, REQUESTS);
        if (!count) return PSPLAT_OK;
        for (size_t i = 0; i < count && !result; ++i)
            result = read_tile(input, &requests[i], error);
        if (!result) result = psplat_tiles_upload(input->tiles, renderer, unlimited, error);
        if (!result) result = psplat_tiles_select(input->tiles, view, error);
    }
    return result;
}

void psplat_tiles_input_close(psplat_tiles_input *input, psplat_renderer *renderer) {
    psplat_tiles_destroy(input->tiles, renderer);
    free(input->directory);
    *input = (psplat_tiles_input){0};
}
