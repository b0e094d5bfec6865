/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output.c - files that are whole or absent.
 *
 * The bytes go to a draft in the directory of the target, are synced, and get their name in one
 * step: rename() where the target may be replaced, link() where it must not exist, because link()
 * fails when another process was faster and rename() would overwrite its file. A draft has no name
 * where the file system knows such files (O_TMPFILE): whatever ends the process, kill -9 or a power
 * cut, it is gone too. Only to replace a file it gets a name of its own first, since no system call
 * does both; elsewhere it has that name from the start. Signals that would end the process wait
 * meanwhile, so that Ctrl-C leaves nothing behind. Devices and pipes cannot be renamed over without
 * destroying them; they are written in place.
 */
#define _GNU_SOURCE /* O_TMPFILE */

#include "converter.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#ifndef O_TMPFILE
#define O_TMPFILE O_DIRECTORY /* no system opens a directory for writing */
#endif

/* Names tried for a draft before giving up; they differ by process and time. */
enum { DRAFT_NAMES = 100 };

/* What is to be written; old is the file to be replaced, or NULL. */
typedef struct output {
    const char *path;
    const void *data;
    size_t size;
    int overwrite;
    const struct stat *old;
} output;

typedef struct draft {
    int file;
    char *name; /* NULL: it has none */
} draft;

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

/* The length of path's directory including its slash; 0 for the current one. */
static size_t directory_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* Freed by the caller; NULL without memory. */
static char *directory_of(const char *path) {
    size_t length = directory_length(path);
    return length ? strndup(path, length) : strdup(".");
}

/* A file without a name gets one that must be free. 0 or an errno. */
static int link_nameless(int file, const char *path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    return linkat(AT_FDCWD, link, AT_FDCWD, path, AT_SYMLINK_FOLLOW) ? errno : 0;
}

/* Gives a draft its name beside path, creating the file if it has none yet. 0 or an errno. The
 * umask applies as to any new file. */
static int name_draft(draft *d, const char *path) {
    size_t length = directory_length(path), room = length + 96;
    char *name = malloc(room);
    if (!name) return ENOMEM;
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    memcpy(name, path, length);
    int cause = EEXIST;
    for (int i = 0; i < DRAFT_NAMES && cause == EEXIST; ++i) {
        snprintf(name + length, room - length, ".phongsplat-%ld-%lld-%ld.tmp", (long)getpid(),
                 (long long)now.tv_sec, now.tv_nsec + i);
        if (d->file >= 0) {
            cause = link_nameless(d->file, name);
        } else {
            d->file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            cause = d->file < 0 ? errno : 0;
        }
    }
    if (cause)
        free(name);
    else
        d->name = name;
    return cause == EEXIST ? EBUSY : cause; /* EEXIST is said of path alone */
}

/* 0 or an errno. */
static int create_draft(draft *d, const char *path, int nameless) {
    if (!nameless) return name_draft(d, path);
    char *directory = directory_of(path);
    if (!directory) return ENOMEM;
    d->file = open(directory, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    int cause = d->file < 0 ? errno : 0;
    free(directory);
    return cause;
}

/* All bytes are in the file, and on the disk. 0 or an errno. */
static int fill_draft(const draft *d, const output *o) {
    int cause = write_all(d->file, o->data, o->size);
    /* Permissions of the old file are kept as far as they may be. */
    if (!cause && o->old && fchmod(d->file, o->old->st_mode & 0777) && errno != EPERM)
        cause = errno;
    if (!cause && fsync(d->file) && errno != EINVAL && errno != EROFS) cause = errno;
    return cause;
}

/* Gives the file its name without ever replacing another. File systems without hard links get the
 * name reserved by an exclusive creation first. 0 or an errno. */
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

/* 0 or an errno. */
static int publish_draft(draft *d, const char *path, int overwrite) {
    if (!d->name) {
        int cause = link_nameless(d->file, path);
        if (cause != EEXIST || !overwrite) return cause;
        cause = name_draft(d, path);
        if (cause) return cause;
    }
    if (!overwrite) return publish_new(d->name, path);
    return rename(d->name, path) ? errno : 0;
}

/* Makes the new name survive a power cut. Not every file system can; the file is whole either way,
 * so a failure here is none of the caller's. */
static void sync_directory(const char *path) {
    char *directory = directory_of(path);
    int file = directory ? open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (file >= 0) {
        fsync(file);
        close(file);
    }
    free(directory);
}

/* 0 or an errno; what has failed is stored in what. */
static int write_beside(const output *o, int nameless, const char **what) {
    draft d = {-1, NULL};
    *what = "cannot be created";
    int cause = create_draft(&d, o->path, nameless);
    if (cause) return cause;
    *what = "cannot be written";
    cause = fill_draft(&d, o);
    if (!cause) {
        *what = "cannot be put in place";
        cause = publish_draft(&d, o->path, o->overwrite);
    }
    close(d.file); /* fsync has told what could be told */
    if (cause && d.name) unlink(d.name);
    free(d.name);
    if (!cause) sync_directory(o->path);
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
    const output o = {path, data, size, overwrite, exists ? &old : NULL};
    const char *what = NULL;
    sigset_t before;
    hold_signals(&before);
    /* Nameless files are tried, not asked for: what stands in their way has many errors. */
    int cause = write_beside(&o, 1, &what);
    if (cause && cause != EEXIST) cause = write_beside(&o, 0, &what);
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
