/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output.c - atomic file output: a file is written whole or not at all.
 *
 * The bytes go to a temporary file in the directory of the target, which is synced and then gets
 * the target's name in one step. rename() does this where the target may be replaced, and link()
 * where it must not exist: link() fails if another process was faster, while rename() would
 * overwrite the file of that process. Where the file system can (O_TMPFILE), the temporary file has
 * no name at all, so that it vanishes with the process even after kill -9 or a power cut. To
 * replace a file it gets a name of its own first, since no system call replaces a file by a
 * nameless one. On other file systems it has that name from the start. Signals that would end the
 * process are held back meanwhile, so that Ctrl-C leaves nothing behind. Devices and pipes are
 * written in place, since renaming a file over them would destroy them.
 */
#define _GNU_SOURCE /* O_TMPFILE */

#include "base/output.h"

#include "base/path.h"

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

/* The number of names that are tried for a temporary file. They differ by process and time. */
enum { MAX_NAME_ATTEMPTS = 100 };

/* A file to be written. */
typedef struct output {
    const char *path;
    const void *data;
    size_t size;
    int overwrite;
    const struct stat *old; /* of the file that is replaced, or NULL */
} output;

typedef struct temporary_file {
    int file;
    char *name; /* malloc'ed, or NULL while the file has no name */
} temporary_file;

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

/* Writes all bytes to an open file. Returns 0 or an errno, as most functions below do. */
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

/* Returns the length of path's directory including its slash, or 0 for the current directory. */
static size_t directory_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* Returns the directory of path, which the caller frees, or NULL when out of memory. */
static char *directory_of(const char *path) {
    size_t length = directory_length(path);
    return length ? strndup(path, length) : strdup(".");
}

/* Gives a nameless file the name path, which must not exist. */
static int link_nameless(int file, const char *path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    return linkat(AT_FDCWD, link, AT_FDCWD, path, AT_SYMLINK_FOLLOW) ? errno : 0;
}

/* Gives a temporary file a name of its own beside path. Creates the file first if it is not open.
 * The umask applies as to any new file. */
static int name_temporary(temporary_file *t, const char *path) {
    size_t length = directory_length(path), room = length + 96;
    char *name = malloc(room);
    if (!name) return ENOMEM;
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    memcpy(name, path, length);
    int cause = EEXIST;
    for (int i = 0; i < MAX_NAME_ATTEMPTS && cause == EEXIST; ++i) {
        snprintf(name + length, room - length, ".phongsplat-%ld-%lld-%ld.tmp", (long)getpid(),
                 (long long)now.tv_sec, now.tv_nsec + i);
        if (t->file >= 0) {
            cause = link_nameless(t->file, name);
        } else {
            t->file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            cause = t->file < 0 ? errno : 0;
        }
    }
    if (cause)
        free(name);
    else
        t->name = name;
    return cause == EEXIST ? EBUSY : cause; /* callers read EEXIST as a statement about path */
}

/* Creates the temporary file in the directory of path. */
static int create_temporary(temporary_file *t, const char *path, int nameless) {
    if (!nameless) return name_temporary(t, path);
    char *directory = directory_of(path);
    if (!directory) return ENOMEM;
    t->file = open(directory, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
    int cause = t->file < 0 ? errno : 0;
    free(directory);
    return cause;
}

/* Writes all bytes to the temporary file and syncs them to the disk. */
static int fill_temporary(const temporary_file *t, const output *o) {
    int cause = write_all(t->file, o->data, o->size);
    /* The new file gets the permissions of the old one as far as the system allows. */
    if (!cause && o->old && fchmod(t->file, o->old->st_mode & 0777) && errno != EPERM)
        cause = errno;
    if (!cause && fsync(t->file) && errno != EINVAL && errno != EROFS) cause = errno;
    return cause;
}

/* Gives a named temporary file its final name without ever replacing another file. On file systems
 * without hard links, creating path exclusively reserves the name before the rename. */
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

/* Gives the temporary file its final name. */
static int publish_temporary(temporary_file *t, const char *path, int overwrite) {
    if (!t->name) {
        int cause = link_nameless(t->file, path);
        if (cause != EEXIST || !overwrite) return cause;
        cause = name_temporary(t, path);
        if (cause) return cause;
    }
    if (!overwrite) return publish_new(t->name, path);
    return rename(t->name, path) ? errno : 0;
}

/* Syncs the directory, so that the new name survives a power cut. Errors are ignored: not every
 * file system can do this, and the file is whole either way. */
static void sync_directory(const char *path) {
    char *directory = directory_of(path);
    int file = directory ? open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (file >= 0) {
        fsync(file);
        close(file);
    }
    free(directory);
}

/* Writes through a temporary file beside the target. Stores in *what which step failed. */
static int write_beside(const output *o, int nameless, const char **what) {
    temporary_file t = {-1, NULL};
    *what = "cannot be created";
    int cause = create_temporary(&t, o->path, nameless);
    if (cause) return cause;
    *what = "cannot be written";
    cause = fill_temporary(&t, o);
    if (!cause) {
        *what = "cannot be put in place";
        cause = publish_temporary(&t, o->path, o->overwrite);
    }
    close(t.file); /* fsync has reported all write errors already */
    if (cause && t.name) unlink(t.name);
    free(t.name);
    if (!cause) sync_directory(o->path);
    return cause;
}

/* Blocks the signals that end a process from outside, and stores the former mask. */
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
    /* Whether nameless files work is found by trying, since failures have many different errors. */
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
    /* Of a symbolic link the target is replaced, not the link itself. */
    char *target = realpath(path, NULL);
    psplat_result result = write_file(target ? target : path, data, size, overwrite, error);
    free(target);
    return result;
}
