/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * spread.h - what many values come down to.
 */
#ifndef PHONGSPLAT_SPREAD_H
#define PHONGSPLAT_SPREAD_H

#include "compare.h"

/* Of the values that are not negative; sorts them to the front and returns their number in *kept
 * (may be NULL). All zeros where there is none. */
psplat_spread psplat_spread_of(double *values, size_t count, size_t *kept);
/* Of two sets, sorted and not negative, each weighing one half; where one has none, of the other.
 */
psplat_spread psplat_spread_both(const double *a, size_t a_count, const double *b, size_t b_count);

#endif
