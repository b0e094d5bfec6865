/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sweep_options.h - what a sweep goes through, as the command line says it.
 */
#ifndef PHONGSPLAT_TABLE_SWEEP_OPTIONS_H
#define PHONGSPLAT_TABLE_SWEEP_OPTIONS_H

#include <stddef.h>
#include <stdint.h>

enum { PSPLAT_MOST_STEPS = 16 };

/* A ladder of numbers. */
typedef struct psplat_ladder {
    double steps[PSPLAT_MOST_STEPS]; /* descending, all different */
    size_t count;
} psplat_ladder;

/* Reads "2,1,0.5" in any order, where a % sign may follow each number. Returns 0 and changes
 * nothing where text is anything else, or a number is not within min ... max. */
int psplat_ladder_read(const char *text, double min, double max, psplat_ladder *ladder);

/* Zeros (no steps) mean not given. */
typedef struct psplat_sweep_options {
    psplat_ladder tolerances; /* %; default 2, 1, 0.5, 0.2, 0.1 */
    psplat_ladder ratios;     /* of triangles that gltfpack keeps; default 0.5 ... 0.01 */
    double normal_tolerance;  /* this and the next four are those of psplat_convert_desc */
    double crease_angle;
    int no_creases;
    int effort;
    uint64_t seed;
    int samples; /* of shape comparisons; default that of psplat_shape_desc */
    int size;    /* width and height of pictures in pixels; default 512 */
    int frames;  /* of each setting that are timed at most; default 24 */
} psplat_sweep_options;

/* Fills in the defaults of what is not given. */
void psplat_sweep_options_complete(psplat_sweep_options *options);

#endif
