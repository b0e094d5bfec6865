/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_options.c - options as a table: -o VALUE, -oVALUE, --option VALUE, --option=VALUE, and
 * "--" before operands that start with a dash. Letters of flags may be joined (-wq).
 */
#include "command.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Decimal alone: strtod takes blanks, hexadecimal, and words as well. */
static int read_number(const psplat_option *option, const char *text, const char *suffix) {
    char *end = NULL;
    size_t length = strspn(text, "0123456789+-.eE");
    if (strcmp(text + length, suffix) != 0 && text[length]) return 0;
    double number = strtod(text, &end);
    if (end == text) return 0;
    if (*end && strcmp(end, suffix) != 0) return 0;
    if (!isfinite(number) || number < option->min || number > option->max) return 0;
    *(double *)option->value = number;
    return 1;
}

/* A decimal integer up to max, at *text, which moves behind it. */
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
    *(int *)option->value = (int)count;
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

int psplat_option_read(const psplat_option *option, const char *text, const char **expected) {
    switch (option->kind) {
    case PSPLAT_OPTION_FLAG:
        *expected = "no value";
        return 0;
    case PSPLAT_OPTION_TEXT:
        *expected = "a name";
        if (*text) *(const char **)option->value = text;
        return *text != 0;
    case PSPLAT_OPTION_NUMBER:
        *expected = "a number";
        return read_number(option, text, "");
    case PSPLAT_OPTION_PERCENT:
        *expected = "a percentage";
        return read_number(option, text, "%");
    case PSPLAT_OPTION_COUNT:
        *expected = "an integer";
        return read_count(option, text);
    case PSPLAT_OPTION_UNSIGNED:
        *expected = "an integer of 64 bits without a sign";
        return read_unsigned(option, text);
    case PSPLAT_OPTION_SIZE:
        *expected = "WIDTHxHEIGHT";
        return read_size(option, text);
    case PSPLAT_OPTION_CHOICE:
        *expected = option->placeholder;
        return read_choice(option, text);
    case PSPLAT_OPTION_COLOR:
        *expected = "RRGGBB, R,G,B or transparent";
        return read_color(option, text);
    }
    return 0;
}

enum { MAX_SUBJECT = 160 }; /* bytes of an argument that an error shows */

static psplat_parse usage_error(const psplat_syntax *syntax, const char *subject, size_t length,
                                const char *cause) {
    int shown = length < MAX_SUBJECT ? (int)length : MAX_SUBJECT;
    psplat_command_error("%s: %.*s: %s (phongsplat %s --help lists what it takes)", syntax->command,
                         shown, subject, cause, syntax->command);
    return PSPLAT_PARSE_ERROR;
}

static psplat_parse value_error(const psplat_syntax *syntax, const psplat_option *option,
                                const char *text, const char *expected) {
    char range[64] = "", cause[256];
    int bounded = option->max > option->min;
    if (bounded) snprintf(range, sizeof range, " from %g to %g", option->min, option->max);
    snprintf(cause, sizeof cause, "'%.80s' is not %s%s", text, expected, range);
    return usage_error(syntax, option->name, strlen(option->name), cause);
}

static const psplat_option *find_long(const psplat_syntax *syntax, const char *name,
                                      size_t length) {
    for (size_t i = 0; i < syntax->option_count; ++i) {
        const psplat_option *option = &syntax->options[i];
        if (strlen(option->name) == length && !memcmp(option->name, name, length)) return option;
    }
    return NULL;
}

static const psplat_option *find_letter(const psplat_syntax *syntax, char letter) {
    for (size_t i = 0; i < syntax->option_count; ++i)
        if (syntax->options[i].letter == letter) return &syntax->options[i];
    return NULL;
}

/* The arguments not yet read. */
typedef struct reader {
    const psplat_syntax *syntax;
    int count;
    char **next;
} reader;

static char *take(reader *arguments) {
    --arguments->count;
    return *arguments->next++;
}

/* text is the value joined to the option, or NULL where it would be the next argument. */
static psplat_parse apply(reader *arguments, const psplat_option *option, const char *text) {
    const char *expected = NULL;
    if (option->kind == PSPLAT_OPTION_FLAG) {
        if (text) return value_error(arguments->syntax, option, text, "accepted: it takes none");
        *(int *)option->value = 1;
        return PSPLAT_PARSE_OK;
    }
    if (!text && !arguments->count)
        return usage_error(arguments->syntax, option->name, strlen(option->name), "needs a value");
    if (!text) text = take(arguments);
    if (psplat_option_read(option, text, &expected)) return PSPLAT_PARSE_OK;
    return value_error(arguments->syntax, option, text, expected);
}

static psplat_parse parse_long(reader *arguments, const char *argument) {
    const char *equals = strchr(argument, '=');
    size_t length = equals ? (size_t)(equals - argument) : strlen(argument);
    if (!equals && !strcmp(argument, "--help")) {
        psplat_options_help(arguments->syntax);
        return PSPLAT_PARSE_HELP;
    }
    const psplat_option *option = find_long(arguments->syntax, argument + 2, length - 2);
    if (!option) return usage_error(arguments->syntax, argument, length, "unknown option");
    return apply(arguments, option, equals ? equals + 1 : NULL);
}

static psplat_parse parse_letters(reader *arguments, const char *letters) {
    for (; *letters; ++letters) {
        if (*letters == 'h') {
            psplat_options_help(arguments->syntax);
            return PSPLAT_PARSE_HELP;
        }
        const psplat_option *option = find_letter(arguments->syntax, *letters);
        char name[3] = {'-', *letters, 0};
        if (!option) return usage_error(arguments->syntax, name, 2, "unknown option");
        if (option->kind != PSPLAT_OPTION_FLAG)
            return apply(arguments, option, letters[1] ? letters + 1 : NULL);
        *(int *)option->value = 1;
    }
    return PSPLAT_PARSE_OK;
}

static psplat_parse fill_slot(const psplat_syntax *syntax, const char *operand) {
    for (size_t i = 0; i < syntax->slot_count; ++i) {
        if (*syntax->slots[i]) continue;
        *syntax->slots[i] = operand;
        return PSPLAT_PARSE_OK;
    }
    return usage_error(syntax, operand, strlen(operand), "is one argument too many");
}

/* Operands wait until all options are read, because an option may fill a slot after them. */
static psplat_parse fill_slots(const psplat_syntax *syntax, char **operands, int count) {
    for (int i = 0; i < count; ++i) {
        psplat_parse result = *operands[i] ? fill_slot(syntax, operands[i])
                                           : usage_error(syntax, "''", 2, "is an empty name");
        if (result != PSPLAT_PARSE_OK) return result;
    }
    for (size_t i = 0; i < syntax->slot_count; ++i)
        if (!*syntax->slots[i])
            return usage_error(syntax, syntax->operands, strlen(syntax->operands), "are needed");
    return PSPLAT_PARSE_OK;
}

psplat_parse psplat_options_parse(const psplat_syntax *syntax, int argc, char **argv) {
    reader arguments = {syntax, argc, argv};
    int operand_count = 0, only_operands = 0;
    while (arguments.count) {
        char *argument = take(&arguments);
        psplat_parse result = PSPLAT_PARSE_OK;
        if (only_operands || argument[0] != '-' || !argument[1])
            argv[operand_count++] = argument; /* overtakes nothing: argv was read at least so far */
        else if (!strcmp(argument, "--"))
            only_operands = 1;
        else if (argument[1] == '-')
            result = parse_long(&arguments, argument);
        else
            result = parse_letters(&arguments, argument + 1);
        if (result != PSPLAT_PARSE_OK) return result;
    }
    return fill_slots(syntax, argv, operand_count);
}

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
    for (size_t i = 0; i < syntax->option_count; ++i) print_option(&syntax->options[i]);
    printf("%-34s show this and exit\n", "  -h, --help");
    if (syntax->notes) printf("\n%s\n", syntax->notes);
    printf("\n%s", psplat_exit_help);
}
