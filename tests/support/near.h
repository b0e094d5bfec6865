/* SPDX-License-Identifier: MIT
 *
 * near.h - comparison of doubles, which cmocka would round to float. Include this file after
 * cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_NEAR_H
#define PHONGSPLAT_TEST_NEAR_H

#include <math.h>

/* Fails the test unless |a - b| <= tolerance. NaN is within no tolerance of anything. */
#define assert_near(a, b, tolerance) near_check((a), (b), (tolerance), __FILE__, __LINE__)

static inline void near_check(double a, double b, double tolerance, const char *file, int line) {
    if (fabs(a - b) <= tolerance) return;
    print_error("%.17g and %.17g differ by %.3g, allowed %.3g\n", a, b, fabs(a - b), tolerance);
    _fail(file, line);
}

#endif
