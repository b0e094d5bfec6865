/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * butteraugli.c - asks butteraugli_main (of libjxl, in Debian's libjxl-devtools) how different two
 * pictures look. Of the two numbers that it prints, the greatest value of its map of differences
 * and a mean that weighs great values more ("3-norm"), the second one is taken: the first is that
 * of a few pixels at outlines.
 *
 * The pictures are handed over in temporary files that have no name any more when the program
 * starts: it opens them again as /dev/fd/N. So nothing is left behind, whatever happens.
 */
#define _POSIX_C_SOURCE 200809L

#include "butteraugli.h"

#include "picture.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define PROGRAM "butteraugli_main"

extern char **environ;

enum { MOST_PATH = 4096 };

/* ---- the program ------------------------------------------------------------------------------
 */

/* 0: it is not in PATH. */
static int find_program(char path[MOST_PATH]) {
    const char *next = getenv("PATH");
    while (next && *next) {
        size_t length = strcspn(next, ":");
        int size = snprintf(path, MOST_PATH, "%.*s/" PROGRAM, (int)length, next);
        if (length && size < MOST_PATH && access(path, X_OK) == 0) return 1;
        next += length + (next[length] == ':');
    }
    return 0;
}

/* ---- files ------------------------------------------------------------------------------------
 */

static int write_all(int file, const uint8_t *data, size_t size) {
    while (size) {
        ssize_t written = write(file, data, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return 0;
        data += written;
        size -= (size_t)written;
    }
    return lseek(file, 0, SEEK_SET) == 0;
}

/* A file without a name that programs started from here do not get by themselves; -1: none. */
static int open_temporary(void) {
    const char *directory = getenv("TMPDIR");
    char path[MOST_PATH];
    int size = snprintf(path, sizeof path, "%s/psplat-XXXXXX",
                        directory && *directory ? directory : "/tmp");
    errno = ENAMETOOLONG;
    int file = size < MOST_PATH ? mkstemp(path) : -1;
    if (file < 0) return -1;
    unlink(path);
    fcntl(file, F_SETFD, FD_CLOEXEC);
    return file;
}

static psplat_result store(const psplat_picture_pair *pair, int index, int *file,
                           psplat_error *error) {
    uint8_t *png = NULL;
    size_t size = 0;
    psplat_result result =
        psplat_png_encode(pair->pixels[index], pair->width, pair->height, 3, &png, &size, error);
    if (result) return result;
    *file = open_temporary();
    if (*file < 0 || !write_all(*file, png, size))
        result =
            psplat_fail(error, PSPLAT_ERROR_WRITE, 0,
                        "a temporary file for " PROGRAM " cannot be written: %s", strerror(errno));
    free(png);
    return result;
}

/* ---- running it --------------------------------------------------------------------------------
 */

typedef struct job {
    char program[MOST_PATH];
    int files[2];
    int ends[2];      /* of a pipe */
    char output[256]; /* what the program printed, cut off */
} job;

static int start(job *j, pid_t *child) {
    char names[2][32];
    for (int i = 0; i < 2; ++i) snprintf(names[i], sizeof names[i], "/dev/fd/%d", j->files[i]);
    char *arguments[] = {j->program, names[0], names[1], NULL};
    posix_spawn_file_actions_t actions;
    if (posix_spawn_file_actions_init(&actions)) return 0;
    int failed =
        posix_spawn_file_actions_adddup2(&actions, j->ends[1], STDOUT_FILENO) ||
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    /* Onto itself: kept open. */
    for (int i = 0; i < 2 && !failed; ++i)
        failed = posix_spawn_file_actions_adddup2(&actions, j->files[i], j->files[i]);
    if (!failed) failed = posix_spawn(child, j->program, &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    return !failed;
}

/* Until the other end is closed. */
static void read_output(job *j) {
    char scrap[256];
    size_t size = 0;
    for (;;) {
        size_t room = sizeof j->output - 1 - size;
        ssize_t count =
            read(j->ends[0], room ? j->output + size : scrap, room ? room : sizeof scrap);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) break;
        if (room) size += (size_t)count;
    }
    j->output[size] = 0;
}

/* 0: it did not end well. */
static int run(job *j) {
    pid_t child = 0;
    int status = 0;
    if (pipe(j->ends)) return 0;
    for (int i = 0; i < 2; ++i) fcntl(j->ends[i], F_SETFD, FD_CLOEXEC);
    int started = start(j, &child);
    close(j->ends[1]);
    if (started) {
        read_output(j);
        while (waitpid(child, &status, 0) < 0)
            if (errno != EINTR) {
                started = 0;
                break;
            }
    }
    close(j->ends[0]);
    return started && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/* "3-norm: 12.345678", whatever the locale's decimal point. */
static int read_norm(const char *text, double *norm) {
    static const char label[] = "3-norm: ";
    const char *c = strstr(text, label);
    if (!c) return 0;
    c += sizeof label - 1;
    if (*c < '0' || *c > '9') return 0;
    double value = 0, unit = 1;
    for (; *c >= '0' && *c <= '9'; ++c) value = 10 * value + (*c - '0');
    if (*c == '.')
        for (++c; *c >= '0' && *c <= '9'; ++c) value += (unit /= 10) * (*c - '0');
    *norm = value;
    return 1;
}

psplat_result psplat_butteraugli_measure(const psplat_picture_pair *pair, double *distance,
                                         psplat_error *error) {
    job j = {.files = {-1, -1}};
    psplat_result result = PSPLAT_OK;
    *distance = -1;
    if (!find_program(j.program)) return PSPLAT_OK;
    for (int i = 0; i < 2 && !result; ++i) result = store(pair, i, &j.files[i], error);
    if (!result && (!run(&j) || !read_norm(j.output, distance)))
        result = psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s fails on two pictures of %d x %d",
                             PROGRAM, pair->width, pair->height);
    for (int i = 0; i < 2; ++i)
        if (j.files[i] >= 0) close(j.files[i]);
    return result;
}
