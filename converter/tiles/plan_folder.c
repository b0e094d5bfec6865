/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * plan_folder.c - which files of a directory are those of a plan.
 */
#define _XOPEN_SOURCE 700

#include "tiles/plan_folder.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char *psplat_tile_path(const char *directory, const char *name, const char *suffix) {
    size_t length = strlen(directory) + strlen(name) + strlen(suffix) + 2;
    char *path = malloc(length);
    if (path) snprintf(path, length, "%s/%s%s", directory, name, suffix);
    return path;
}

int psplat_plan_folder_is_empty(const char *directory) {
    int is_empty = 1;
    const struct dirent *entry;
    DIR *open = opendir(directory);
    if (!open) return errno == ENOENT ? 1 : -1;
    while ((entry = readdir(open)) != NULL)
        is_empty &= !strcmp(entry->d_name, ".") || !strcmp(entry->d_name, "..") ||
                    !strcmp(entry->d_name, PSPLAT_NEW_PLAN);
    closedir(open);
    return is_empty;
}

static int ends_with(const char *name, const char *end) {
    size_t length = strlen(name), tail = strlen(end);
    return length > tail && !strcmp(name + length - tail, end);
}

/* Returns whether a name is that of the list of a wave. */
static int is_list(const char *name) {
    return !strncmp(name, "tasks-", 6) && name[6] && !name[6 + strspn(name + 6, "0123456789")];
}

static int is_of_top(const char *name) {
    return !strcmp(name, "tasks") || is_list(name) || !strcmp(name, "Makefile") ||
           !strcmp(name, "tileset.json") ||
           (!strncmp(name, "tileset-", 8) && ends_with(name, ".json"));
}

static int is_of_work(const char *name) {
    return !strcmp(name, "triangles") || ends_with(name, ".record") || ends_with(name, ".mesh") ||
           ends_with(name, ".tmp");
}

static int is_of_tiles(const char *name) {
    return ends_with(name, ".glb") || ends_with(name, ".tmp");
}

static int is_of_new(const char *name) {
    return name[0] != '.' || ends_with(name, ".tmp");
}

/* Deletes the files of DIRECTORY/FOLDER whose names is_ours knows. */
static void delete_files(const char *directory, const char *folder,
                         int (*is_ours)(const char *name)) {
    const struct dirent *entry;
    char *path = psplat_tile_path(directory, folder, "");
    DIR *open = path ? opendir(path) : NULL;
    while (open && (entry = readdir(open)) != NULL) {
        char *file = is_ours(entry->d_name) ? psplat_tile_path(path, entry->d_name, "") : NULL;
        if (file) unlink(file);
        free(file);
    }
    if (open) closedir(open);
    free(path);
}

void psplat_plan_folder_clear(const char *directory) {
    delete_files(directory, "", is_of_top);
    delete_files(directory, "work", is_of_work);
    delete_files(directory, "tiles", is_of_tiles);
}

void psplat_plan_folder_drop_new(const char *directory) {
    char *path = psplat_tile_path(directory, PSPLAT_NEW_PLAN, "");
    delete_files(directory, PSPLAT_NEW_PLAN, is_of_new);
    if (path) rmdir(path);
    free(path);
}
