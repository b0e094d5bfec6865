/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * butteraugli.h - the perceptual distance of two pictures, by a program of others.
 */
#ifndef PHONGSPLAT_BUTTERAUGLI_H
#define PHONGSPLAT_BUTTERAUGLI_H

#include "compare.h"

/* Two pictures of 8-bit sRGB, width x height pixels each, row 0 on top. */
typedef struct psplat_picture_pair {
    const uint8_t *pixels[2];
    int width, height;
} psplat_picture_pair;

/* *distance: the 3-norm of butteraugli's map of differences, 0: alike, or -1 where there is no
 * butteraugli_main in PATH. Errors: MEMORY, WRITE (no temporary file in TMPDIR), READ (the program
 * fails). */
psplat_result psplat_butteraugli_measure(const psplat_picture_pair *pair, double *distance,
                                         psplat_error *error);

#endif
