/* SPDX-License-Identifier: MIT
 *
 * extreme.h - measured figures of tests of extremes. Each is printed in a line that
 * tests/extremes.sh puts into a table, and must stay within its bound. Include this file after
 * cmocka.h; tests that include it by name get ctest's label "extremes".
 */
#ifndef PHONGSPLAT_TEST_EXTREME_H
#define PHONGSPLAT_TEST_EXTREME_H

/* name says what is extreme, unit what is measured and in which unit. A NaN stays within no
 * bound. */
static inline void extreme_at_most(const char *name, double figure, const char *unit,
                                   double bound) {
    print_message("extreme: %s: %.2g %s (bound %.6g)\n", name, figure, unit, bound);
    if (!(figure <= bound)) fail_msg("%s: %g %s is more than %g", name, figure, unit, bound);
}

#endif
