/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_errors.h - how far the blended look of splats is from that of the surface.
 */
#ifndef PHONGSPLAT_MEASURE_COLOR_ERRORS_H
#define PHONGSPLAT_MEASURE_COLOR_ERRORS_H

#include <phongsplat/splat.h>

#include "features/samples.h"
#include "features/surface.h"
#include "measure/point_blend.h"

/* The values of a look, with the material's factors: linear R G B of the base colour and of the
 * emissive light, roughness, metallic. */
enum {
    PSPLAT_LOOK_BASE = 0,
    PSPLAT_LOOK_EMISSIVE = 3,
    PSPLAT_LOOK_ROUGHNESS = 6,
    PSPLAT_LOOK_METALLIC = 7,
    PSPLAT_LOOK_VALUES = 8
};

/* Returns whether anything of a look that is promised was baked at the samples, or comes from
 * vertices. */
int psplat_samples_have_look(const psplat_samples *samples);

/* Returns how many random points of the surface its looks are measured at: one for each baked texel
 * or for each square of the tolerance, a length, whichever are more, between 50,000 and 250,000. */
size_t psplat_color_point_count(const psplat_surface *surface, double tolerance);

/* Finds the look of a blend; its first value is -1 where nothing is seen. */
void psplat_blended_look(const psplat_point_blend *blend, float look[PSPLAT_LOOK_VALUES]);

/* Finds what the surface looks like at a sample. Unlit materials have a base colour alone. */
void psplat_expected_look(const psplat_surface *surface, const psplat_samples *samples,
                          size_t sample, float look[PSPLAT_LOOK_VALUES]);

/* Returns the difference of two looks, in % of a range: the greatest of the root mean squares over
 * R, G and B of sRGB, for base colours and for emissive light, each channel clipped at 1, and of
 * the differences of roughness and of metallic. */
double psplat_look_difference(const float a[PSPLAT_LOOK_VALUES], const float b[PSPLAT_LOOK_VALUES]);

/* Finds the error of each sample, in %. shown (samples->count x PSPLAT_LOOK_VALUES) is what splats
 * show there; its first value is negative where nothing is seen, and the error then is negative,
 * too. A look may be off by reach, a length, over the surface: an error of more than limit becomes
 * the least difference between what is shown and any mixture, in linear light, of the sample's own
 * look and that of another sample which is within reach and faces the same side. errors has room
 * for samples->count values. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_color_errors_find(const psplat_surface *surface, const psplat_samples *samples,
                                       const float *shown, double reach, double limit,
                                       double *errors);

/* Finds the least and the greatest of each value of the looks within reach of some samples (count
 * indices), those that face the same side: ranges has 2 x PSPLAT_LOOK_VALUES for each, the least
 * first, colours as sRGB. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_color_ranges_find(const psplat_samples *samples, double reach,
                                       const uint32_t *indices, size_t count, float *ranges);

#endif
