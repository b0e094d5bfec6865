/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * output.c - atomic file output: files are written whole or not at all.
 *
 * The bytes of a file go to a temporary file in the directory of the target, which is synced and
 * then gets the target's name in one step. rename() does this where the target may be replaced, and
 * link() where it must not exist: link() fails if another process was faster, while rename() would
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

#include <assert.h>
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

typedef struct temporary_file {
    int file;   /* -1: none */
    char *name; /* malloc'ed, or NULL while the file has no name */
} temporary_file;

/* A file to be written. */
typedef struct output {
    const char *path;
    char *target; /* where symbolic links lead, malloc'ed, or NULL where there is no file yet */
    const void *data;
    size_t size;
    int overwrite, exists, is_in_place;
    struct stat old; /* of the file that is replaced, if it exists */
    temporary_file temporary;
} output;

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
    if (!cause && o->exists && fchmod(t->file, o->old.st_mode & 0777) && errno != EPERM)
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

/* Closes the temporary file, which vanishes unless it has got its final name. */
static void discard(temporary_file *t) {
    if (t->file >= 0) close(t->file); /* fsync has reported all write errors already */
    if (t->name) unlink(t->name);
    free(t->name);
    *t = (temporary_file){-1, NULL};
}

/* Writes the temporary file beside the target. Stores in *what which step failed. */
static int stage(output *o, int nameless, const char **what) {
    *what = "cannot be created";
    int cause = create_temporary(&o->temporary, o->path, nameless);
    if (cause) return cause;
    *what = "cannot be written";
    cause = fill_temporary(&o->temporary, o);
    if (cause) discard(&o->temporary);
    return cause;
}

/* Gives the file its final name. Whether nameless files can get one is found by trying, since
 * failures have many different errors; where they cannot, a named one is written. */
static int publish(output *o, const char **what) {
    int was_nameless = !o->temporary.name;
    *what = "cannot be put in place";
    int cause = publish_temporary(&o->temporary, o->path, o->overwrite);
    if (cause && cause != EEXIST && was_nameless) {
        discard(&o->temporary);
        cause = stage(o, 0, what);
        if (cause) return cause;
        *what = "cannot be put in place";
        cause = publish_temporary(&o->temporary, o->path, o->overwrite);
    }
    if (!cause) {
        free(o->temporary.name); /* it is the file's no more */
        o->temporary.name = NULL;
        sync_directory(o->path);
    }
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

/* ---- several files --------------------------------------------------------------------------- */

static psplat_result fail_output(psplat_error *error, const output *o, const char *what,
                                 int cause) {
    return cause == EEXIST ? fail_existing(error, o->path) : fail(error, o->path, what, cause);
}

/* Looks where a file goes, and whether it may. */
static psplat_result begin(const psplat_output_file *file, int overwrite, output *o,
                           psplat_error *error) {
    *o = (output){.path = file->path,
                  .data = file->data,
                  .size = file->size,
                  .overwrite = overwrite,
                  .temporary = {-1, NULL}};
    if (!o->path || !*o->path || (!o->data && o->size))
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "no path or no data to write");
    o->is_in_place = !strcmp(o->path, "-");
    if (o->is_in_place) return PSPLAT_OK;
    /* Of a symbolic link the target is replaced, not the link itself. */
    o->target = realpath(o->path, NULL);
    if (o->target) o->path = o->target;
    o->exists = !stat(o->path, &o->old);
    if (o->exists && S_ISDIR(o->old.st_mode))
        return fail(error, o->path, "cannot be written", EISDIR);
    if (o->exists && !overwrite) return fail_existing(error, o->path);
    o->is_in_place = o->exists && !S_ISREG(o->old.st_mode);
    return PSPLAT_OK;
}

static psplat_result write_here(const output *o, psplat_error *error) {
    if (strcmp(o->path, "-") != 0) return write_in_place(o->path, o->data, o->size, error);
    int cause = write_all(STDOUT_FILENO, o->data, o->size);
    return cause ? fail(error, "standard output", "cannot be written", cause) : PSPLAT_OK;
}

/* Writes the files that are not in place: the temporary ones of all, then the name of each. */
static psplat_result write_beside(output *list, size_t count, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    const char *what = NULL;
    size_t published = 0;
    for (size_t i = 0; i < count && !result; ++i) {
        int cause = list[i].is_in_place ? 0 : stage(&list[i], 1, &what);
        if (cause) cause = stage(&list[i], 0, &what);
        if (cause) result = fail_output(error, &list[i], what, cause);
    }
    for (; published < count && !result; ++published) {
        output *o = &list[published];
        int cause = o->is_in_place ? 0 : publish(o, &what);
        if (cause) result = fail_output(error, o, what, cause);
    }
    /* The last of those that were tried has no name; those before it are taken back. */
    for (size_t i = 0; result && i + 1 < published; ++i)
        if (!list[i].is_in_place && !list[i].exists) unlink(list[i].path);
    for (size_t i = 0; i < count; ++i) discard(&list[i].temporary);
    return result;
}

psplat_result psplat_output_write_all(const psplat_output_file *files, size_t count, int overwrite,
                                      psplat_error *error) {
    output list[PSPLAT_MOST_OUTPUTS];
    psplat_result result = PSPLAT_OK;
    size_t begun = 0;
    assert(count <= PSPLAT_MOST_OUTPUTS);
    while (begun < count && !result) {
        result = begin(&files[begun], overwrite, &list[begun], error);
        ++begun;
    }
    for (size_t i = 0; i < count && !result; ++i)
        if (list[i].is_in_place) result = write_here(&list[i], error);
    if (!result) {
        sigset_t before;
        hold_signals(&before);
        result = write_beside(list, count, error);
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    }
    for (size_t i = 0; i < begun; ++i) free(list[i].target);
    return result;
}

psplat_result psplat_output_write(const char *path, const void *data, size_t size, int overwrite,
                                  psplat_error *error) {
    const psplat_output_file file = {path, data, size};
    return psplat_output_write_all(&file, 1, overwrite, error);
}
