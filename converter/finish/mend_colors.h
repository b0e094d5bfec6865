/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mend_colors.h - splats that blend to other colours than the surface has give way to smaller ones.
 */
#ifndef PHONGSPLAT_FINISH_MEND_COLORS_H
#define PHONGSPLAT_FINISH_MEND_COLORS_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Blends the taken candidates, which are all of the selection, at random points of the surface, as
 * dense as the baked texels within a bound. Where too many points show what the surface does not
 * look like (measure/color_errors.h), they become samples, and the candidates that show it are
 * replaced by others which are right at these points. Does nothing where neither colours nor
 * finishes vary or no tolerance is given. last: 1 after all splats have been extended, which spends
 * a part of what may be wrong. Errors: MEMORY, INTERRUPTED, RANGE (too many samples). */
psplat_result psplat_mend_colors(psplat_conversion *c, int last, psplat_error *error);

#endif
