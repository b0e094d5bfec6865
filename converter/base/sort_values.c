/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * sort_values.c - the sorting of many numbers, by the digits of their bits: those of IEEE numbers
 * without a sign are in the order of the numbers.
 */
#include "base/sort_values.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* A digit, and how many make up the 64 bits. */
enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS, PASSES = 6 };

/* Below so many, comparisons take less time than counting digits. */
enum { LEAST_COUNTED = 1000 };

static int compare_values(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return a < b ? -1 : a > b;
}

static size_t digit_of(double value, int pass) {
    uint64_t bits;
    value += 0; /* -0 becomes 0. */
    memcpy(&bits, &value, sizeof bits);
    return (size_t)(bits >> (DIGIT_BITS * pass)) & (DIGITS - 1);
}

/* Sorts by one digit from one array to the other, keeping the order of equals. Returns 0, and does
 * nothing, where all values have the same. */
static int sort_by_digit(const double *from, size_t count, int pass, double *to) {
    size_t starts[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < count; ++i) ++starts[digit_of(from[i], pass)];
    if (starts[digit_of(from[0], pass)] == count) return 0;
    for (size_t d = 0; d < DIGITS; ++d) {
        size_t size = starts[d];
        starts[d] = sum;
        sum += size;
    }
    for (size_t i = 0; i < count; ++i) to[starts[digit_of(from[i], pass)]++] = from[i];
    return 1;
}

void psplat_sort_values(double *values, size_t count) {
    double *other = count < LEAST_COUNTED ? NULL : malloc(count * sizeof *other);
    if (!other) { /* Without memory it only takes longer. */
        qsort(values, count, sizeof *values, compare_values);
        return;
    }
    double *from = values, *to = other;
    for (int pass = 0; pass < PASSES; ++pass) {
        if (!sort_by_digit(from, count, pass, to)) continue;
        double *swap = from;
        from = to, to = swap;
    }
    if (from != values) memcpy(values, from, count * sizeof *values);
    free(other);
}
