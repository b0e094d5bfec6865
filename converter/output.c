/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output.c - files that are whole or absent.
 *
 * The bytes go to a temporary file in the directory of the target, are synced, and get their name
 * in one step: rename() where the target may be replaced, link() where it must not exist, because
 * link() fails when another process was faster and rename() would overwrite its file. While the
 * temporary file exists the signals that would end the process wait, so that Ctrl-C leaves nothing
 * behind. Devices and pipes cannot be renamed over without destroying them; they are written in
 * place.
 */
#define _XOPEN_SOURCE 700

#include "converter.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Names tried for the temporary file before giving up: it takes that many leftovers of killed
 * processes with our number to run out. */
enum { TEMPORARY_NAMES = 100 };

static psplat_result fail(psplat_error *error, const char *path, const char *what, int cause) {
    psplat_result code = cause == ENOMEM ? PSPLAT_ERROR_MEMORY : PSPLAT_ERROR_WRITE;
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    return psplat_fail(error, code, 0, "%s: %s: %s", shown, what, strerror(cause));
}

static psplat_result fail_existing(psplat_error *error, const char *path) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: exists already", shown);
}

/* 0 or an errno. */
static int write_all(int file, const uint8_t *data, size_t size) {
    while (size) {
        ssize_t written = write(file, data, size);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        data += written;
        size -= (size_t)written;
    }
    return 0;
}

static psplat_result write_in_place(const char *path, const void *data, size_t size,
                                    psplat_error *error) {
    int file = open(path, O_WRONLY | O_NOCTTY | O_CLOEXEC);
    if (file < 0) return fail(error, path, "cannot be opened for writing", errno);
    int cause = write_all(file, data, size);
    if (close(file) && !cause) cause = errno;
    return cause ? fail(error, path, "cannot be written", cause) : PSPLAT_OK;
}

/* The directory part of path including its slash, or "" for the current one. */
static size_t directory_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* Creates a new file beside path and stores its name, which the caller frees. Returns its
 * descriptor or -1 with errno set. The umask applies as to any new file. */
static int create_beside(const char *path, char **name) {
    size_t length = directory_length(path), room = length + 64;
    char *text = malloc(room);
    if (!text) {
        errno = ENOMEM;
        return -1;
    }
    memcpy(text, path, length);
    int file = -1;
    for (int i = 0; i < TEMPORARY_NAMES && file < 0; ++i) {
        snprintf(text + length, room - length, ".phongsplat-%ld-%d.tmp", (long)getpid(), i);
        file = open(text, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file < 0 && errno != EEXIST) break;
    }
    if (file < 0) {
        int cause = errno;
        free(text);
        text = NULL;
        errno = cause;
    }
    *name = text;
    return file;
}

/* Gives the temporary file its name without ever replacing another. File systems without hard links
 * get the name reserved by an exclusive creation first. 0 or an errno. */
static int publish_new(const char *temporary, const char *path) {
    if (!link(temporary, path)) {
        unlink(temporary);
        return 0;
    }
    if (errno != EPERM && errno != EOPNOTSUPP && errno != ENOSYS) return errno;
    int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) return errno;
    close(file);
    if (!rename(temporary, path)) return 0;
    int cause = errno;
    unlink(path);
    return cause;
}

/* Makes the new name survive a power cut. Not every file system can; the file is whole either way,
 * so a failure here is none of the caller's. */
static void sync_directory(const char *path) {
    size_t length = directory_length(path);
    char *directory = malloc(length + 2);
    if (!directory) return;
    memcpy(directory, path, length);
    memcpy(directory + length, length ? "" : ".", length ? 1 : 2);
    int file = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file >= 0) {
        fsync(file);
        close(file);
    }
    free(directory);
}

/* old is the file to be replaced, or NULL. 0 or an errno; what has failed is stored in what. */
static int write_beside(const char *path, const struct stat *old, const void *data, size_t size,
                        const char **what) {
    char *temporary = NULL;
    *what = "cannot be created";
    int file = create_beside(path, &temporary);
    if (file < 0) return errno;
    *what = "cannot be written";
    int cause = write_all(file, data, size);
    /* Permissions of the old file are kept as far as they may be. */
    if (!cause && old && fchmod(file, old->st_mode & 0777) && errno != EPERM) cause = errno;
    if (!cause && fsync(file) && errno != EINVAL && errno != EROFS) cause = errno;
    if (close(file) && !cause) cause = errno;
    if (!cause) {
        *what = "cannot be put in place";
        cause = !old ? publish_new(temporary, path) : rename(temporary, path) ? errno : 0;
    }
    if (cause) unlink(temporary);
    free(temporary);
    if (!cause) sync_directory(path);
    return cause;
}

static void hold_signals(sigset_t *before) {
    sigset_t ending;
    sigemptyset(&ending);
    sigaddset(&ending, SIGINT);
    sigaddset(&ending, SIGTERM);
    sigaddset(&ending, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &ending, before);
}

static psplat_result write_file(const char *path, const void *data, size_t size, int overwrite,
                                psplat_error *error) {
    struct stat old;
    int exists = !stat(path, &old);
    if (exists && S_ISDIR(old.st_mode)) return fail(error, path, "cannot be written", EISDIR);
    if (exists && !overwrite) return fail_existing(error, path);
    if (exists && !S_ISREG(old.st_mode)) return write_in_place(path, data, size, error);
    const char *what = NULL;
    sigset_t before;
    hold_signals(&before);
    int cause = write_beside(path, exists ? &old : NULL, data, size, &what);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (cause == EEXIST) return fail_existing(error, path);
    return cause ? fail(error, path, what, cause) : PSPLAT_OK;
}

psplat_result psplat_output_write(const char *path, const void *data, size_t size, int overwrite,
                                  psplat_error *error) {
    if (!path || !*path || (!data && size))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "no path or no data to write");
    if (!strcmp(path, "-")) {
        int cause = write_all(STDOUT_FILENO, data, size);
        return cause ? fail(error, "standard output", "cannot be written", cause) : PSPLAT_OK;
    }
    /* A symbolic link keeps pointing where it points: its target is what is replaced. */
    char *target = realpath(path, NULL);
    psplat_result result = write_file(target ? target : path, data, size, overwrite, error);
    free(target);
    return result;
}
