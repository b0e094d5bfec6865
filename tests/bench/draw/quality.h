/* SPDX-License-Identifier: MIT
 *
 * quality.h - measures how far images of splats are from images of the mesh that they were made
 * from.
 */
#ifndef PHONGSPLAT_BENCH_QUALITY_H
#define PHONGSPLAT_BENCH_QUALITY_H

#include "draw_method.h"

/* Mean absolute differences of sRGB-encoded channels, in percent of white. */
typedef struct quality {
    double image;   /* over pixels that either covers; the other is black there */
    double shading; /* over pixels that both cover */
    double covered; /* pixels that either covers, in percent of the image */
} quality;

/* The mesh's images of a subject from six fixed directions, size x size pixels each. */
typedef struct quality_reference {
    uint8_t *images; /* allocated with malloc */
    int size;
} quality_reference;

quality_reference quality_draw_mesh(psplat_host *host, const subject *s, const draw_method *mesh,
                                    int size);
void quality_free(quality_reference *reference);

quality quality_measure(psplat_host *host, const subject *s, const draw_method *splats,
                        psplat_mode mode, const quality_reference *reference);

/* Returns the splats that reach an error, from a row of (splats, error) in order of splats. It
 * interpolates between logarithms. Beyond the last point it continues the last segment's line and
 * returns the negative number. It returns 0 where that is impossible. */
double quality_splats_for(double error, const double *splats, const double *errors, size_t count);

#endif
