/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * polynomial.c - real roots of polynomials of one variable.
 *
 * Between two neighbouring roots of its derivative a polynomial is monotone, and has one root if
 * its signs differ there. So the roots of all derivatives are found in turn, from the line up.
 */
#include "base/polynomial.h"

#include <math.h>

/* The most steps that narrow one root. Newton's steps need a few; each other one halves. */
enum { MAX_STEPS = 100 };

double psplat_polynomial_at(const double *c, size_t degree, double x) {
    double value = c[degree];
    for (size_t k = degree; k-- > 0;) value = value * x + c[k];
    return value;
}

/* Returns the root between two places of different signs: Newton's step where it stays between
 * them, and halving otherwise. slope is the derivative, of one degree less. */
static double narrow(const double *c, const double *slope, size_t degree, double low, double high) {
    int rises = psplat_polynomial_at(c, degree, low) < 0;
    double x = 0.5 * (low + high);
    for (int step = 0; step < MAX_STEPS; ++step) {
        double value = psplat_polynomial_at(c, degree, x), before = x;
        if (value == 0) break;
        if ((value < 0) == rises)
            low = x;
        else
            high = x;
        x -= value / psplat_polynomial_at(slope, degree - 1, x);
        if (!(x > low && x < high)) x = 0.5 * (low + high);
        if (x == before || !(x > low && x < high)) break;
    }
    return x;
}

size_t psplat_polynomial_roots(const double *c, size_t degree, double low, double high,
                               double *roots) {
    double slope[PSPLAT_MAX_DEGREE + 1], ends[PSPLAT_MAX_DEGREE + 1];
    while (degree && c[degree] == 0) --degree;
    if (!degree) return 0;
    for (size_t k = 0; k < degree; ++k) slope[k] = (double)(k + 1) * c[k + 1];
    ends[0] = low;
    size_t pieces = 1 + psplat_polynomial_roots(slope, degree - 1, low, high, ends + 1), count = 0;
    for (size_t i = 0; i < pieces; ++i) {
        double from = ends[i], to = i + 1 < pieces ? ends[i + 1] : high;
        int below = psplat_polynomial_at(c, degree, from) < 0;
        if (below != (psplat_polynomial_at(c, degree, to) < 0))
            roots[count++] = narrow(c, slope, degree, from, to);
    }
    return count;
}
