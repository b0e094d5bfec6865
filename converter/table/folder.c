/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * folder.c - the directory of a sweep: made, or recognised by its table.
 *
 * The empty table is made before anything else, so that the directory of an interrupted sweep is
 * recognised whenever that ends.
 */
#define _XOPEN_SOURCE 700

#include "table/folder.h"

#include "base/file_bytes.h"
#include "base/output.h"
#include "base/path.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

const char psplat_folder_table[] = "tradeoff.csv";

static psplat_result refuse(const char *path, const char *what, const char *cause,
                            psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: %s%.80s", shown, what, cause);
}

char *psplat_folder_path(const char *folder, const char *name) {
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%s/%s", folder, name);
    return path;
}

static psplat_result make_directory(const char *path, psplat_error *error) {
    struct stat status;
    if (!mkdir(path, 0777)) return PSPLAT_OK;
    int cause = errno;
    if (cause != EEXIST) return refuse(path, "cannot be made: ", strerror(cause), error);
    if (stat(path, &status)) return refuse(path, "cannot be read: ", strerror(errno), error);
    return S_ISDIR(status.st_mode) ? PSPLAT_OK : refuse(path, "is not a directory", "", error);
}

/* A process that was killed may leave a temporary file (output.c), which counts as nothing. */
static psplat_result check_empty(const char *path, psplat_error *error) {
    char found[256] = "";
    DIR *listing = opendir(path);
    if (!listing) return refuse(path, "cannot be read: ", strerror(errno), error);
    for (struct dirent *entry; !*found && (entry = readdir(listing));) {
        const char *name = entry->d_name;
        if (strcmp(name, ".") && strcmp(name, "..") && strncmp(name, ".phongsplat-", 12))
            snprintf(found, sizeof found, "%s", name);
    }
    closedir(listing);
    return *found ? refuse(path, "is no directory of a sweep: it holds ", found, error) : PSPLAT_OK;
}

static psplat_result mark(const char *folder, const char *table, psplat_error *error) {
    struct stat status;
    if (!lstat(table, &status) && S_ISREG(status.st_mode)) return PSPLAT_OK;
    psplat_result result = check_empty(folder, error);
    return result ? result : psplat_output_write(table, "", 0, 0, error);
}

static psplat_result make_within(const char *folder, const char *name, psplat_error *error) {
    char *path = psplat_folder_path(folder, name);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = make_directory(path, error);
    free(path);
    return result;
}

psplat_result psplat_folder_open(const char *path, psplat_error *error) {
    char *table = psplat_folder_path(path, psplat_folder_table);
    psplat_result result = table
                               ? make_directory(path, error)
                               : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    if (!result) result = mark(path, table, error);
    if (!result) result = make_within(path, "assets", error);
    if (!result) result = make_within(path, "pictures", error);
    free(table);
    return result;
}

psplat_result psplat_folder_write(const char *folder, const char *name, const void *data,
                                  size_t size, psplat_error *error) {
    char *path = psplat_folder_path(folder, name);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = psplat_output_write(path, data, size, 1, error);
    free(path);
    return result;
}

psplat_result psplat_folder_read(const char *folder, const char *name, char **data, size_t *size,
                                 psplat_error *error) {
    char *path = psplat_folder_path(folder, name);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = psplat_file_read(path, data, size, error);
    free(path);
    return result;
}
