/* SPDX-License-Identifier: MIT
 *
 * viewer_options.c - the command line: one table of options, which getopt_long reads.
 */
#define _GNU_SOURCE /* for getopt_long */

#include "viewer.h"

#include <getopt.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct row {
    const char *name;
    const char *placeholder; /* NULL: the option takes no value */
    const char *help;
    const char *const *choices; /* NULL: the parser below reads the value */
    size_t offset;              /* of the int in options that the choice or flag is stored in */
} row;

#define AT(member) offsetof(options, member)

static const row table[] = {
    {"size", "WxH", "size of the window, pixels", NULL, AT(width)},
    {"mode", "MODE", "phong (default), gaussian or flat", mode_names, AT(settings.mode)},
    {"shading", "NAME", NULL, shading_names, AT(settings.shading)},
    {"lights", "NAME", NULL, lights_names, AT(settings.lights)},
    {"background", "NAME", NULL, backdrop_names, AT(settings.backdrop)},
    {"environment", NULL, "lit by a hazy sky, too", NULL, AT(settings.has_environment)},
    {"smooth", NULL, "smooth edges: four samples a pixel", NULL, AT(settings.is_smooth)},
    {"paused", NULL, "animations stand still until K is pressed", NULL, AT(settings.is_paused)},
    {"screenshots", "DIR", "where screenshots go; default: beside the asset", NULL,
     AT(screenshots)},
    {"pixels", "N", "tilesets: greatest error, pixels; default: 1", NULL, AT(settings.pixels)},
    {"max-splats", "N", "tilesets: splats drawn at most", NULL, AT(max_splats)},
    {"max-megabytes", "N", "tilesets: tiles in memory at most; default: 512", NULL,
     AT(max_megabytes)},
    {"tiles", NULL, "tilesets: show numbers of tiles", NULL, AT(settings.has_tile_report)},
    {"gles", NULL, "a context of GLES 3.0 instead of GL 3.3", NULL, AT(is_gles)},
    {"help", NULL, "this text, as does -h", NULL, 0},
    {"version", NULL, "the version", NULL, 0},
};

/* getopt_long calls rows by their index plus FIRST, which is above every letter. */
enum { OPTION_COUNT = sizeof table / sizeof *table, FIRST = 256 };
enum { HELP = FIRST + OPTION_COUNT - 2, VERSION };

static int *int_at(const row *row, options *o) {
    return (int *)((char *)o + row->offset);
}

/* Reads a width and a height of 1 to 16384 pixels. */
static int read_size(const char *text, options *o) {
    int width = 0, height = 0, end = 0;
    if (strspn(text, "0123456789x") != strlen(text)) return 0;
    if (sscanf(text, "%5dx%5d%n", &width, &height, &end) != 2 || text[end]) return 0;
    if (width < 1 || width > 16384 || height < 1 || height > 16384) return 0;
    o->width = width;
    o->height = height;
    return 1;
}

static int read_choice(const row *row, const char *text, options *o) {
    for (int i = 0; row->choices[i]; ++i)
        if (!strcmp(row->choices[i], text)) {
            *int_at(row, o) = i;
            return 1;
        }
    return 0;
}

/* Reads an error of 0.1 to 1000 pixels. */
static int read_pixels(const char *text, options *o) {
    char *end;
    o->settings.pixels = strtod(text, &end);
    return !*end && o->settings.pixels >= 0.1 && o->settings.pixels <= 1000;
}

/* Reads a number of 1 to 999,999,999. */
static int read_count(const row *row, const char *text, options *o) {
    size_t length = strspn(text, "0123456789");
    *int_at(row, o) = length && length < 10 && !text[length] ? atoi(text) : 0;
    return *int_at(row, o) > 0;
}

static int is_count(const row *row) {
    return row->offset == AT(max_splats) || row->offset == AT(max_megabytes);
}

static int read_value(const row *row, const char *text, options *o) {
    if (!row->placeholder) return *int_at(row, o) = 1;
    if (row->choices) return read_choice(row, text, o);
    if (row->offset == AT(width)) return read_size(text, o);
    if (row->offset == AT(settings.pixels)) return read_pixels(text, o);
    if (is_count(row)) return read_count(row, text, o);
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

static parse_result refuse_value(const row *row, const char *text, psplat_error *error) {
    char expected[200] = "WxH, pixels";
    if (row->choices) join(row->choices, expected, sizeof expected);
    if (row->offset == AT(screenshots)) snprintf(expected, sizeof expected, "a directory");
    if (row->offset == AT(settings.pixels)) snprintf(expected, sizeof expected, "0.1 to 1000");
    if (is_count(row)) snprintf(expected, sizeof expected, "a number from 1 on");
    psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "--%s: '%.60s' is not %s%s", row->name, text,
                row->choices ? "one of: " : "", expected);
    return PARSE_ERROR;
}

/* Describes what getopt_long refuses: word, unless optopt says which row or letter of it. */
static parse_result refuse_word(int code, const char *word, psplat_error *error) {
    char name[64];
    const char *cause = "unknown option, or short for several (--help lists them)";
    snprintf(name, sizeof name, "%.60s", word);
    if (optopt >= FIRST) {
        snprintf(name, sizeof name, "--%s", table[optopt - FIRST].name);
        cause = code == ':' ? "needs a value" : "takes no value";
    } else if (optopt) {
        snprintf(name, sizeof name, "-%c", optopt);
        cause = "unknown option (--help lists them)";
    }
    psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%s: %s", name, cause);
    return PARSE_ERROR;
}

parse_result options_parse(int argc, char **argv, options *o, psplat_error *error) {
    struct option names[OPTION_COUNT + 1] = {{0}};
    int code;
    for (int i = 0; i < OPTION_COUNT; ++i)
        names[i] = (struct option){table[i].name, table[i].placeholder != NULL, NULL, FIRST + i};
    /* The colon makes getopt_long print nothing and distinguish missing values from other
     * errors. */
    while ((code = getopt_long(argc, argv, ":h", names, NULL)) != -1) {
        if (code == 'h' || code == HELP) return PARSE_HELP;
        if (code == VERSION) return PARSE_VERSION;
        if (code < FIRST) return refuse_word(code, argv[optind - 1], error);
        const row *row = &table[code - FIRST];
        if (!read_value(row, optarg, o)) return refuse_value(row, optarg, error);
    }
    o->files = argv + optind;
    o->file_count = argc - optind;
    return PARSE_OK;
}

void options_print_help(void) {
    printf(
        "usage: phongsplat-viewer [options] [A.glb ...]\n\n"
        "Shows Phong splats (.glb or .gltf) in a window; several files are shown together. Files\n"
        "may be dropped onto the window. A file that changes is loaded again. A tileset (3D Tiles) "
        "is\n"
        "a tileset.json, its directory or a .3tz; its tiles are read as the camera wants "
        "them.\n\noptions:\n");
    for (int i = 0; i < OPTION_COUNT; ++i) {
        char left[60], choices[200];
        snprintf(left, sizeof left, "--%s %s", table[i].name,
                 table[i].placeholder ? table[i].placeholder : "");
        if (!table[i].help) join(table[i].choices, choices, sizeof choices);
        printf("  %-23s%s\n", left, table[i].help ? table[i].help : choices);
    }
    printf("\nkeys:\n");
    for (size_t i = 0; i < key_binding_count; ++i)
        if (key_bindings[i].label && *key_bindings[i].label)
            printf("  %-23s%s\n", key_bindings[i].label, key_bindings[i].help);
    printf("\nexit codes: 0 success, 1 wrong command line, 2 a file cannot be read, 3 it is "
           "malformed,\n"
           "4 it is not supported, 6 no usable graphics, 7 out of memory, 8 interrupted\n");
}
