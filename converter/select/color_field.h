/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * color_field.h - the choice whether the colours of splats are constant or change linearly.
 */
#ifndef PHONGSPLAT_SELECT_COLOR_FIELD_H
#define PHONGSPLAT_SELECT_COLOR_FIELD_H

#include <phongsplat/splat.h>

#include "select/conversion.h"

/* Sets c->limits.constant_colors to 0 where c->desc leaves the choice open, it is 1, and what
 * c->samples have of colours is smooth. Grows some splats as a trial. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_color_field_choose(psplat_conversion *c);

#endif
