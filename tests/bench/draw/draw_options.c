/* SPDX-License-Identifier: MIT
 *
 * draw_options.c - the command line of bench_draw; see draw_options.h.
 */
#include "draw_options.h"

#include "interleaved_timing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "bench_draw [option]... [FILE.glb]...\n"
    "Draws a sphere of splats and the given models, in turn with what they compare with, and "
    "prints\n"
    "the medians of what frames took.\n"
    "  --sphere N[,N...]  splats of the sphere; 10000,100000,1000000 where no FILE is given, else "
    "none\n"
    "  --curved N[,N...]  splats of spheres of curved splats; none\n"
    "  --size N[,N...]    pixels of the square image; 512,1024\n"
    "  --mode M[,M...]    phong, gaussian, flat; all three\n"
    "  --shading NAME     lit, unlit, toon, normal, depth, overdraw, splats; lit\n"
    "  --lights N         1 ... 8 directional lights; 1\n"
    "  --no-filter        without the screen-space filter\n"
    "  --mesh FILE        the mesh that the one FILE.glb was made from (where the converter is "
    "built)\n"
    "  --gltfpack PROGRAM with --mesh: also the mesh that gltfpack simplifies so far that its "
    "pictures\n"
    "                     differ from the mesh's as much as those of FILE.glb\n"
    "  --frames N         measured, of each kind; 15\n"
    "  --warm-up N        drawn before them; 2\n"
    "  --half-targets     also with sums of 16 bits\n"
    "  --hardware         on a GPU where EGL has one, not in software\n"
    "  --csv              comma-separated values, not a table\n";

static const char *const mode_names[PSPLAT_MODE_COUNT] = {"phong", "gaussian", "flat",
                                                          "parameters"};

static const char *const shading_names[PSPLAT_SHADING_COUNT] = {
#define SHADING_NAME(name, file, reads) #file,
    PSPLAT_SHADINGS(SHADING_NAME)
#undef SHADING_NAME
};

const char *options_mode_name(psplat_mode mode) {
    return mode_names[mode];
}

const char *options_shading_name(psplat_shading shading) {
    return shading_names[shading];
}

static void refuse(const char *what, const char *value) {
    fprintf(stderr, "bench_draw: %s %s\n\n%s", what, value, usage);
    exit(2);
}

/* Reads the number in front of a comma or the end and moves *text behind it. */
static long next_number(const char **text, long low, long high) {
    char *end = NULL;
    long value = strtol(*text, &end, 10);
    if (end == *text || value < low || value > high || (*end && *end != ','))
        refuse("not a number in range:", *text);
    *text = *end ? end + 1 : end;
    return value;
}

static long number(const char *text, long low, long high) {
    const char *at = text;
    long value = next_number(&at, low, high);
    if (*at) refuse("not one number:", text);
    return value;
}

static size_t index_of(const char *name, size_t length, const char *const *names, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (strlen(names[i]) == length && memcmp(names[i], name, length) == 0) return i;
    refuse("unknown name:", name);
    return 0;
}

static void parse_spheres(size_t *counts, size_t *count, const char *text) {
    while (*text && *count < OPTIONS_MAX_LIST)
        counts[(*count)++] = (size_t)next_number(&text, 4, 100000000);
}

static void parse_sizes(options *o, const char *text) {
    o->size_count = 0;
    while (*text && o->size_count < OPTIONS_MAX_LIST)
        o->sizes[o->size_count++] = (int)next_number(&text, 1, 16384);
}

static void parse_modes(options *o, const char *text) {
    o->mode_count = 0;
    while (*text && o->mode_count < PSPLAT_MODE_COUNT) {
        size_t length = strcspn(text, ",");
        o->modes[o->mode_count++] =
            (psplat_mode)index_of(text, length, mode_names, PSPLAT_MODE_PARAMETERS);
        text += length + (text[length] == ',');
    }
}

static int parse_flag(options *o, const char *name) {
    if (strcmp(name, "--no-filter") == 0) return o->no_filter = 1;
    if (strcmp(name, "--csv") == 0) return o->csv = 1;
    if (strcmp(name, "--hardware") == 0) return o->hardware = 1;
    if (strcmp(name, "--half-targets") == 0) return o->half_targets = 1;
    return 0;
}

static void parse_value(options *o, const char *name, const char *value) {
    if (strcmp(name, "--sphere") == 0) {
        parse_spheres(o->spheres, &o->sphere_count, value);
    } else if (strcmp(name, "--curved") == 0) {
        parse_spheres(o->curved, &o->curved_count, value);
    } else if (strcmp(name, "--size") == 0) {
        parse_sizes(o, value);
    } else if (strcmp(name, "--mode") == 0) {
        parse_modes(o, value);
    } else if (strcmp(name, "--shading") == 0) {
        o->shading =
            (psplat_shading)index_of(value, strlen(value), shading_names, PSPLAT_SHADING_COUNT);
    } else if (strcmp(name, "--lights") == 0) {
        o->lights = (int)number(value, 1, PSPLAT_MAX_LIGHTS);
    } else if (strcmp(name, "--mesh") == 0) {
        o->mesh = value;
    } else if (strcmp(name, "--gltfpack") == 0) {
        o->gltfpack = value;
    } else if (strcmp(name, "--frames") == 0) {
        o->frames = (size_t)number(value, 1, TIMING_MAX_FRAMES);
    } else if (strcmp(name, "--warm-up") == 0) {
        o->warm_up = (size_t)number(value, 0, TIMING_MAX_FRAMES);
    } else {
        refuse("unknown option:", name);
    }
}

options options_parse(int argc, char **argv) {
    options o = {.sizes = {512, 1024},
                 .size_count = 2,
                 .modes = {PSPLAT_MODE_PHONG, PSPLAT_MODE_GAUSSIAN, PSPLAT_MODE_FLAT},
                 .mode_count = 3,
                 .lights = 1,
                 .frames = 15,
                 .warm_up = 2};
    int i = 1;
    for (; i < argc && argv[i][0] == '-'; ++i) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(usage, stdout);
            exit(0);
        }
        if (parse_flag(&o, argv[i])) continue;
        if (i + 1 == argc) refuse("no value, or unknown:", argv[i]);
        parse_value(&o, argv[i], argv[i + 1]);
        ++i;
    }
    o.files = (const char *const *)argv + i;
    o.file_count = (size_t)(argc - i);
    if (!o.sphere_count && !o.curved_count && !o.file_count)
        parse_spheres(o.spheres, &o.sphere_count, "10000,100000,1000000");
    if (o.gltfpack && !o.mesh) refuse("--gltfpack needs --mesh:", o.gltfpack);
    if (o.mesh && o.file_count != 1) refuse("--mesh needs one FILE.glb:", o.mesh);
    return o;
}
