/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command.c - exit codes, the error line, and the check of an output before the work begins.
 */
#define _XOPEN_SOURCE 700

#include "command.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char psplat_exit_help[] =
    "exit codes:\n"
    "  0  success\n"
    "  1  the command line is wrong\n"
    "  2  an input cannot be opened or read\n"
    "  3  an input is malformed, has a value out of range, or holds nothing to work on\n"
    "  4  an input is of a kind that is not supported\n"
    "  5  the output exists already or cannot be written\n"
    "  6  no usable graphics context\n"
    "  7  out of memory\n"
    "  8  interrupted by a signal; nothing was written\n";

static const int codes[PSPLAT_RESULT_COUNT] = {
    [PSPLAT_OK] = PSPLAT_EXIT_SUCCESS,
    [PSPLAT_ERROR_ARGUMENT] = PSPLAT_EXIT_USAGE,
    [PSPLAT_ERROR_MEMORY] = PSPLAT_EXIT_MEMORY,
    [PSPLAT_ERROR_READ] = PSPLAT_EXIT_READ,
    [PSPLAT_ERROR_WRITE] = PSPLAT_EXIT_WRITE,
    [PSPLAT_ERROR_FORMAT] = PSPLAT_EXIT_INVALID,
    [PSPLAT_ERROR_RANGE] = PSPLAT_EXIT_INVALID,
    [PSPLAT_ERROR_UNSUPPORTED] = PSPLAT_EXIT_UNSUPPORTED,
    [PSPLAT_ERROR_NO_SPLATS] = PSPLAT_EXIT_INVALID,
    [PSPLAT_ERROR_RESCALED] = PSPLAT_EXIT_INVALID,
    [PSPLAT_ERROR_GRAPHICS] = PSPLAT_EXIT_GRAPHICS,
    [PSPLAT_ERROR_INTERRUPTED] = PSPLAT_EXIT_INTERRUPTED,
};

int psplat_exit_code(psplat_result result) {
    return (unsigned)result < PSPLAT_RESULT_COUNT ? codes[result] : PSPLAT_EXIT_USAGE;
}

/* Texts of the mesh readers begin with the file and the line already; those of the runtime, which
 * knows only bytes, do not. */
int psplat_command_fail(const char *path, const psplat_error *error) {
    const char *text = *error->text ? error->text : psplat_result_text(error->code);
    size_t length = path ? strlen(path) : 0;
    int is_named = !path || (!strncmp(text, path, length) && !strncmp(text + length, ": ", 2));
    if (is_named)
        fprintf(stderr, "phongsplat: %s\n", text);
    else if (error->offset)
        fprintf(stderr, "phongsplat: %s: byte %zu: %s\n", path, error->offset, text);
    else
        fprintf(stderr, "phongsplat: %s: %s\n", path, text);
    return psplat_exit_code(error->code);
}

static int is_same_file(const char *first, const char *second) {
    struct stat a, b;
    return !stat(first, &a) && !stat(second, &b) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/* Whether a file can be created where path says; 0 or an errno. */
static int check_directory(const char *path) {
    const char *slash = strrchr(path, '/');
    char *directory = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    if (!directory) return ENOMEM;
    struct stat status;
    int cause = stat(directory, &status) ? errno : 0;
    if (!cause && !S_ISDIR(status.st_mode)) cause = ENOTDIR;
    if (!cause && access(directory, W_OK | X_OK)) cause = errno;
    free(directory);
    return cause;
}

psplat_result psplat_output_check(const char *input, const char *output, int overwrite,
                                  psplat_error *error) {
    struct stat status;
    if (!strcmp(output, "-")) return PSPLAT_OK;
    if (input && is_same_file(input, output))
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%.160s: is the input", output);
    int exists = !stat(output, &status);
    if (exists && S_ISDIR(status.st_mode))
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%.160s: is a directory", output);
    if (exists && !overwrite)
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0,
                           "%.160s: exists already; --overwrite replaces it", output);
    if (exists && !S_ISREG(status.st_mode)) return PSPLAT_OK; /* written in place */
    int cause = check_directory(output);
    if (!cause) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%.160s: cannot be created: %s", output,
                       strerror(cause));
}
