/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output_folder.c - a folder of files that appears whole or not at all.
 *
 * The files go to a folder with a name of its own beside the target. A rename puts it in place, and
 * a tileset that was there is moved aside first and removed last. Only files whose names a tileset
 * has are ever removed: a folder with others is refused.
 */
#define _XOPEN_SOURCE 700

#include "cli/output_folder.h"

#include "base/path.h"
#include "cli/command.h"

#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

struct psplat_folder_file {
    char *name;
    uint8_t *data;
    size_t size;
};

static psplat_result fail(psplat_error *error, const char *path, const char *what, int cause) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    if (!cause) return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: %s", shown, what);
    return psplat_fail(error, cause == ENOMEM ? PSPLAT_ERROR_MEMORY : PSPLAT_ERROR_WRITE, 0,
                       "%s: %s: %s", shown, what, strerror(cause));
}

psplat_result psplat_output_folder_add(psplat_output_folder *folder, const char *name,
                                       const void *data, size_t size, psplat_error *error) {
    if (folder->count == folder->capacity) {
        size_t capacity = 2 * folder->capacity + 64;
        struct psplat_folder_file *files = realloc(folder->files, capacity * sizeof *files);
        if (!files) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for files");
        folder->files = files;
        folder->capacity = capacity;
    }
    struct psplat_folder_file file = {strdup(name), malloc(size + 1), size};
    if (!file.name || !file.data) {
        free(file.name);
        free(file.data);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a file of %zu bytes",
                           size);
    }
    memcpy(file.data, data, size);
    folder->files[folder->count++] = file;
    return PSPLAT_OK;
}

void psplat_output_folder_free(psplat_output_folder *folder) {
    for (size_t i = 0; i < folder->count; ++i) {
        free(folder->files[i].name);
        free(folder->files[i].data);
    }
    free(folder->files);
    *folder = (psplat_output_folder){0};
}

/* ---- paths ----------------------------------------------------------------------------------- */

/* Returns folder/name, malloc'ed, or NULL. */
static char *join(const char *folder, const char *name) {
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%s/%s", folder, name);
    return path;
}

/* Returns the folder that a path means, through symbolic links, or where there is none the path
 * without slashes at its end; malloc'ed, or NULL. */
static char *resolve(const char *path) {
    size_t length = strlen(path);
    char *real = realpath(path, NULL);
    if (real) return real;
    while (length > 1 && path[length - 1] == '/') --length;
    return strndup(path, length);
}

static int ends_with(const char *name, const char *end) {
    size_t length = strlen(name), tail = strlen(end);
    return length > tail && !strcmp(name + length - tail, end);
}

/* Returns whether a tileset may have a file of this name: in its folder, or in that of contents. */
static int is_known(const char *name, int is_content) {
    if (is_content) return ends_with(name, ".glb");
    return !strcmp(name, "tileset.json") || !strcmp(name, "tiles") ||
           (!strncmp(name, "tileset-", 8) && ends_with(name, ".json"));
}

/* Calls visit with the path and the name of each entry of a folder. Stores 0 in *all where visit
 * returns 0 for one. Returns 0 or an errno. */
static int each_entry(const char *folder, int is_content,
                      int (*visit)(const char *path, const char *name, int is_content), int *all,
                      size_t *count) {
    DIR *open = opendir(folder);
    const struct dirent *entry;
    int cause = open ? 0 : errno;
    while (!cause && (entry = readdir(open)) != NULL) {
        if (!strcmp(entry->d_name, ".") || !strcmp(entry->d_name, "..")) continue;
        char *path = join(folder, entry->d_name);
        if (!path) cause = ENOMEM;
        if (path && !visit(path, entry->d_name, is_content)) *all = 0;
        ++*count;
        free(path);
    }
    if (open) closedir(open);
    return cause;
}

/* Returns whether an entry, and what it holds, are what a tileset has. */
static int visit_known(const char *path, const char *name, int is_content) {
    struct stat status;
    int all = 1;
    size_t count = 0;
    if (!is_known(name, is_content) || lstat(path, &status)) return 0;
    if (is_content || strcmp(name, "tiles") != 0) return S_ISREG(status.st_mode);
    return S_ISDIR(status.st_mode) && !each_entry(path, 1, visit_known, &all, &count) && all;
}

static int visit_remove(const char *path, const char *name, int is_content) {
    int all = 1;
    size_t count = 0;
    if (!is_content && !strcmp(name, "tiles")) {
        each_entry(path, 1, visit_remove, &all, &count);
        return !rmdir(path);
    }
    return is_known(name, is_content) && !unlink(path);
}

/* Removes a folder of a tileset. */
static void remove_folder(const char *path) {
    int all = 1;
    size_t count = 0;
    each_entry(path, 0, visit_remove, &all, &count);
    rmdir(path);
}

/* ---- checks ---------------------------------------------------------------------------------- */

/* Returns whether a folder, by its real path, cannot be renamed: it is the working directory or one
 * above that, or a file system begins there. */
static int is_fixed(const char *target, const struct stat *status) {
    struct stat parent;
    size_t length = strlen(target);
    char *above = join(target, ".."), *here = realpath(".", NULL);
    int is_mount = above && !stat(above, &parent) &&
                   (parent.st_dev != status->st_dev || parent.st_ino == status->st_ino);
    int is_here = here && !strncmp(here, target, length) && (!here[length] || here[length] == '/');
    free(above);
    free(here);
    return is_mount || is_here;
}

psplat_result psplat_output_folder_check(const char *input, const char *path, int overwrite,
                                         psplat_error *error) {
    struct stat status;
    char *target = resolve(path);
    int all = 1;
    size_t count = 0;
    if (!target) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    psplat_result result = PSPLAT_OK;
    if (stat(target, &status)) {
        result = psplat_output_check(input, target, 0, error);
    } else if (!S_ISDIR(status.st_mode)) {
        result = fail(error, path, "is no directory", 0);
    } else if (is_fixed(target, &status)) {
        result = fail(error, path,
                      "is the working directory, one above it or a mount point, which cannot be "
                      "replaced as a whole",
                      0);
    } else {
        int cause = each_entry(target, 0, visit_known, &all, &count);
        if (cause)
            result = fail(error, path, "cannot be read", cause);
        else if (count && !all)
            result = fail(error, path, "holds files that are not those of a tileset", 0);
        else if (count && !overwrite)
            result = fail(error, path, "holds a tileset already; --overwrite replaces it", 0);
    }
    free(target);
    return result;
}

/* ---- writing --------------------------------------------------------------------------------- */

static psplat_result write_file(const char *folder, const struct psplat_folder_file *file,
                                psplat_error *error) {
    char *path = join(folder, file->name);
    FILE *out = path ? fopen(path, "wbx") : NULL;
    int cause = out ? 0 : path ? errno : ENOMEM;
    if (out && fwrite(file->data, 1, file->size, out) != file->size) cause = errno;
    if (out && fclose(out) && !cause) cause = errno;
    free(path);
    return cause ? fail(error, file->name, "cannot be written", cause) : PSPLAT_OK;
}

/* Writes all files to a folder that exists. */
static psplat_result fill_folder(const psplat_output_folder *folder, const char *path,
                                 psplat_error *error) {
    char *contents = join(path, "tiles");
    psplat_result result = PSPLAT_OK;
    mode_t mask = umask(0);
    umask(mask);
    if (!contents || chmod(path, 0777 & ~mask) || mkdir(contents, 0777))
        result = fail(error, path, "cannot be created", contents ? errno : ENOMEM);
    for (size_t i = 0; i < folder->count && !result; ++i)
        result = write_file(path, &folder->files[i], error);
    free(contents);
    sync();
    return result;
}

/* Gives a filled folder its name. */
static psplat_result put_in_place(const char *filled, const char *target, psplat_error *error) {
    size_t size = strlen(filled) + 5;
    char *old = malloc(size);
    if (!old) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    snprintf(old, size, "%s.old", filled);
    int has_old = !rename(target, old), cause = has_old || errno == ENOENT ? 0 : errno;
    if (!cause && rename(filled, target)) {
        cause = errno;
        if (has_old) rename(old, target);
    } else if (has_old && !cause) {
        remove_folder(old);
    }
    free(old);
    return cause ? fail(error, target, "cannot be put in place", cause) : PSPLAT_OK;
}

static void hold_signals(sigset_t *before) {
    sigset_t ending;
    sigemptyset(&ending);
    sigaddset(&ending, SIGINT);
    sigaddset(&ending, SIGTERM);
    sigaddset(&ending, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &ending, before);
}

psplat_result psplat_output_folder_write(const psplat_output_folder *folder, const char *path,
                                         int overwrite, psplat_error *error) {
    psplat_result result = psplat_output_folder_check(NULL, path, overwrite, error);
    char *target = result ? NULL : resolve(path);
    char *filled = target ? malloc(strlen(target) + 16) : NULL;
    sigset_t before;
    if (!result && !filled) result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    if (!result) {
        sprintf(filled, "%s.new-XXXXXX", target);
        hold_signals(&before);
        if (!mkdtemp(filled)) {
            result = fail(error, target, "cannot be created", errno);
        } else {
            result = fill_folder(folder, filled, error);
            if (!result) result = put_in_place(filled, target, error);
            if (result) remove_folder(filled);
        }
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    }
    free(target);
    free(filled);
    return result;
}
