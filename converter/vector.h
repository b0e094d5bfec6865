/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vector.h - the few operations on double[3] that the stages share.
 */
#ifndef PHONGSPLAT_VECTOR_H
#define PHONGSPLAT_VECTOR_H

#include <math.h>

/* Of numbers only: fmin and fmax are calls, since they must look for NaN. */
static inline double min2(double a, double b) {
    return b < a ? b : a;
}

static inline double max2(double a, double b) {
    return b > a ? b : a;
}

static inline double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void sub3(double r[3], const double a[3], const double b[3]) {
    for (int k = 0; k < 3; ++k) r[k] = a[k] - b[k];
}

/* r += s * a */
static inline void mad3(double r[3], double s, const double a[3]) {
    for (int k = 0; k < 3; ++k) r[k] += s * a[k];
}

static inline void cross3(double r[3], const double a[3], const double b[3]) {
    double x = a[1] * b[2] - a[2] * b[1];
    double y = a[2] * b[0] - a[0] * b[2];
    double z = a[0] * b[1] - a[1] * b[0];
    r[0] = x, r[1] = y, r[2] = z;
}

static inline double length3(const double a[3]) {
    return sqrt(dot3(a, a));
}

/* Scales a to unit length and returns its former length; a zero vector stays zero. */
static inline double normalize3(double a[3]) {
    double length = length3(a);
    if (length > 0)
        for (int k = 0; k < 3; ++k) a[k] /= length;
    return length;
}

/* A unit vector perpendicular to the unit vector n. */
static inline void perpendicular3(double r[3], const double n[3]) {
    int least = fabs(n[0]) < fabs(n[1]) ? (fabs(n[0]) < fabs(n[2]) ? 0 : 2)
                                        : (fabs(n[1]) < fabs(n[2]) ? 1 : 2);
    double axis[3] = {0, 0, 0};
    axis[least] = 1;
    cross3(r, n, axis);
    normalize3(r);
}

#endif
