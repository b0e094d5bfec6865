/* SPDX-License-Identifier: MIT
 *
 * options.c - the command line: one table of options, operands wherever they stand.
 */
#include "viewer.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct option {
    const char *name;
    const char *placeholder; /* NULL: takes no value */
    const char *help;
    const char *const *choices; /* NULL: the parser below knows the value */
    size_t offset;              /* of the int that choice or flag goes to */
} option;

#define AT(member) offsetof(options, member)

static const option table[] = {
    {"--size", "WxH", "size of the window, pixels", NULL, AT(width)},
    {"--mode", "MODE", "phong (default), gaussian or flat", mode_names, AT(settings.mode)},
    {"--shading", "NAME", NULL, shading_names, AT(settings.shading)},
    {"--lights", "NAME", NULL, lights_names, AT(settings.lights)},
    {"--background", "NAME", NULL, backdrop_names, AT(settings.backdrop)},
    {"--environment", NULL, "lit by a hazy sky, too", NULL, AT(settings.has_environment)},
    {"--smooth", NULL, "smooth edges: four samples a pixel", NULL, AT(settings.is_smooth)},
    {"--screenshots", "DIR", "where screenshots go; default: beside the asset", NULL,
     AT(screenshots)},
    {"--gles", NULL, "a context of GLES 3.0 instead of GL 3.3", NULL, AT(is_gles)},
};

enum { OPTION_COUNT = sizeof table / sizeof *table };

static const option *find(const char *name, size_t length) {
    for (int i = 0; i < OPTION_COUNT; ++i)
        if (strlen(table[i].name) == length && !strncmp(table[i].name, name, length))
            return &table[i];
    return NULL;
}

/* 1 ... 16384 pixels each. */
static int read_size(const char *text, options *o) {
    int width = 0, height = 0, end = 0;
    if (strspn(text, "0123456789x") != strlen(text)) return 0;
    if (sscanf(text, "%5dx%5d%n", &width, &height, &end) != 2 || text[end]) return 0;
    if (width < 1 || width > 16384 || height < 1 || height > 16384) return 0;
    o->width = width;
    o->height = height;
    return 1;
}

static int read_choice(const option *option, const char *text, options *o) {
    for (int i = 0; option->choices[i]; ++i)
        if (!strcmp(option->choices[i], text)) {
            int *value = (int *)((char *)o + option->offset);
            *value = i;
            return 1;
        }
    return 0;
}

static int read_value(const option *option, const char *text, options *o) {
    if (option->choices) return read_choice(option, text, o);
    if (option->offset == AT(width)) return read_size(text, o);
    o->screenshots = text;
    return *text != 0;
}

static void join(const char *const *names, char *text, size_t size) {
    size_t length = 0;
    *text = 0;
    for (int i = 0; names[i] && length < size; ++i) {
        int written = snprintf(text + length, size - length, "%s%s", i ? ", " : "", names[i]);
        length += written > 0 ? (size_t)written : 0;
    }
}

static parse_result refuse_value(const option *option, const char *text, psplat_error *error) {
    char expected[200] = "WxH, pixels";
    if (option->choices) join(option->choices, expected, sizeof expected);
    if (option->offset == AT(screenshots)) snprintf(expected, sizeof expected, "a directory");
    psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%s: '%.60s' is not %s%s", option->name, text,
                option->choices ? "one of: " : "", expected);
    return PARSE_ERROR;
}

/* Reads argv[*at] and, where it takes one, its value; leaves *at at the last that was read. */
static parse_result read_option(int argc, char **argv, int *at, options *o, psplat_error *error) {
    const char *word = argv[*at], *equals = strchr(word, '=');
    const option *option = find(word, equals ? (size_t)(equals - word) : strlen(word));
    if (!option) {
        psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%.60s: unknown option (--help lists them)",
                    word);
        return PARSE_ERROR;
    }
    if (!option->placeholder && !equals) {
        *(int *)((char *)o + option->offset) = 1;
        return PARSE_OK;
    }
    const char *value = equals ? equals + 1 : *at + 1 < argc ? argv[++*at] : NULL;
    if (!value || !option->placeholder) {
        psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%s: %s", option->name,
                    value ? "takes no value" : "needs a value");
        return PARSE_ERROR;
    }
    return read_value(option, value, o) ? PARSE_OK : refuse_value(option, value, error);
}

parse_result options_parse(int argc, char **argv, options *o, psplat_error *error) {
    int only_files = 0;
    o->files = argv + 1;
    for (int i = 1; i < argc; ++i) {
        const char *word = argv[i];
        if (only_files || word[0] != '-' || !word[1]) {
            o->files[o->file_count++] = argv[i];
            continue;
        }
        if (!strcmp(word, "--help") || !strcmp(word, "-h")) return PARSE_HELP;
        if (!strcmp(word, "--version")) return PARSE_VERSION;
        if (!strcmp(word, "--")) {
            only_files = 1;
            continue;
        }
        if (read_option(argc, argv, &i, o, error)) return PARSE_ERROR;
    }
    return PARSE_OK;
}

void options_print_help(void) {
    printf(
        "usage: phongsplat-viewer [options] [A.glb ...]\n\n"
        "Shows Phong splats (.glb or .gltf) in a window; several files are shown together. Files\n"
        "may be dropped onto the window. A file that changes is loaded again.\n\noptions:\n");
    for (int i = 0; i < OPTION_COUNT; ++i) {
        char left[60], choices[200];
        snprintf(left, sizeof left, "%s %s", table[i].name,
                 table[i].placeholder ? table[i].placeholder : "");
        if (!table[i].help) join(table[i].choices, choices, sizeof choices);
        printf("  %-23s%s\n", left, table[i].help ? table[i].help : choices);
    }
    printf("  %-23s%s\n  %-23s%s\n\nkeys:\n", "-h, --help", "this text", "--version",
           "the version");
    for (size_t i = 0; i < key_binding_count; ++i)
        if (key_bindings[i].label && *key_bindings[i].label)
            printf("  %-23s%s\n", key_bindings[i].label, key_bindings[i].help);
    printf("\nexit codes: 0 success, 1 wrong command line, 2 a file cannot be read, 3 it is "
           "malformed,\n"
           "4 it is not supported, 6 no usable graphics, 7 out of memory, 8 interrupted\n");
}
