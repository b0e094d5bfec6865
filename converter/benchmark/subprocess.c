/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * subprocess.c - other programs: run, waited for, their first line read.
 */
#define _XOPEN_SOURCE 700

#include "benchmark/subprocess.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* Reads to the end, so that the program never meets a closed pipe, and keeps the first line. */
static void read_line(int file, char *line, size_t size) {
    char block[512];
    size_t used = 0;
    int is_first = size > 1;
    for (;;) {
        ssize_t got = read(file, block, sizeof block);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) break;
        for (ssize_t i = 0; i < got && is_first; ++i) {
            is_first = block[i] != '\n' && used + 1 < size;
            if (is_first) line[used++] = block[i];
        }
    }
    if (size) line[used] = 0;
}

static int wait_for(pid_t process) {
    int status = 0;
    while (waitpid(process, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* posix_spawn takes arguments that it does not change as char *const *. */
static int start(const char *const *arguments, int output, pid_t *process) {
    posix_spawn_file_actions_t actions;
    char *const *words;
    memcpy(&words, &arguments, sizeof words);
    if (posix_spawn_file_actions_init(&actions)) return ENOMEM;
    int cause = posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (!cause) cause = posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    if (!cause) cause = posix_spawn_file_actions_adddup2(&actions, output, STDERR_FILENO);
    if (!cause) cause = posix_spawnp(process, words[0], &actions, NULL, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    return cause;
}

int psplat_subprocess_run(const char *const *arguments, char *line, size_t size) {
    int ends[2];
    pid_t process = 0;
    if (size) *line = 0;
    if (pipe(ends)) return -1;
    for (int i = 0; i < 2; ++i) fcntl(ends[i], F_SETFD, FD_CLOEXEC);
    int cause = start(arguments, ends[1], &process);
    close(ends[1]);
    if (!cause) read_line(ends[0], line, size);
    close(ends[0]);
    int code = cause ? -1 : wait_for(process);
    /* Some systems find only in the child that there is no such program, which then ends so. */
    return code == 127 ? -1 : code;
}
