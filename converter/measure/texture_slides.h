/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_slides.h - how far textures slide over a surface where splats show them.
 */
#ifndef PHONGSPLAT_MEASURE_TEXTURE_SLIDES_H
#define PHONGSPLAT_MEASURE_TEXTURE_SLIDES_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "features/surface.h"
#include "measure/measured_splats.h"
#include "splats/splats.h"

#include <stdint.h>

/* What splats show of kept textures at samples of a surface. Splats do not store their chart: of
 * the parts of the surface beneath a splat, bounded by creases and borders of charts, that have at
 * least a quarter of the area of the largest one inside its seams, the one over which its
 * coordinates slide at the least share of the samples is its own; but where that is more than half,
 * a smaller part over which they slide at less than half, and which the splat leaves by no more
 * than one and a half tolerances inside its seams, is, if there is one. Where a border of that
 * chart stands between a sample within the tolerance of it and the splat's own side, and some splat
 * shows what is there, the splat counts as one of another chart. */
typedef struct psplat_texture_slides {
    /* By sample, the slide of the splat that weighs most there, of those of its own chart that
     * cover it; negative where there is none, or no texture is kept there: */
    double *lengths; /* over the surface */
    double *texels;
    double *ways;     /* over the sample's triangle, to where it has what the splat shows */
    uint32_t *splats; /* the index of that splat; PSPLAT_NONE where there is none */
    uint8_t *seen;    /* 1 where the splat shows other texels than the surface has there; 0 where
                         these look the same (psplat_appearance_shows_same), as all over a plain
                         part of an image */
    uint8_t *lost; /* 1 where splats cover the sample, none of its chart, the heaviest shows other
                      texels than the surface has there, and the borders of the chart, over which
                      splats may reach by the tolerance, are farther away than that */
    /* Parts of the samples that keep textures and are covered, by the splat that covers a sample
     * with the greatest weight: */
    double mirrored; /* it shows the image the other way round than the surface does, and one sees
                        it: the material keeps a normal texture, or coordinates err by more than
                        PSPLAT_LEAST_SLIDE_TEXELS, within which filtering hides it */
    double foreign;  /* its own chart is not that of the sample */
} psplat_texture_slides;

/* Measures the slides at samples that have texture coordinates. psplat_texture_slides_free frees
 * *slides, also on failure. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_texture_slides_find(const psplat_surface *surface,
                                         const psplat_samples *samples, const psplat_splats *splats,
                                         const psplat_measured_splats *measured,
                                         psplat_texture_slides *slides);

/* Frees what slides owns, and zeroes it. */
void psplat_texture_slides_free(psplat_texture_slides *slides);

#endif
