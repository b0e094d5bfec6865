/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command.c - exit codes, the error line, and the checks of files before the work begins.
 */
#define _XOPEN_SOURCE 700

#include "cli/command.h"

#include "base/path.h"

#include <phongsplat/phongsplat.h>

#include <errno.h>
#include <stdarg.h>
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
    "  6  no usable graphics context, or no viewer is installed\n"
    "  7  out of memory\n"
    "  8  interrupted by a signal; no output was written in part\n"
    "  9  the output was written, but a promise of the conversion is broken in places\n"
    " 10  no conversion fits the budget\n";

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

void psplat_command_error(const char *format, ...) {
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    for (char *c = line; *c; ++c)
        if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    fprintf(stderr, "phongsplat: %s\n", line);
}

/* Error texts of the mesh readers begin with the file and the line. Those of the runtime, which
 * knows only bytes, do not, so the file is put before them. */
int psplat_command_fail(const char *path, const psplat_error *error) {
    const char *text = *error->text ? error->text : psplat_result_text(error->code);
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path ? path : "", shown);
    size_t length = strlen(shown);
    int is_named = !path || (!strncmp(text, shown, length) && !strncmp(text + length, ": ", 2));
    if (is_named)
        psplat_command_error("%s", text);
    else if (error->offset)
        psplat_command_error("%s: byte %zu: %s", shown, error->offset, text);
    else
        psplat_command_error("%s: %s", shown, text);
    return psplat_exit_code(error->code);
}

/* Returns 0 or the errno of a file that cannot be read. The runtime reads through callbacks, which
 * cannot tell it. */
static int check_input(const char *path) {
    struct stat status;
    if (stat(path, &status) || access(path, R_OK)) return errno;
    return S_ISDIR(status.st_mode) ? EISDIR : 0;
}

psplat_result psplat_command_open(const char *path, const psplat_asset_desc *desc,
                                  psplat_asset **asset, psplat_error *error) {
    int cause = check_input(path);
    if (cause) return psplat_fail(error, PSPLAT_ERROR_READ, 0, "%s", strerror(cause));
    return psplat_asset_open(path, desc, asset, error);
}

static psplat_result refuse(psplat_error *error, const char *path, const char *cause) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(path, shown);
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s: %s", shown, cause);
}

static psplat_result refuse_creation(psplat_error *error, const char *path, int cause) {
    char text[128];
    snprintf(text, sizeof text, "cannot be created: %s", strerror(cause));
    return refuse(error, path, text);
}

static int is_same_file(const char *first, const char *second) {
    struct stat a, b;
    return !stat(first, &a) && !stat(second, &b) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/* Returns the directory part of path, which the caller frees, or NULL where memory ran out. */
static char *directory_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
}

static const char *base_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int psplat_output_is_same(const char *first, const char *second) {
    struct stat status;
    if (!stat(first, &status)) return S_ISREG(status.st_mode) && is_same_file(first, second);
    char *a = directory_of(first), *b = directory_of(second);
    int is_same = a && b && is_same_file(a, b) && !strcmp(base_of(first), base_of(second));
    free(a);
    free(b);
    return is_same || !strcmp(first, second);
}

/* Returns 0 if a file can be created at path, or else an errno. */
static int check_directory(const char *path) {
    char *directory = directory_of(path);
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
    if (input && is_same_file(input, output)) return refuse(error, output, "is the input");
    int cause = stat(output, &status) ? errno : 0;
    if (!cause && S_ISDIR(status.st_mode)) return refuse(error, output, "is a directory");
    if (!cause && !overwrite)
        return refuse(error, output, "exists already; --overwrite replaces it");
    if (!cause && !S_ISREG(status.st_mode)) return PSPLAT_OK; /* written in place */
    if (cause && cause != ENOENT) return refuse_creation(error, output, cause);
    if (cause && !lstat(output, &status))
        return refuse(error, output, "is a symbolic link to nothing");
    cause = check_directory(output);
    return cause ? refuse_creation(error, output, cause) : PSPLAT_OK;
}

int psplat_program_path(char *path, size_t size) {
    ssize_t length = readlink("/proc/self/exe", path, size);
    if (length <= 0 || (size_t)length == size) return 0;
    path[length] = 0;
    return 1;
}

int psplat_program_directory(char *path, size_t size) {
    if (!psplat_program_path(path, size)) return 0;
    char *slash = strrchr(path, '/');
    if (slash) slash[1] = 0;
    return slash != NULL;
}
