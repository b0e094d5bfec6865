/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mend_textures.h - splats over which textures slide too far give way to smaller ones.
 */
#ifndef PHONGSPLAT_FINISH_MEND_TEXTURES_H
#define PHONGSPLAT_FINISH_MEND_TEXTURES_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Measures at random points how far kept textures slide under the taken candidates, which are all
 * of the selection (measure/texture_slides.h). Where they slide too far at too many points, these
 * become samples, and the candidates that show it are replaced by others, which see these samples.
 * Does nothing where no textures are kept. last: 1 after all splats have been extended, which
 * spends a part of what may slide. Errors: MEMORY, INTERRUPTED, RANGE (too many samples). */
psplat_result psplat_mend_textures(psplat_conversion *c, int last, psplat_error *error);

/* Measures the same after the lines of candidates have been moved out (close_seams.h,
 * close_cracks.h). Where textures slide too far at too many points now, the candidates that show
 * most of these get the regions that they had before, by index: on parts that are thinner than the
 * tolerance, what laps over the border of a chart lies before the whole of another one. Does
 * nothing where no textures are kept. Errors: MEMORY. */
psplat_result psplat_take_back_slides(psplat_conversion *c, const psplat_region *before);

#endif
