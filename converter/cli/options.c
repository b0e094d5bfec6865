/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * options.c - the parser of command-line options, which are a table for getopt_long: -o VALUE,
 * -oVALUE,
 * --option VALUE, --option=VALUE, and "--" before operands that start with a dash. Letters of flags
 * may be joined (-wq), and long names shortened while they are unambiguous.
 */
#define _GNU_SOURCE /* getopt_long */

#include "cli/options.h"

#include "cli/command.h"
#include "select/conversion.h"

#include <assert.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- values: the readers return 1 where the text is valid ---------------------------------- */

static int read_flag(const psplat_option *option, const char *text) {
    (void)text;
    return *(int *)option->value = 1;
}

static int read_text(const psplat_option *option, const char *text) {
    *(const char **)option->value = text;
    return *text != 0;
}

/* Reads a decimal number; strtod alone would accept blanks, hexadecimal and words as well. */
static int read_number(const psplat_option *option, const char *text) {
    char *end = NULL;
    size_t length = strspn(text, "0123456789+-.eE");
    int is_percent = option->kind == PSPLAT_OPTION_PERCENT && !strcmp(text + length, "%");
    double number = strtod(text, &end);
    if (!length || end != text + length || (*end && !is_percent)) return 0;
    if (!isfinite(number) || number < option->min || number > option->max) return 0;
    *(double *)option->value = number;
    return 1;
}

/* Reads a decimal integer up to max at *text and moves *text behind it. */
static int read_digits(const char **text, uint64_t max, uint64_t *number) {
    if (**text < '0' || **text > '9') return 0;
    char *end = NULL;
    errno = 0;
    unsigned long long value = strtoull(*text, &end, 10);
    if (errno || value > max) return 0;
    *text = end;
    *number = value;
    return 1;
}

static int read_count(const psplat_option *option, const char *text) {
    uint64_t count = 0;
    if (!read_digits(&text, (uint64_t)option->max, &count) || *text) return 0;
    if ((double)count < option->min) return 0;
    int is_none = option->kind == PSPLAT_OPTION_EFFORT && !count;
    *(int *)option->value = is_none ? PSPLAT_EFFORT_NONE : (int)count;
    return 1;
}

static int read_unsigned(const psplat_option *option, const char *text) {
    uint64_t number = 0;
    if (!read_digits(&text, UINT64_MAX, &number) || *text) return 0;
    *(uint64_t *)option->value = number;
    return 1;
}

static int read_size(const psplat_option *option, const char *text) {
    uint64_t size[2] = {0, 0};
    if (!read_digits(&text, (uint64_t)option->max, &size[0])) return 0;
    if (*text != 'x' && *text != 'X') return 0;
    ++text;
    if (!read_digits(&text, (uint64_t)option->max, &size[1]) || *text) return 0;
    if ((double)size[0] < option->min || (double)size[1] < option->min) return 0;
    int *value = option->value;
    value[0] = (int)size[0];
    value[1] = (int)size[1];
    return 1;
}

static int read_choice(const psplat_option *option, const char *text) {
    for (int i = 0; option->choices[i]; ++i) {
        if (strcmp(option->choices[i], text) != 0) continue;
        *(int *)option->value = i;
        return 1;
    }
    return 0;
}

static int read_hexadecimal(const char *text, uint64_t rgb[3]) {
    if (*text == '#') ++text;
    if (strlen(text) != 6 || strspn(text, "0123456789abcdefABCDEF") != 6) return 0;
    unsigned long number = strtoul(text, NULL, 16);
    for (int i = 0; i < 3; ++i) rgb[i] = (number >> (16 - 8 * i)) & 255;
    return 1;
}

static int read_triple(const char *text, uint64_t rgb[3]) {
    for (int i = 0; i < 3; ++i) {
        if (!read_digits(&text, 255, &rgb[i])) return 0;
        if (*text != (i < 2 ? ',' : '\0')) return 0;
        ++text;
    }
    return 1;
}

static int read_color(const psplat_option *option, const char *text) {
    float *color = option->value;
    uint64_t rgb[3] = {0, 0, 0};
    int transparent = !strcmp(text, "transparent");
    if (!transparent && !read_hexadecimal(text, rgb) && !read_triple(text, rgb)) return 0;
    for (int i = 0; i < 3; ++i) color[i] = (float)rgb[i] / 255.0f;
    color[3] = transparent ? 0.0f : 1.0f;
    return 1;
}

static const struct {
    int (*read)(const psplat_option *option, const char *text);
    const char *expected; /* for messages; NULL if the placeholder says it */
} kinds[] = {
    [PSPLAT_OPTION_FLAG] = {read_flag, NULL},
    [PSPLAT_OPTION_TEXT] = {read_text, "a name"},
    [PSPLAT_OPTION_NUMBER] = {read_number, "a number"},
    [PSPLAT_OPTION_PERCENT] = {read_number, "a percentage"},
    [PSPLAT_OPTION_COUNT] = {read_count, "an integer"},
    [PSPLAT_OPTION_EFFORT] = {read_count, "an integer"},
    [PSPLAT_OPTION_UNSIGNED] = {read_unsigned, "an integer of 64 bits without a sign"},
    [PSPLAT_OPTION_SIZE] = {read_size, "WIDTHxHEIGHT"},
    [PSPLAT_OPTION_CHOICE] = {read_choice, NULL},
    [PSPLAT_OPTION_COLOR] = {read_color, "RRGGBB, R,G,B or transparent"},
};

/* ---- the table of getopt_long ------------------------------------------------------------- */

/* getopt_long returns FIRST_ROW plus the index of a row, which is beyond all letters. */
enum { MAX_ROWS = PSPLAT_MAX_OPTIONS + 2, FIRST_ROW = 256 };

static const psplat_option help_row = {
    'h', "help", PSPLAT_OPTION_FLAG, NULL, NULL, "show this and exit", 0, 0, NULL};

/* Returns a row of the table; the one after those of the command is --help. */
static const psplat_option *row_at(const psplat_syntax *syntax, size_t index) {
    return index < syntax->option_count ? &syntax->options[index] : &help_row;
}

/* Returns the row that getopt_long means by code, a letter or FIRST_ROW plus an index, or NULL. */
static const psplat_option *find_row(const psplat_syntax *syntax, int code) {
    for (size_t i = 0; i <= syntax->option_count; ++i)
        if (code == FIRST_ROW + (int)i || (code && code == row_at(syntax, i)->letter))
            return row_at(syntax, i);
    return NULL;
}

/* Fills the lists for getopt_long. The colon in front makes it print nothing and tell a missing
 * value from other errors. */
static void list_rows(const psplat_syntax *syntax, char *letters, struct option *names) {
    *letters++ = ':';
    for (size_t i = 0; i <= syntax->option_count; ++i) {
        const psplat_option *row = row_at(syntax, i);
        int has_value = row->kind != PSPLAT_OPTION_FLAG;
        names[i] = (struct option){row->name, has_value, NULL, FIRST_ROW + (int)i};
        if (row->letter) *letters++ = row->letter;
        if (row->letter && has_value) *letters++ = ':';
    }
}

/* ---- parsing ------------------------------------------------------------------------------ */

void psplat_options_add(psplat_option_list *list, const psplat_option *group, size_t count) {
    assert(list->count + count <= PSPLAT_MAX_OPTIONS);
    memcpy(&list->rows[list->count], group, count * sizeof *group);
    list->count += count;
}

psplat_parse psplat_options_refuse(const char *command, const char *subject, const char *cause) {
    psplat_command_error("%s: %.160s: %s (phongsplat %s --help lists what it takes)", command,
                         subject, cause, command);
    return PSPLAT_PARSE_ERROR;
}

/* Reports what getopt_long does not accept. optopt is the code of the row or the letter, or 0,
 * which means the long option in word. */
static psplat_parse refuse_option(const psplat_syntax *syntax, int code, const char *word) {
    const psplat_option *row = find_row(syntax, optopt);
    char name[256];
    if (row)
        return psplat_options_refuse(syntax->command, row->name,
                                     code == ':' ? "needs a value" : "takes no value");
    snprintf(name, sizeof name, "%.*s", (int)strcspn(word, "="), word);
    if (optopt) snprintf(name, sizeof name, "-%c", optopt);
    return psplat_options_refuse(
        syntax->command, name, optopt ? "unknown option" : "unknown option, or short for several");
}

static psplat_parse read_option(const psplat_syntax *syntax, const psplat_option *row,
                                const char *text) {
    char range[64] = "", cause[256];
    const char *expected = kinds[row->kind].expected;
    if (row == &help_row) {
        psplat_options_help(syntax);
        return PSPLAT_PARSE_HELP;
    }
    if (kinds[row->kind].read(row, text)) return PSPLAT_PARSE_OK;
    if (row->max > row->min) snprintf(range, sizeof range, " from %g to %g", row->min, row->max);
    snprintf(cause, sizeof cause, "'%.80s' is not %s%s", text,
             expected ? expected : row->placeholder, range);
    return psplat_options_refuse(syntax->command, row->name, cause);
}

/* Returns how many operands are too many and may be, behind the one of the first slot. */
static int count_more(const psplat_syntax *syntax, int count) {
    int open = 0;
    if (!syntax->more || *syntax->slots[0]) return 0;
    for (size_t i = 0; i < PSPLAT_MAX_SLOTS && syntax->slots[i]; ++i) open += !*syntax->slots[i];
    return count > open ? count - open : 0;
}

/* Gives each slot that no option has filled the next operand. */
static psplat_parse fill_slots(const psplat_syntax *syntax, char **operands, int count) {
    const char *command = syntax->command;
    int used = 0, more = count_more(syntax, count);
    for (int i = 0; i < count; ++i)
        if (!*operands[i]) return psplat_options_refuse(command, "''", "is an empty name");
    for (size_t i = 0; i < PSPLAT_MAX_SLOTS && syntax->slots[i]; ++i) {
        if (*syntax->slots[i]) continue;
        if (used == count) return psplat_options_refuse(command, syntax->operands, "are needed");
        *syntax->slots[i] = operands[used++];
        if (i == 0 && more) {
            *syntax->more = (psplat_operands){operands + used, (size_t)more};
            used += more;
        }
    }
    if (used == count) return PSPLAT_PARSE_OK;
    return psplat_options_refuse(command, operands[used], "is one argument too many");
}

psplat_parse psplat_options_parse(const psplat_syntax *syntax, int argc, char **argv) {
    char letters[2 * MAX_ROWS] = "";
    struct option names[MAX_ROWS] = {{0}};
    int code;
    assert(syntax->option_count + 2 <= MAX_ROWS);
    list_rows(syntax, letters, names);
    optind = 0; /* makes getopt_long begin anew at argv[1] */
    while ((code = getopt_long(argc, argv, letters, names, NULL)) != -1) {
        const psplat_option *row = find_row(syntax, code);
        psplat_parse parsed =
            row ? read_option(syntax, row, optarg) : refuse_option(syntax, code, argv[optind - 1]);
        if (parsed != PSPLAT_PARSE_OK) return parsed;
    }
    return fill_slots(syntax, argv + optind, argc - optind);
}

/* ---- help --------------------------------------------------------------------------------- */

static void print_option(const psplat_option *option) {
    char head[64];
    int length = option->letter
                     ? snprintf(head, sizeof head, "  -%c, --%s", option->letter, option->name)
                     : snprintf(head, sizeof head, "      --%s", option->name);
    if (option->placeholder)
        snprintf(head + length, sizeof head - (size_t)length, " %s", option->placeholder);
    const char *line = option->help;
    for (const char *left = head; line; left = "") {
        size_t width = strcspn(line, "\n");
        if (strlen(left) > 34) {
            printf("%s\n", left);
            left = "";
        }
        printf("%-34s %.*s", left, (int)width, line);
        line = line[width] ? line + width + 1 : NULL;
        if (!line && option->max > option->min) printf(", %g to %g", option->min, option->max);
        printf("\n");
    }
}

void psplat_options_help(const psplat_syntax *syntax) {
    printf("usage: phongsplat %s [options] %s\n\n%s\n\n", syntax->command, syntax->operands,
           syntax->summary);
    for (size_t i = 0; i <= syntax->option_count; ++i) print_option(row_at(syntax, i));
    if (syntax->notes) printf("\n%s\n", syntax->notes);
    printf("\n%s", psplat_exit_help);
}
