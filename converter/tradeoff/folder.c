/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * folder.c - the directory of a sweep: made, locked, its own.
 *
 * A hidden file marks it and is what is locked. It is made before anything else, so that an
 * interrupted sweep is recognised whenever it ends; flock() goes with the process however that
 * ends. Files of the user that came later are left alone.
 */
#define _DEFAULT_SOURCE /* flock */
#define _XOPEN_SOURCE 700

#include "tradeoff.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

static const char marker[] = ".phongsplat-tradeoff";
static const char assets[] = "assets";
static const char leftover[] = ".phongsplat-"; /* temporary files (output.c), ours and others' */

static psplat_result fail(psplat_error *error, psplat_result code, const char *path,
                          const char *what, const char *cause) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    return psplat_fail(error, code, 0, "%s: %s%.80s", shown, what, cause);
}

static psplat_result refuse(const char *path, const char *what, const char *cause,
                            psplat_error *error) {
    return fail(error, PSPLAT_ERROR_WRITE, path, what, cause);
}

static char *join(const char *directory, const char *name) {
    size_t size = strlen(directory) + strlen(name) + 2;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%s/%s", directory, name);
    return path;
}

char *psplat_folder_path(const psplat_folder *folder, const char *name) {
    return join(folder->path, name);
}

static psplat_result make_directory(const char *path, psplat_error *error) {
    struct stat status;
    if (!mkdir(path, 0777)) return PSPLAT_OK;
    int cause = errno;
    if (cause != EEXIST) return refuse(path, "cannot be made: ", strerror(cause), error);
    if (stat(path, &status)) return refuse(path, "cannot be read: ", strerror(errno), error);
    return S_ISDIR(status.st_mode) ? PSPLAT_OK : refuse(path, "is not a directory", "", error);
}

static int is_leftover(const char *name) {
    size_t length = strlen(name);
    return !strncmp(name, leftover, sizeof leftover - 1) && length > 4 &&
           (!strcmp(name + length - 4, ".tmp") || !strcmp(name + length - 4, ".glb"));
}

/* The first entry that is not ours goes into name; "" where there is none. Removes leftovers where
 * asked to. 0 or an errno. */
static int look_through(const char *path, int remove, char *name, size_t size) {
    DIR *listing = opendir(path);
    if (!listing) return errno;
    *name = 0;
    for (struct dirent *entry; (entry = readdir(listing));) {
        const char *found = entry->d_name;
        if (is_leftover(found)) {
            if (remove) unlinkat(dirfd(listing), found, 0);
        } else if (!*name && strcmp(found, ".") && strcmp(found, "..")) {
            snprintf(name, size, "%s", found);
        }
    }
    closedir(listing);
    return 0;
}

static psplat_result check_owner(const char *path, psplat_error *error) {
    char name[256], *own = join(path, marker);
    struct stat status;
    if (!own) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    int is_own = !lstat(own, &status) && S_ISREG(status.st_mode);
    free(own);
    if (is_own) return PSPLAT_OK;
    int cause = look_through(path, 0, name, sizeof name);
    if (cause) return refuse(path, "cannot be read: ", strerror(cause), error);
    return *name ? refuse(path, "is no directory of a sweep: it holds ", name, error) : PSPLAT_OK;
}

static psplat_result lock(psplat_folder *folder, psplat_error *error) {
    char *own = psplat_folder_path(folder, marker);
    if (!own) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    folder->lock = open(own, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    int cause = folder->lock < 0 ? errno : 0;
    free(own);
    if (cause) return refuse(folder->path, "cannot be written: ", strerror(cause), error);
    if (!flock(folder->lock, LOCK_EX | LOCK_NB)) return PSPLAT_OK;
    if (errno == EWOULDBLOCK)
        return refuse(folder->path, "another sweep is writing into it", "", error);
    return refuse(folder->path, "cannot be locked: ", strerror(errno), error);
}

static psplat_result make_assets(const psplat_folder *folder, psplat_error *error) {
    char name[256], *path = psplat_folder_path(folder, assets);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = make_directory(path, error);
    if (!result) {
        look_through(folder->path, 1, name, sizeof name);
        look_through(path, 1, name, sizeof name);
    }
    free(path);
    return result;
}

psplat_result psplat_folder_open(const char *path, psplat_folder *folder, psplat_error *error) {
    *folder = (psplat_folder){.path = strdup(path), .lock = -1};
    if (!folder->path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = make_directory(path, error);
    if (!result) result = check_owner(path, error);
    if (!result) result = lock(folder, error);
    if (!result) result = make_assets(folder, error);
    if (result) psplat_folder_close(folder);
    return result;
}

void psplat_folder_close(psplat_folder *folder) {
    if (folder->path && folder->lock >= 0) close(folder->lock);
    free(folder->path);
    *folder = (psplat_folder){.lock = -1};
}

psplat_result psplat_folder_write(const psplat_folder *folder, const char *name, const void *data,
                                  size_t size, psplat_error *error) {
    char *path = psplat_folder_path(folder, name);
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    psplat_result result = psplat_output_write(path, data, size, 1, error);
    free(path);
    return result;
}

/* 0 or an errno; ENOENT where there is no such file. */
static int read_all(const char *path, char **data, size_t *size) {
    struct stat status;
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return errno;
    int cause = fstat(file, &status) ? errno : S_ISREG(status.st_mode) ? 0 : EINVAL;
    size_t room = cause ? 0 : (size_t)status.st_size;
    *data = malloc(room + 1);
    *size = 0;
    if (!*data) cause = ENOMEM;
    while (!cause && *size < room) {
        ssize_t got = read(file, *data + *size, room - *size);
        if (got < 0 && errno != EINTR) cause = errno;
        if (!got) break;
        if (got > 0) *size += (size_t)got;
    }
    close(file);
    if (cause) free(*data);
    if (cause) *data = NULL;
    return cause;
}

psplat_result psplat_folder_read(const psplat_folder *folder, const char *name, char **data,
                                 size_t *size, psplat_error *error) {
    char *path = psplat_folder_path(folder, name);
    *data = NULL;
    *size = 0;
    if (!path) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a path");
    int cause = read_all(path, data, size);
    psplat_result result = PSPLAT_OK;
    if (cause && cause != ENOENT)
        result = fail(error, cause == ENOMEM ? PSPLAT_ERROR_MEMORY : PSPLAT_ERROR_READ, path,
                      "cannot be read: ", strerror(cause));
    free(path);
    return result;
}

uint64_t psplat_folder_stamp(const psplat_folder *folder, const char *name, size_t *size) {
    char *data = NULL;
    *size = 0;
    if (psplat_folder_read(folder, name, &data, size, NULL) || !data) return 0;
    uint64_t stamp = psplat_stamp_bytes(PSPLAT_STAMP, data, *size);
    free(data);
    return stamp;
}
