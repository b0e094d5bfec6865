/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_view.c - phongsplat view: starts phongsplat-viewer, which is a separate program so that
 * the command line does not depend on a window system.
 */
#define _XOPEN_SOURCE 700

#include "cli/command.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

/* Executes the program of this name in the directory of this one, since builds and installations
 * have both side by side. Returns where there is no such program or the system does not tell the
 * directory. */
static void execute_beside(const char *name, char **arguments) {
    char path[4096];
    if (!psplat_program_directory(path, sizeof path)) return;
    size_t length = strlen(path);
    if (length + strlen(name) >= sizeof path) return;
    strcpy(path + length, name);
    execv(path, arguments);
}

/* Passes all arguments to the viewer, --help as well. */
int psplat_command_view(int argc, char **argv) {
    static char name[] = "phongsplat-viewer";
    (void)argc; /* argv ends with NULL */
    argv[0] = name;
    /* The signals that main.c ignores would be ignored in the viewer as well. */
    signal(SIGPIPE, SIG_DFL);
    signal(SIGXFSZ, SIG_DFL);
    execute_beside(name, argv);
    execvp(name, argv);
    psplat_command_error("%s: %s (it is built where GLFW is found)", name,
                         errno == ENOENT ? "not found beside phongsplat or in PATH"
                                         : strerror(errno));
    return PSPLAT_EXIT_GRAPHICS;
}
