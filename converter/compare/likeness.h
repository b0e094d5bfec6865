/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * likeness.h - two pictures of the same size, pixel by pixel, and sums over several such pairs.
 */
#ifndef PHONGSPLAT_LIKENESS_H
#define PHONGSPLAT_LIKENESS_H

#include "compare.h"

/* Sums over pixels. Zero-initialise. */
typedef struct psplat_likeness {
    uint64_t squares;     /* of differences of 8-bit channels, where either covers */
    uint64_t differences; /* their magnitudes, there */
    uint64_t inside;      /* the same where both cover */
    uint64_t either, both, source, missing, extra; /* pixels */
    double ssim;                                   /* of windows around those that either covers */
} psplat_likeness;

/* RGBA of size x size pixels; alpha 0: not covered, and black then. Errors: MEMORY. */
psplat_result psplat_likeness_add(psplat_likeness *sums, const uint8_t *source,
                                  const uint8_t *exhibit, int size, psplat_error *error);
/* Sets all but perceptual. */
void psplat_likeness_report(const psplat_likeness *sums, psplat_picture_errors *errors);

#endif
