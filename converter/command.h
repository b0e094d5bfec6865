/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command.h - the command line: what its commands share. One command = one file command_<name>.c;
 * main.c chooses the command. Only these files print and decide exit codes.
 *
 * Data goes to standard output, everything else to standard error. An error is exactly one line:
 *
 *     phongsplat: <file>: <place>: <cause>
 */
#ifndef PHONGSPLAT_COMMAND_H
#define PHONGSPLAT_COMMAND_H

#include "converter.h"
#include "picture.h"

#include <phongsplat/phongsplat.h>

/* ---- command.c: exit codes, errors, checks ------------------------------------------------ */

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
    PSPLAT_EXIT_BROKEN = 9,      /* the output is written, but not all that was asked for is kept */
    PSPLAT_EXIT_BUDGET = 10      /* no conversion fits the budget */
} psplat_exit;

/* The list of exit codes that closes every --help. */
extern const char psplat_exit_help[];

int psplat_exit_code(psplat_result result);

/* Prints one error line, whatever control characters its parts hold. */
void psplat_command_error(const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 1, 2)))
#endif
    ;

/* Prints the error line of a failure that concerns path (NULL where the text names its subject)
 * and returns its exit code. */
int psplat_command_fail(const char *path, const psplat_error *error);

/* psplat_asset_open that says why a file cannot be read. */
psplat_result psplat_command_open(const char *path, const psplat_asset_desc *desc,
                                  psplat_asset **asset, psplat_error *error);

/* Refuses an output before any work is done for it: one that exists without overwrite, is the
 * input, is a directory or lies in a directory that cannot be written. "-" is always accepted. */
psplat_result psplat_output_check(const char *input, const char *output, int overwrite,
                                  psplat_error *error);

/* Whether two outputs would be one file. */
int psplat_output_is_same(const char *first, const char *second);

/* ---- command_options.c: table-driven parsing ---------------------------------------------- */

typedef enum psplat_option_kind {
    PSPLAT_OPTION_FLAG,     /* int, set to 1 */
    PSPLAT_OPTION_TEXT,     /* const char * into argv */
    PSPLAT_OPTION_NUMBER,   /* double in min ... max */
    PSPLAT_OPTION_PERCENT,  /* the same; a % sign may follow */
    PSPLAT_OPTION_COUNT,    /* int in min ... max */
    PSPLAT_OPTION_UNSIGNED, /* uint64_t */
    PSPLAT_OPTION_SIZE,     /* int[2], WIDTHxHEIGHT, each in min ... max */
    PSPLAT_OPTION_CHOICE,   /* int, index into choices */
    PSPLAT_OPTION_COLOR     /* float[4], sRGB-encoded 0 ... 1; RRGGBB, R,G,B or transparent */
} psplat_option_kind;

typedef struct psplat_option {
    char letter; /* 0: long name only */
    const char *name;
    psplat_option_kind kind;
    void *value;             /* untouched where the option is absent */
    const char *placeholder; /* of the value in --help; NULL for flags */
    const char *help;        /* lines separated by \n */
    double min, max;         /* inclusive */
    const char *const *choices;
} psplat_option;

/* What a command accepts. Operands fill, in order, the slots that options have left NULL; each
 * slot must be filled in the end. */
typedef struct psplat_syntax {
    const char *command;
    const char *operands; /* as --help shows them: "IN OUT.glb" */
    const char *summary;
    const char *notes; /* paragraph after the options; may be NULL */
    const psplat_option *options;
    size_t option_count;
    const char **const *slots;
    size_t slot_count;
} psplat_syntax;

typedef enum psplat_parse {
    PSPLAT_PARSE_OK,
    PSPLAT_PARSE_HELP, /* --help was asked for and printed */
    PSPLAT_PARSE_ERROR /* the error line was printed */
} psplat_parse;

/* argv holds argc arguments after the command's name. */
psplat_parse psplat_options_parse(const psplat_syntax *syntax, int argc, char **argv);

/* Parses one value of an option; on failure stores what was expected in expected. Returns 1 when
 * the text is valid. */
int psplat_option_read(const psplat_option *option, const char *text, const char **expected);

void psplat_options_help(const psplat_syntax *syntax);

/* ---- the commands: arguments after the command's name; return a psplat_exit ---------------- */

int psplat_command_convert(int argc, char **argv);
int psplat_command_render(int argc, char **argv);
int psplat_command_inspect(int argc, char **argv);
int psplat_command_validate(int argc, char **argv);
int psplat_command_compare(int argc, char **argv);
int psplat_command_tradeoff(int argc, char **argv);
int psplat_command_view(int argc, char **argv);

/* ---- progress.c --------------------------------------------------------------------------- */

/* A line on standard error that shows how much is done, the stage, and the time that is left, where
 * that is a terminal. */
typedef struct psplat_progress {
    int enabled;
    double start, updated; /* seconds of a monotonic clock */
    double done;           /* 0 ... 1, never falling */
    double left;           /* seconds, smoothed; negative: not known yet */
    char shown[96];
} psplat_progress;

psplat_progress psplat_progress_begin(int quiet);
/* What the line says `now`, in progress->shown; 1 where it has changed. */
int psplat_progress_update(psplat_progress *progress, double now, const char *stage,
                           double fraction);
/* For psplat_convert_desc; user is the psplat_progress. Never asks to stop: a signal ends the
 * process at once, since nothing unfinished is ever on disk (output.c). */
int psplat_progress_show(void *user, const char *stage, double fraction);
/* The same for work other than a conversion, of which done is the part that is done. */
int psplat_progress_advance(psplat_progress *progress, double now, const char *what, double done);
int psplat_progress_show_done(void *user, const char *what, double done);
void psplat_progress_end(psplat_progress *progress); /* clears the line */

#endif
