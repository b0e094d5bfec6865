/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sort_values.h - the sorting of many numbers, faster than by comparisons.
 */
#ifndef PHONGSPLAT_BASE_SORT_VALUES_H
#define PHONGSPLAT_BASE_SORT_VALUES_H

#include <stddef.h>

/* Sorts values that are at least 0 in rising order. */
void psplat_sort_values(double *values, size_t count);

#endif
