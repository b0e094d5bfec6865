/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * statistics.c - statistics of samples: greatest value, root mean square, 95th percentile. Sums run
 * over sorted values, so that the order of the samples does not matter.
 */
#include "compare/statistics.h"

#include "base/sort_values.h"

#include <math.h>

static double mean_square(const double *values, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += values[i] * values[i];
    return sum / (double)count;
}

/* Returns the index of the least value that 95 % of the sorted values do not exceed. */
static size_t index95(size_t count) {
    return (count * 95 + 99) / 100 - 1;
}

psplat_statistics psplat_statistics_of(double *values, size_t count, size_t *kept) {
    size_t given = 0;
    for (size_t i = 0; i < count; ++i)
        if (values[i] >= 0) values[given++] = values[i];
    if (kept) *kept = given;
    if (!given) return (psplat_statistics){0};
    psplat_sort_values(values, given);
    return (psplat_statistics){values[given - 1], sqrt(mean_square(values, given)),
                               values[index95(given)]};
}

static double greater(double a, double b) {
    return a > b ? a : b;
}

psplat_statistics psplat_statistics_both(const double *a, size_t a_count, const double *b,
                                         size_t b_count) {
    if (!a_count) a = b, a_count = b_count;
    if (!b_count) b = a, b_count = a_count;
    if (!a_count) return (psplat_statistics){0};
    size_t i = 0, j = 0;
    double p95 = 0;
    /* Merges both sets in rising order until 95 % of their weight is passed. */
    while ((double)i / (double)a_count + (double)j / (double)b_count < 2 * 0.95)
        p95 = j == b_count || (i < a_count && a[i] <= b[j]) ? a[i++] : b[j++];
    return (psplat_statistics){greater(a[a_count - 1], b[b_count - 1]),
                               sqrt((mean_square(a, a_count) + mean_square(b, b_count)) / 2), p95};
}
