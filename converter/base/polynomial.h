/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * polynomial.h - real roots of polynomials of one variable.
 */
#ifndef PHONGSPLAT_BASE_POLYNOMIAL_H
#define PHONGSPLAT_BASE_POLYNOMIAL_H

#include <stddef.h>

/* The greatest degree of a polynomial. */
enum { PSPLAT_MAX_DEGREE = 5 };

/* Returns the value at x of the polynomial of this degree; c[k] is the coefficient of x^k. */
double psplat_polynomial_at(const double *c, size_t degree, double x);

/* Stores the roots in low ... high, ascending, of a polynomial of a degree of at most
 * PSPLAT_MAX_DEGREE. A double root may be missing. Returns their number, which is 0 for a
 * polynomial that is 0 everywhere. roots has room for `degree`. */
size_t psplat_polynomial_roots(const double *c, size_t degree, double low, double high,
                               double *roots);

#endif
