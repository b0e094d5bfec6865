/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sample_spacing.h - the choice of the sample spacing, as fine as the limits make splats small.
 */
#ifndef PHONGSPLAT_SELECT_SAMPLE_SPACING_H
#define PHONGSPLAT_SELECT_SAMPLE_SPACING_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Draws c->samples with a spacing that gives each splat about 60 of them, between c->finest and
 * ten times that (three times where splats are flat), and sets c->limits.margin. Errors: MEMORY,
 * RANGE (too many samples). */
psplat_result psplat_draw_samples_for_limits(psplat_conversion *c, psplat_error *error);

#endif
