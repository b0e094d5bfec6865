/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_metrics.h - image metrics of picture pairs: mean absolute difference, PSNR, SSIM, and
 * pixels that are missing or extra.
 */
#ifndef PHONGSPLAT_VIEWS_IMAGE_METRICS_H
#define PHONGSPLAT_VIEWS_IMAGE_METRICS_H

#include <phongsplat/splat.h>

/* The differences between pictures as they are shown: sRGB-encoded with 8 bits for a channel, and
 * black where nothing is. A pixel is covered where something is drawn. */
typedef struct psplat_picture_errors {
    double psnr;        /* dB, over pixels that either picture covers; INFINITY if they are equal */
    double inside_psnr; /* the same over pixels that both cover, so without the outline */
    double ssim;        /* Wang et al. 2004: mean over the 11 x 11 Gaussian windows of luma whose
                           centre either picture covers; 1 if they are equal */
    double difference;  /* mean absolute difference, % of white, over pixels that either covers */
    double inside;      /* mean absolute difference, % of white, over pixels that both cover */
    double missing;     /* pixels that only the source covers, % of those that it covers */
    double extra;       /* pixels that the source does not cover but the other picture does, % of
                           those that it covers; 100 where it covers none */
    double distant; /* mean absolute difference, % of white, at an eighth of the size, over pixels
                       that the source covers whole and the other picture covers; the reference is
                       the source at full size, averaged in linear light */
    size_t covered; /* pixels that the source covers */
    size_t interior_holes; /* pixels of those that the other picture does not cover, though the
                              source covers all within the erosion of them: holes that show the
                              background, and no outline that lies a little inside */
} psplat_picture_errors;

/* Sums over the pixels of all pairs that were added. It begins zero-initialised. */
typedef struct psplat_image_metrics {
    uint64_t squares;     /* squared differences of 8-bit channels, where either covers a pixel */
    uint64_t differences; /* absolute differences of the same channels */
    uint64_t inside;      /* absolute differences where both cover a pixel, */
    uint64_t inside_squares;                              /* and squared ones */
    uint64_t either, both, source, missing, extra, holes; /* numbers of pixels */
    int erosion; /* set by the caller: pixels within which an outline of the source is near, by the
                    greater of both coordinates; 0 means 2 */
    double ssim; /* SSIM of the windows around pixels that either covers */
} psplat_image_metrics;

/* Adds a pair of RGBA pictures of size x size pixels. Pixels that are not covered must be black
 * with alpha 0. Errors: MEMORY. */
psplat_result psplat_image_metrics_add(psplat_image_metrics *sums, const uint8_t *source,
                                       const uint8_t *pictured, int size, psplat_error *error);
/* Computes the metrics from the sums. */
void psplat_image_metrics_report(const psplat_image_metrics *sums, psplat_picture_errors *errors);

#endif
