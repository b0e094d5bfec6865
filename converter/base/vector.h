/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vector.h - vectors of three doubles: products, lengths, and distances to segments and triangles.
 *
 * Everything is inline, since the fits call it in their innermost loops.
 */
#ifndef PHONGSPLAT_BASE_VECTOR_H
#define PHONGSPLAT_BASE_VECTOR_H

#include <math.h>

/* The lesser and the greater of two numbers, neither of which may be NaN. fmin and fmax must handle
 * NaN, so that compilers make function calls of them. */
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

/* Adds s * a to r. */
static inline void mad3(double r[3], double s, const double a[3]) {
    for (int k = 0; k < 3; ++k) r[k] += s * a[k];
}

static inline void cross3(double r[3], const double a[3], const double b[3]) {
    double x = a[1] * b[2] - a[2] * b[1];
    double y = a[2] * b[0] - a[0] * b[2];
    double z = a[0] * b[1] - a[1] * b[0];
    r[0] = x, r[1] = y, r[2] = z;
}

/* Returns the length of (x, y). Unlike hypot, which is ten times slower, it overflows beyond 1e154,
 * where no length of a mesh is. */
static inline double norm2(double x, double y) {
    return sqrt(x * x + y * y);
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

/* Stores a unit vector that is perpendicular to the unit vector n. */
static inline void perpendicular3(double r[3], const double n[3]) {
    int least = fabs(n[0]) < fabs(n[1]) ? (fabs(n[0]) < fabs(n[2]) ? 0 : 2)
                                        : (fabs(n[1]) < fabs(n[2]) ? 1 : 2);
    double axis[3] = {0, 0, 0};
    axis[least] = 1;
    cross3(r, n, axis);
    normalize3(r);
}

/* Stores a + s * d. */
static inline void along3(double r[3], const double a[3], double s, const double d[3]) {
    for (int k = 0; k < 3; ++k) r[k] = a[k] + s * d[k];
}

/* Returns the squared distance of two points. */
static inline double distance2_3(const double a[3], const double b[3]) {
    double d[3];
    sub3(d, a, b);
    return dot3(d, d);
}

/* Returns the squared distance of p to the segment from a to b, which may be one point. */
static inline double point_segment_distance2(const double p[3], const double a[3],
                                             const double b[3]) {
    double ab[3], ap[3], foot[3];
    sub3(ab, b, a);
    sub3(ap, p, a);
    double length2 = dot3(ab, ab), t = length2 > 0 ? dot3(ap, ab) / length2 : 0;
    along3(foot, a, min2(max2(t, 0), 1), ab);
    return distance2_3(p, foot);
}

/* Returns the squared distance of p to the triangle a b c, which may be flat. */
static inline double point_triangle_distance2(const double p[3], const double a[3],
                                              const double b[3], const double c[3]) {
    const double *corners[3] = {a, b, c};
    double ab[3], ac[3], ap[3], n[3];
    sub3(ab, b, a);
    sub3(ac, c, a);
    sub3(ap, p, a);
    cross3(n, ab, ac);
    double area2 = dot3(n, n), least = HUGE_VAL;
    int inside = area2 > 0;
    for (int k = 0; k < 3; ++k) {
        const double *from = corners[k], *to = corners[(k + 1) % 3];
        double edge[3], d[3], side[3];
        sub3(edge, to, from);
        sub3(d, p, from);
        cross3(side, edge, d);
        if (dot3(side, n) >= 0) continue;
        inside = 0;
        least = min2(least, point_segment_distance2(p, from, to));
    }
    if (inside) return dot3(ap, n) * dot3(ap, n) / area2;
    if (least < HUGE_VAL) return least;
    for (int k = 0; k < 3; ++k)
        least = min2(least, point_segment_distance2(p, corners[k], corners[(k + 1) % 3]));
    return least;
}

/* Returns whether the segments from a to b and from c to d cross in the plane. An end on the line
 * of the other segment counts as left of it. */
static inline int segments_cross2(const double a[2], const double b[2], const double c[2],
                                  const double d[2]) {
    const double ab[2] = {b[0] - a[0], b[1] - a[1]}, cd[2] = {d[0] - c[0], d[1] - c[1]};
    int c_left = ab[0] * (c[1] - a[1]) - ab[1] * (c[0] - a[0]) >= 0;
    int d_left = ab[0] * (d[1] - a[1]) - ab[1] * (d[0] - a[0]) >= 0;
    int a_left = cd[0] * (a[1] - c[1]) - cd[1] * (a[0] - c[0]) >= 0;
    int b_left = cd[0] * (b[1] - c[1]) - cd[1] * (b[0] - c[0]) >= 0;
    return c_left != d_left && a_left != b_left;
}

#endif
