/* SPDX-License-Identifier: MIT
 *
 * quality.h - how far images of splats are from images of the mesh that they were made from.
 */
#ifndef PHONGSPLAT_BENCH_QUALITY_H
#define PHONGSPLAT_BENCH_QUALITY_H

#include "draw_method.h"

/* Mean absolute differences of sRGB-encoded channels, in percent of white. */
typedef struct quality {
    double image;   /* of pixels that either covers, the other's being black there */
    double shading; /* of pixels that both cover */
    double covered; /* the former's share of the image, percent */
} quality;

/* The mesh's images of a subject from six fixed directions, size x size pixels each. */
typedef struct quality_reference {
    uint8_t *images; /* malloc */
    int size;
} quality_reference;

quality_reference quality_draw_mesh(psplat_host *host, const subject *s, const contestant *mesh,
                                    int size);
void quality_free(quality_reference *reference);

quality quality_measure(psplat_host *host, const subject *s, const contestant *splats,
                        psplat_mode mode, const quality_reference *reference);

/* Splats that reach the error by a row of (splats, error) in order of splats: interpolated between
 * logarithms, on the last segment's line beyond the last, negative then. 0: there is no telling. */
double quality_splats_for(double error, const double *splats, const double *errors, size_t count);

#endif
