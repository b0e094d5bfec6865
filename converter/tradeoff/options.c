/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * options.c - what a sweep goes through, as the command line and the journal say it.
 */
#include "tradeoff.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The spec of the ladders in the bench tables: what users choose between. */
static const psplat_ladder default_tolerances = {{2, 1, 0.5, 0.2, 0.1}, 5};
static const psplat_ladder default_ratios = {{0.5, 0.2, 0.1, 0.05, 0.02, 0.01}, 6};
static const int default_samples = 200000, default_size = 512, default_frames = 24;

static int descending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x > y ? -1 : x < y;
}

/* A decimal at *text, which moves behind it and a % sign. strtod alone takes words, too. */
static int read_step(const char **text, double min, double max, double *step) {
    char *end = NULL;
    if (!strchr("0123456789.", **text) || !**text) return 0;
    if (**text == '0' && ((*text)[1] == 'x' || (*text)[1] == 'X')) return 0;
    *step = strtod(*text, &end);
    if (end == *text || !isfinite(*step) || *step < min || *step > max) return 0;
    *text = end + (*end == '%');
    return 1;
}

int psplat_ladder_read(const char *text, double min, double max, psplat_ladder *ladder) {
    psplat_ladder read = {.count = 0}, unique = {.count = 0};
    do {
        if (read.count == PSPLAT_MOST_STEPS) return 0;
        if (!read_step(&text, min, max, &read.steps[read.count++])) return 0;
    } while (*text == ',' && *++text);
    if (*text || text[-1] == ',') return 0;
    qsort(read.steps, read.count, sizeof *read.steps, descending);
    for (size_t i = 0; i < read.count; ++i)
        if (!i || read.steps[i] < read.steps[i - 1]) unique.steps[unique.count++] = read.steps[i];
    *ladder = unique;
    return 1;
}

psplat_tradeoff_options psplat_tradeoff_options_default(void) {
    return (psplat_tradeoff_options){.tolerances = default_tolerances,
                                     .ratios = default_ratios,
                                     .samples = default_samples,
                                     .size = default_size,
                                     .frames = default_frames};
}

void psplat_tradeoff_options_inherit(psplat_tradeoff_options *options,
                                     const psplat_tradeoff_options *others) {
    if (!options->tolerances.count) options->tolerances = others->tolerances;
    if (!options->ratios.count) options->ratios = others->ratios;
    if (options->normal_tolerance == 0) options->normal_tolerance = others->normal_tolerance;
    if (options->crease_angle == 0 && !options->no_creases) {
        options->crease_angle = others->crease_angle;
        options->no_creases = others->no_creases;
    }
    if (!options->effort) options->effort = others->effort;
    if (!options->seed) options->seed = others->seed;
    if (!options->samples) options->samples = others->samples;
    if (!options->size) options->size = others->size;
    if (!options->frames) options->frames = others->frames;
    if (!options->perceptual) options->perceptual = others->perceptual;
}

/* ---- as a line ---------------------------------------------------------------------------- */

static void write_ladder(const char *name, const psplat_ladder *ladder, psplat_text *text) {
    if (!ladder->count) return;
    psplat_text_add(text, " %s=", name);
    for (size_t i = 0; i < ladder->count; ++i) {
        if (i) psplat_text_add(text, ",");
        psplat_text_number(text, ladder->steps[i]);
    }
}

static void write_number(const char *name, double number, psplat_text *text) {
    if (number == 0) return;
    psplat_text_add(text, " %s=", name);
    psplat_text_number(text, number);
}

void psplat_tradeoff_options_write(const psplat_tradeoff_options *options, psplat_text *text) {
    psplat_text_add(text, "options");
    write_ladder("tolerances", &options->tolerances, text);
    write_ladder("ratios", &options->ratios, text);
    write_number("normal_tolerance", options->normal_tolerance, text);
    write_number("crease_angle", options->crease_angle, text);
    write_number("no_creases", options->no_creases, text);
    write_number("effort", options->effort, text);
    if (options->seed) psplat_text_add(text, " seed=%llu", (unsigned long long)options->seed);
    write_number("samples", options->samples, text);
    write_number("size", options->size, text);
    write_number("frames", options->frames, text);
    write_number("perceptual", options->perceptual, text);
}

static int read_number(const char *text, double min, double max, double *number) {
    psplat_ladder ladder = {.count = 0};
    if (!psplat_ladder_read(text, min, max, &ladder) || ladder.count != 1) return 0;
    *number = ladder.steps[0];
    return 1;
}

static int read_count(const char *text, int max, int *count) {
    double number = 0;
    if (!read_number(text, 1, max, &number) || number != floor(number)) return 0;
    *count = (int)number;
    return 1;
}

static int read_seed(const char *text, uint64_t *seed) {
    char *end = NULL;
    if (*text < '0' || *text > '9') return 0;
    *seed = strtoull(text, &end, 10);
    return !*end;
}

static int read_pair(const char *name, const char *value, psplat_tradeoff_options *o) {
    if (!strcmp(name, "tolerances")) return psplat_ladder_read(value, 1e-4, 50, &o->tolerances);
    if (!strcmp(name, "ratios")) return psplat_ladder_read(value, 1e-6, 1, &o->ratios);
    if (!strcmp(name, "normal_tolerance")) return read_number(value, 0, 90, &o->normal_tolerance);
    if (!strcmp(name, "crease_angle")) return read_number(value, 0, 180, &o->crease_angle);
    if (!strcmp(name, "no_creases")) return read_count(value, 1, &o->no_creases);
    if (!strcmp(name, "effort")) return read_count(value, 10, &o->effort);
    if (!strcmp(name, "seed")) return read_seed(value, &o->seed);
    if (!strcmp(name, "samples")) return read_count(value, 100000000, &o->samples);
    if (!strcmp(name, "size")) return read_count(value, 8192, &o->size);
    if (!strcmp(name, "frames")) return read_count(value, 100000, &o->frames);
    if (!strcmp(name, "perceptual")) return read_count(value, 1, &o->perceptual);
    return 0;
}

int psplat_tradeoff_options_read(const char *line, psplat_tradeoff_options *options) {
    psplat_tradeoff_options read = {.size = 0};
    char name[32], value[512];
    int used = 0;
    if (strncmp(line, "options", 7)) return 0;
    for (line += 7; *line; line += used)
        if (sscanf(line, " %31[a-z_]=%511[^ ]%n", name, value, &used) != 2 ||
            !read_pair(name, value, &read))
            return 0;
    *options = read;
    return 1;
}
