/* SPDX-License-Identifier: MIT
 *
 * draw_options.h - the command line of bench_draw.
 */
#ifndef PHONGSPLAT_BENCH_DRAW_OPTIONS_H
#define PHONGSPLAT_BENCH_DRAW_OPTIONS_H

#include <phongsplat/phongsplat.h>

enum { OPTIONS_MAX_LIST = 16 };

typedef struct options {
    size_t spheres[OPTIONS_MAX_LIST], sphere_count; /* of flat splats */
    size_t curved[OPTIONS_MAX_LIST], curved_count;  /* spheres of curved ones */
    int sizes[OPTIONS_MAX_LIST];
    size_t size_count;
    psplat_mode modes[PSPLAT_MODE_COUNT];
    size_t mode_count;
    psplat_shading shading;
    int no_filter, lights, csv, hardware, half_targets;
    size_t frames, warm_up;
    const char *mesh;         /* or NULL */
    const char *gltfpack;     /* or NULL */
    const char *const *files; /* in argv */
    size_t file_count;
} options;

/* Parses the command line. Prints the usage and ends the program where something is wrong or --help
 * is given. */
options options_parse(int argc, char **argv);

const char *options_mode_name(psplat_mode mode);
const char *options_shading_name(psplat_shading shading);

#endif
