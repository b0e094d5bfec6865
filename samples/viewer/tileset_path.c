/* SPDX-License-Identifier: MIT
 *
 * tileset_path.c - tells tilesets from assets by their names.
 */
#include "viewer.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

int tileset_path(const char *path, char *name, size_t size) {
    struct stat status;
    size_t length = strlen(path);
    int is_directory = !stat(path, &status) && S_ISDIR(status.st_mode);
    const char *end = length > 5 ? path + length - 5 : "";
    int is_file = !strcasecmp(end, ".json") || (*end && !strcasecmp(end + 1, ".3tz"));
    const char *slash = length && path[length - 1] == '/' ? "" : "/";
    if (!is_directory && !is_file) return 0;
    int written = is_directory ? snprintf(name, size, "%s%stileset.json", path, slash)
                               : snprintf(name, size, "%s", path);
    return written > 0 && (size_t)written < size;
}
