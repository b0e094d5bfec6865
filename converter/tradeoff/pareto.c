/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * pareto.c - the settings that no other beats, and where their front bends.
 */
#include "tradeoff/pareto.h"

#include "table/row.h"
#include "table/setting.h"

#include <math.h>
#include <stdlib.h>

static int is_complete(const psplat_row *row, psplat_competitor competitor,
                       const psplat_column *columns, size_t column_count) {
    if (row->setting.competitor != competitor) return 0;
    for (size_t i = 0; i < column_count; ++i)
        if (isnan(row->values[columns[i]])) return 0;
    return 1;
}

int psplat_pareto_beats(const psplat_row *a, const psplat_row *b, const psplat_column *columns,
                        size_t column_count) {
    int is_less = 0;
    for (size_t i = 0; i < column_count; ++i) {
        double x = a->values[columns[i]], y = b->values[columns[i]];
        if (x > y) return 0;
        is_less |= x < y;
    }
    return is_less;
}

void psplat_pareto_mark(const psplat_row *rows, size_t count, psplat_competitor competitor,
                        const psplat_column *columns, size_t column_count, uint8_t *is_front) {
    for (size_t i = 0; i < count; ++i) {
        is_front[i] = (uint8_t)is_complete(&rows[i], competitor, columns, column_count);
        for (size_t k = 0; k < count && is_front[i]; ++k)
            if (is_complete(&rows[k], competitor, columns, column_count) &&
                psplat_pareto_beats(&rows[k], &rows[i], columns, column_count))
                is_front[i] = 0;
    }
}

/* Rows are few: an insertion keeps equal ones in order. */
size_t psplat_pareto_sort(const psplat_row *rows, size_t count, const uint8_t *is_front,
                          psplat_column by, size_t *order) {
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!is_front[i]) continue;
        double value = rows[i].values[by];
        size_t at = used;
        while (at && rows[order[at - 1]].values[by] > value) --at;
        if (at && rows[order[at - 1]].values[by] == value) continue;
        for (size_t k = used; k > at; --k) order[k] = order[k - 1];
        order[at] = i;
        ++used;
    }
    return used;
}

/* Zeros and negatives have no logarithm; they are taken for the least there is. */
static double logarithm(double value) {
    return log(fmax(value, 1e-12));
}

/* Logarithms of equal ratios differ by as much. */
static const double rounding = 1e-9;

size_t psplat_pareto_knee(const psplat_row *rows, const size_t *order, size_t order_count,
                          psplat_column x, psplat_column y) {
    if (order_count < 2) return 0;
    const double *first = rows[order[0]].values, *last = rows[order[order_count - 1]].values;
    double width = logarithm(last[x]) - logarithm(first[x]);
    double height = logarithm(last[y]) - logarithm(first[y]);
    if (order_count == 2) return width <= -height + rounding;
    size_t knee = order_count - 1;
    double deepest = 0;
    for (size_t i = 1; i + 1 < order_count; ++i) {
        const double *values = rows[order[i]].values;
        double along = (logarithm(values[x]) - logarithm(first[x])) / width;
        double depth = logarithm(first[y]) + along * height - logarithm(values[y]);
        if (!(depth > deepest)) continue;
        deepest = depth;
        knee = i;
    }
    return knee;
}
