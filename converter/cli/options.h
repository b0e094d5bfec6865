/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * options.h - the options of commands as tables, and their parser.
 */
#ifndef PHONGSPLAT_CLI_OPTIONS_H
#define PHONGSPLAT_CLI_OPTIONS_H

#include "cli/command.h"
#include "select/conversion.h"

#include <stddef.h>
#include <stdint.h>

typedef enum psplat_option_kind {
    PSPLAT_OPTION_FLAG,     /* int, set to 1 */
    PSPLAT_OPTION_TEXT,     /* const char * into argv */
    PSPLAT_OPTION_NUMBER,   /* double in min ... max */
    PSPLAT_OPTION_PERCENT,  /* double in min ... max; a % sign may follow */
    PSPLAT_OPTION_COUNT,    /* int in min ... max */
    PSPLAT_OPTION_EFFORT,   /* int in min ... max; 0 becomes PSPLAT_EFFORT_NONE */
    PSPLAT_OPTION_UNSIGNED, /* uint64_t */
    PSPLAT_OPTION_SIZE,     /* int[2], WIDTHxHEIGHT, each in min ... max */
    PSPLAT_OPTION_CHOICE,   /* int, index into choices */
    PSPLAT_OPTION_COLOR     /* float[4], sRGB-encoded 0 ... 1; RRGGBB, R,G,B or transparent */
} psplat_option_kind;

typedef struct psplat_option {
    char letter; /* 0 if there is only the long name */
    const char *name;
    psplat_option_kind kind;
    void *value;             /* untouched where the option is absent */
    const char *placeholder; /* for the value in --help; NULL for flags */
    const char *help;        /* lines separated by \n */
    double min, max;         /* inclusive */
    const char *const *choices;
} psplat_option;

enum { PSPLAT_MAX_SLOTS = 2, PSPLAT_MAX_OPTIONS = 30 };

/* The options of a command, in the order of its help. */
typedef struct psplat_option_list {
    psplat_option rows[PSPLAT_MAX_OPTIONS];
    size_t count;
} psplat_option_list;

/* Operands, as a part of argv. */
typedef struct psplat_operands {
    char **list;
    size_t count;
} psplat_operands;

/* The command line of a command; --help is always accepted. Operands fill, in order, the slots that
 * options have left NULL. Every slot must be filled in the end. Where more is set and no option has
 * filled the first slot, operands that are too many stand behind the one of the first slot. */
typedef struct psplat_syntax {
    const char *command;
    const char *operands; /* as --help shows them: "IN OUT.glb" */
    const char *summary;
    const char *notes; /* paragraph after the options; may be NULL */
    const psplat_option *options;
    size_t option_count;                  /* at most PSPLAT_MAX_OPTIONS */
    const char **slots[PSPLAT_MAX_SLOTS]; /* NULL after the last */
    psplat_operands *more;                /* or NULL */
} psplat_syntax;

/* The result of parsing; other than PSPLAT_PARSE_OK it is the exit code of the command. */
typedef enum psplat_parse {
    PSPLAT_PARSE_OK = -1,
    PSPLAT_PARSE_HELP = PSPLAT_EXIT_SUCCESS, /* --help was asked for and printed */
    PSPLAT_PARSE_ERROR = PSPLAT_EXIT_USAGE   /* the error line was printed */
} psplat_parse;

/* Parses the arguments and stores the values of options. argv[0] is the command's name; the order
 * of the other arguments is changed. Only one thread may call it at a time, since getopt_long has
 * global state. */
psplat_parse psplat_options_parse(const psplat_syntax *syntax, int argc, char **argv);

/* Appends a group of options, whose rows are copied. */
void psplat_options_add(psplat_option_list *list, const psplat_option *group, size_t count);

/* Prints the error line about subject, an option or an operand; returns PSPLAT_PARSE_ERROR. */
psplat_parse psplat_options_refuse(const char *command, const char *subject, const char *cause);

/* Prints the help of a command on standard output. */
void psplat_options_help(const psplat_syntax *syntax);

/* ---- option_table.c: options of several commands ------------------------------------------ */

typedef enum psplat_format { PSPLAT_FORMAT_PRETTY, PSPLAT_FORMAT_JSON } psplat_format;
extern const char *const psplat_format_names[];

/* Returns the shared option of this name, which must exist, with a place for its value. */
psplat_option psplat_option_shared(const char *name, void *value);

/* How convert and tile convert, and what of it their files hold. */
typedef struct psplat_conversion_options {
    psplat_convert_desc convert;
    const char *precision; /* as given, or NULL */
    int no_compress;
    int fallback; /* index into "points", "mesh" */
} psplat_conversion_options;

enum { PSPLAT_FALLBACK_POINTS, PSPLAT_FALLBACK_MESH };

/* Appends the options from --effort to --fallback that convert and tile share. */
void psplat_options_add_conversion(psplat_option_list *list, psplat_conversion_options *values);

/* Checks those options together once they are parsed, and stores what --precision means. Prints the
 * error line where they are refused. */
psplat_parse psplat_options_check_conversion(const char *command,
                                             psplat_conversion_options *values);

#endif
