/* SPDX-License-Identifier: MIT
 *
 * algebra.c - vectors of three doubles and column-major 4 x 4 matrices, as far as the reference
 * rasteriser needs them. It has its own so that it shares no code with what it tests.
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

void psplat_oracle_cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

void psplat_oracle_normalise(double a[3]) {
    double length = psplat_oracle_length(a);
    if (!(length > 0)) return;
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

void psplat_oracle_multiply(const double a[16], const double b[16], double out[16]) {
    for (int column = 0; column < 4; ++column)
        psplat_oracle_transform(a, b + column * 4, b[column * 4 + 3], out + column * 4);
}

/* Swaps rows a and b of both halves of the elimination. */
static void swap_rows(double m[16], double inverse[16], int a, int b) {
    for (int column = 0; column < 4; ++column) {
        double kept = m[column * 4 + a], kept_inverse = inverse[column * 4 + a];
        m[column * 4 + a] = m[column * 4 + b];
        inverse[column * 4 + a] = inverse[column * 4 + b];
        m[column * 4 + b] = kept;
        inverse[column * 4 + b] = kept_inverse;
    }
}

/* Turns column `pivot` of m into a unit vector by row operations, and applies them to inverse too.
 */
static void eliminate(double m[16], double inverse[16], int pivot) {
    double scale = 1 / m[pivot * 4 + pivot];
    for (int column = 0; column < 4; ++column) {
        m[column * 4 + pivot] *= scale;
        inverse[column * 4 + pivot] *= scale;
    }
    for (int row = 0; row < 4; ++row) {
        double factor = m[pivot * 4 + row];
        if (row == pivot || factor == 0) continue;
        for (int column = 0; column < 4; ++column) {
            m[column * 4 + row] -= factor * m[column * 4 + pivot];
            inverse[column * 4 + row] -= factor * inverse[column * 4 + pivot];
        }
    }
}

/* Gauss-Jordan elimination with partial pivoting keeps the zeros of an affine matrix exactly 0. */
int psplat_oracle_invert(const double m[16], double out[16]) {
    double work[16];
    memcpy(work, m, sizeof work);
    for (int i = 0; i < 16; ++i) out[i] = i % 5 == 0;
    for (int pivot = 0; pivot < 4; ++pivot) {
        int best = pivot;
        for (int row = pivot + 1; row < 4; ++row)
            if (fabs(work[pivot * 4 + row]) > fabs(work[pivot * 4 + best])) best = row;
        if (work[pivot * 4 + best] == 0) return 0;
        swap_rows(work, out, pivot, best);
        eliminate(work, out, pivot);
    }
    for (int i = 0; i < 16; ++i)
        if (!isfinite(out[i])) return 0;
    return 1;
}
