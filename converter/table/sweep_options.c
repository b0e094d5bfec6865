/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_options.c - ladders as the command line says them, and defaults.
 */
#include "table/sweep_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* These are the steps that users choose between. */
static const psplat_ladder default_tolerances = {{2, 1, 0.5, 0.2, 0.1}, 5};
static const psplat_ladder default_ratios = {{0.5, 0.2, 0.1, 0.05, 0.02, 0.01}, 6};

static int descending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return x > y ? -1 : x < y;
}

/* Reads a decimal at *text, which moves behind it and a % sign. strtod alone takes words, too. */
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

void psplat_sweep_options_complete(psplat_sweep_options *options) {
    if (!options->tolerances.count) options->tolerances = default_tolerances;
    if (!options->ratios.count) options->ratios = default_ratios;
    if (!options->samples) options->samples = 200000;
    if (!options->size) options->size = 512;
    if (!options->frames) options->frames = 24;
}
