/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mend_creases.h - splats that reach too far over a crease shrink.
 */
#ifndef PHONGSPLAT_FINISH_MEND_CREASES_H
#define PHONGSPLAT_FINISH_MEND_CREASES_H

#include <phongsplat/splat.h>

#include "base/region.h"
#include "select/conversion.h"

/* Shrinks taken candidates, which are all of the selection, in which a crease of their own sheet
 * lies deeper than the tolerance (measure/crease_crossings.h), and covers what they leave. A fit
 * gives a splat lines where creases lie inside it, by the samples and creases around its seed, but
 * discs of the last resort and splats that are extended later may reach one that they did not see.
 * Without this, a single such place made a file several times as large, since it was written with
 * floats. Errors: MEMORY, INTERRUPTED, RANGE (too many samples). */
psplat_result psplat_mend_creases(psplat_conversion *c, psplat_error *error);

/* Gives the candidates in which creases lie deeper than the tolerance now the regions that they had
 * before, by index. For those whose lines have been moved out (close_seams.h, close_cracks.h) or
 * opened (open_seams.h): a line that may reach a little over its own crease may meet another one
 * there, and so may what goes on beyond a seam. Errors: MEMORY. */
psplat_result psplat_take_back_crossings(psplat_conversion *c, const psplat_region *before);

#endif
