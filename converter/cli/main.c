/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * main.c - the entry point of phongsplat: sets up signals and streams and runs the command.
 */
#define _XOPEN_SOURCE 700

#include "cli/command.h"

#include <phongsplat/phongsplat.h>

#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/auxv.h>
#endif

typedef struct command {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
    int has_threads; /* whether it computes for long in several threads */
} command;

static const command commands[] = {
    {"convert", psplat_command_convert, "a mesh becomes Phong splats in a GLB", 1},
    {"render", psplat_command_render, "an asset, or a mesh, becomes a PNG", 0},
    {"inspect", psplat_command_inspect, "what an asset holds", 0},
    {"validate", psplat_command_validate, "whether an asset keeps the rules", 0},
    {"tile", psplat_command_tile, "a mesh becomes a tileset of 3D Tiles, in levels of detail", 1},
    {"compare", psplat_command_compare, "how far an asset is from its mesh", 1},
    {"tradeoff", psplat_command_tradeoff, "what settings cost and buy on a mesh, measured", 1},
    {"view", psplat_command_view, "assets are shown in a window", 0},
};

enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static void print_help(void) {
    printf("usage: phongsplat COMMAND [options] ...\n\n");
    for (int i = 0; i < COMMAND_COUNT; ++i)
        printf("  %-10s %s\n", commands[i].name, commands[i].summary);
    printf(
        "\nphongsplat COMMAND --help lists a command's options, phongsplat --version prints the\n"
        "version.\n\n%s",
        psplat_exit_help);
}

/* Ends the process at once, which is safe since unfinished files are never visible (output.c). A
 * second signal, as timeout(1) sends to the process and then to its group, may reach another
 * thread meanwhile, which leaves the line and the end to the first. */
static void on_signal(int number) {
    static const char line[] = "phongsplat: interrupted\n";
    static atomic_flag is_ending = ATOMIC_FLAG_INIT;
    (void)number;
    if (atomic_flag_test_and_set(&is_ending)) return;
    if (isatty(STDERR_FILENO) && write(STDERR_FILENO, "\r\033[K", 4) < 0)
        _exit(PSPLAT_EXIT_INTERRUPTED);
    ssize_t written = write(STDERR_FILENO, line, sizeof line - 1);
    (void)written;
    _exit(PSPLAT_EXIT_INTERRUPTED);
}

/* Handles the signals that end a program; those that the parent ignores, as nohup does, stay
 * ignored. */
static void set_signals(void) {
    const int ending[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = on_signal}, before;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof ending / sizeof *ending; ++i)
        if (!sigaction(ending[i], NULL, &before) && before.sa_handler != SIG_IGN)
            sigaction(ending[i], &action, NULL);
    /* write() reports a closed pipe and a file that may not grow as errors. */
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

/* Opens /dev/null for reading in place of closed standard streams: otherwise the next file that is
 * opened would get the stream's number and its output. Writing to it fails, so that lost output is
 * noticed. */
static void hold_standard_streams(void) {
    int file = 0;
    while (file >= 0 && file <= STDERR_FILENO) file = open("/dev/null", O_RDONLY);
    if (file > STDERR_FILENO) close(file);
}

/* Returns whether a path names the program that runs: that may have been replaced, or be the
 * dynamic linker, which was called with the program as its argument and would take the command for
 * one. */
static int is_this_program(const char *path) {
    struct stat named, running;
#ifdef __linux__
    if (!getauxval(AT_BASE)) return 0;
#endif
    return !stat(path, &named) && !stat("/proc/self/exe", &running) &&
           named.st_dev == running.st_dev && named.st_ino == running.st_ino;
}

/* Starts the program anew with OMP_WAIT_POLICY=passive where the environment does not say how idle
 * threads wait. GNU's OpenMP lets them spin for milliseconds otherwise, which costs 6 % of a
 * conversion's CPU time, and twice as much where it takes it from something else that runs. The
 * library reads its environment before main, so setting it here would be too late. Where the
 * program cannot be found, as without /proc, threads spin. valgrind does not follow the new start
 * unless it is told to. */
static void let_idle_threads_sleep(char **argv) {
    char path[4096]; /* Linux's greatest length of paths */
    if (getenv("OMP_WAIT_POLICY") || getenv("GOMP_SPINCOUNT")) return;
    if (!psplat_program_path(path, sizeof path) || !is_this_program(path)) return;
    if (!setenv("OMP_WAIT_POLICY", "passive", 1)) execv(path, argv);
}

/* Flushes standard output, where printing may fail only now, and returns the exit code. */
static int close_output(int code) {
    if (!fflush(stdout) && !ferror(stdout)) return code;
    psplat_command_error("standard output: cannot be written");
    return code ? code : PSPLAT_EXIT_WRITE;
}

static int run(int argc, char **argv) {
    const char *name = argc > 1 ? argv[1] : "";
    for (int i = 0; i < COMMAND_COUNT; ++i)
        if (!strcmp(commands[i].name, name)) {
            if (commands[i].has_threads) let_idle_threads_sleep(argv);
            return commands[i].run(argc - 1, argv + 1);
        }
    if (!strcmp(name, "--version")) {
        printf("phongsplat %d.%d.%d\n", PSPLAT_VERSION_MAJOR, PSPLAT_VERSION_MINOR,
               PSPLAT_VERSION_PATCH);
        return PSPLAT_EXIT_SUCCESS;
    }
    if (!strcmp(name, "--help") || !strcmp(name, "-h")) {
        print_help();
        return PSPLAT_EXIT_SUCCESS;
    }
    psplat_command_error("%.160s: unknown command (phongsplat --help lists them)",
                         *name ? name : "no command");
    return PSPLAT_EXIT_USAGE;
}

int main(int argc, char **argv) {
    hold_standard_streams();
    set_signals();
    return close_output(run(argc, argv));
}
