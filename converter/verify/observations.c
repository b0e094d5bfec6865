/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * observations.c - the memory of what a verification measured.
 */
#include "verify/observations.h"

#include <stdlib.h>
#include <string.h>

void psplat_observations_free(psplat_observations *o) {
    free(o->bounds);
    free(o->points);
    free(o->degrees);
    free(o->open);
    free(o->widths);
    *o = (psplat_observations){0};
}

int psplat_observations_allocate(psplat_observations *o, size_t splats, size_t samples,
                                 size_t open) {
    psplat_observations_free(o);
    o->bounds = calloc(splats + 1, sizeof *o->bounds);
    o->points = malloc((samples + 1) * 3 * sizeof *o->points);
    o->degrees = malloc((samples + 1) * sizeof *o->degrees);
    o->open = malloc((open + 1) * 3 * sizeof *o->open);
    o->widths = malloc((open + 1) * sizeof *o->widths);
    o->splat_count = splats;
    o->sample_count = samples;
    return o->bounds && o->points && o->degrees && o->open && o->widths;
}

void psplat_observations_open(psplat_observations *o, const double point[3], double width) {
    memcpy(o->open + 3 * o->open_count, point, 3 * sizeof *point);
    o->widths[o->open_count++] = width;
}
