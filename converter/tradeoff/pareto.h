/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * pareto.h - the settings that nothing else beats.
 */
#ifndef PHONGSPLAT_TRADEOFF_PARETO_H
#define PHONGSPLAT_TRADEOFF_PARETO_H

#include "table/row.h"
#include "table/setting.h"

/* Tells whether a is at most as great as b in all columns and smaller in one. */
int psplat_pareto_beats(const psplat_row *a, const psplat_row *b, const psplat_column *columns,
                        size_t column_count);
/* Marks the rows of one competitor that no other of them beats. Rows that lack a value are not on
 * the front; equal rows all are. */
void psplat_pareto_mark(const psplat_row *rows, size_t count, psplat_competitor competitor,
                        const psplat_column *columns, size_t column_count, uint8_t *is_front);
/* Writes the indices of marked rows by ascending value of a column into order, of equal ones the
 * first alone. Returns how many. */
size_t psplat_pareto_sort(const psplat_row *rows, size_t count, const uint8_t *is_front,
                          psplat_column by, size_t *order);
/* Returns the position in order of the knee of a sorted front. That is the row farthest below the
 * straight line between its ends, where both columns are logarithms: before it a little more of x
 * buys much less of y, after it much more buys little. Of two rows it is
 * the second, unless that takes more times as much of x as it divides y by. */
size_t psplat_pareto_knee(const psplat_row *rows, const size_t *order, size_t order_count,
                          psplat_column x, psplat_column y);

#endif
