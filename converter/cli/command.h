/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command.h - the commands of the command line, and what they share: exit codes, error lines, and
 * checks of files.
 */
#ifndef PHONGSPLAT_CLI_COMMAND_H
#define PHONGSPLAT_CLI_COMMAND_H

#include <phongsplat/splat.h>
#include <phongsplat/phongsplat.h>

typedef enum psplat_exit {
    PSPLAT_EXIT_SUCCESS = 0,
    PSPLAT_EXIT_USAGE = 1,       /* the command line is wrong */
    PSPLAT_EXIT_READ = 2,        /* an input cannot be opened or read */
    PSPLAT_EXIT_INVALID = 3,     /* an input is malformed, out of range or holds no surface */
    PSPLAT_EXIT_UNSUPPORTED = 4, /* an input is well-formed but of no supported kind */
    PSPLAT_EXIT_WRITE = 5,       /* the output exists or cannot be written */
    PSPLAT_EXIT_GRAPHICS = 6,    /* no usable graphics context, or no viewer */
    PSPLAT_EXIT_MEMORY = 7,      /* out of memory */
    PSPLAT_EXIT_INTERRUPTED = 8, /* stopped by a signal */
    PSPLAT_EXIT_BROKEN = 9,      /* the output is written, but a promise is broken in places */
    PSPLAT_EXIT_BUDGET = 10      /* no conversion fits the budget */
} psplat_exit;

/* The list of exit codes that closes every --help. */
extern const char psplat_exit_help[];

/* Returns the exit code for a result of the library. */
int psplat_exit_code(psplat_result result);

/* Prints one error line; control characters become question marks. */
void psplat_command_error(const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 1, 2)))
#endif
    ;

/* Prints the error line of a failure that concerns path and returns its exit code. path is NULL
 * where the error's text names what it concerns. */
int psplat_command_fail(const char *path, const psplat_error *error);

/* Opens an asset by psplat_asset_open; unlike that, the error says why a file cannot be read. */
psplat_result psplat_command_open(const char *path, const psplat_asset_desc *desc,
                                  psplat_asset **asset, psplat_error *error);

/* Checks an output before any work is done for it. Refuses (WRITE) a file that exists unless
 * overwrite is set, that is the input (which may be NULL), that is a directory, or whose directory
 * cannot be written. "-", standard output, is always accepted. */
psplat_result psplat_output_check(const char *input, const char *output, int overwrite,
                                  psplat_error *error);

/* Returns whether two output paths name the same file. */
int psplat_output_is_same(const char *first, const char *second);

/* Stores the path of this program, whatever it is called, with symbolic links resolved. Returns 0
 * where the system does not tell it or it is longer than size - 1 bytes. */
int psplat_program_path(char *path, size_t size);

/* Stores the directory of this program with a slash at its end. Returns 0 where the system does not
 * tell it or it is longer than size - 1 bytes. */
int psplat_program_directory(char *path, size_t size);

/* The commands: argv[0] is the name of the command. They return the exit code. */
int psplat_command_convert(int argc, char **argv);

int psplat_command_render(int argc, char **argv);

int psplat_command_inspect(int argc, char **argv);

int psplat_command_validate(int argc, char **argv);

int psplat_command_compare(int argc, char **argv);

int psplat_command_tile(int argc, char **argv);

/* What `tile` calls if its first operand is their name. */
int psplat_command_tile_plan(int argc, char **argv);

int psplat_command_tile_node(int argc, char **argv);

int psplat_command_tile_merge(int argc, char **argv);

int psplat_command_tradeoff(int argc, char **argv);

int psplat_command_view(int argc, char **argv);

#endif
