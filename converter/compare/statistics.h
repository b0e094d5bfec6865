/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * statistics.h - statistics of samples: greatest value, root mean square, 95th percentile.
 */
#ifndef PHONGSPLAT_COMPARE_STATISTICS_H
#define PHONGSPLAT_COMPARE_STATISTICS_H

#include <stddef.h>

/* Statistics of area-weighted samples: greatest value, root mean square, 95th percentile. */
typedef struct psplat_statistics {
    double max, rms, p95;
} psplat_statistics;

/* Returns the statistics of the values that are not negative, or zeros where there are none. Sorts
 * these values to the front of the array and stores their number in *kept, which may be NULL. */
psplat_statistics psplat_statistics_of(double *values, size_t count, size_t *kept);
/* Returns the statistics of two sets together, each with half of the weight; where one set is
 * empty, those of the other. The values must be sorted and not negative. */
psplat_statistics psplat_statistics_both(const double *a, size_t a_count, const double *b,
                                         size_t b_count);

#endif
