/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_view.c - phongsplat view: hands over to phongsplat-viewer, a program of its own, so that
 * the command line needs no window system.
 */
#define _XOPEN_SOURCE 700

#include "command.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The program of this name in the directory of this one, where the system tells it: builds and
 * installations have the two side by side. Returns where there is none. */
static void execute_beside(const char *name, char **arguments) {
    char path[4096];
    ssize_t length = readlink("/proc/self/exe", path, sizeof path);
    while (length > 0 && path[length - 1] != '/') --length;
    if (length <= 0 || (size_t)length + strlen(name) >= sizeof path) return;
    strcpy(path + length, name);
    execv(path, arguments);
}

/* The viewer parses the arguments: --help is its help. */
int psplat_command_view(int argc, char **argv) {
    char name[] = "phongsplat-viewer", **arguments = calloc((size_t)argc + 2, sizeof *arguments);
    if (!arguments) {
        psplat_command_error("out of memory");
        return PSPLAT_EXIT_MEMORY;
    }
    arguments[0] = name;
    for (int i = 0; i < argc; ++i) arguments[i + 1] = argv[i];
    /* What main.c ignores would stay ignored. */
    signal(SIGPIPE, SIG_DFL);
    signal(SIGXFSZ, SIG_DFL);
    execute_beside(name, arguments);
    execvp(name, arguments);
    psplat_command_error("%s: %s (it is built where GLFW is found)", name,
                         errno == ENOENT ? "not found beside phongsplat or in PATH"
                                         : strerror(errno));
    free(arguments);
    return PSPLAT_EXIT_GRAPHICS;
}
