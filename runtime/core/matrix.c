/* SPDX-License-Identifier: MIT
 *
 * matrix.c - products, inverses and stretches of 4 x 4 matrices of doubles.
 */
#include "core/matrix.h"

#include <math.h>
#include <string.h>

void psplat_matrix_multiply(const double a[16], const double b[16], double product[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0.0;
            for (int k = 0; k < 4; ++k) sum += a[k * 4 + row] * b[column * 4 + k];
            product[column * 4 + row] = sum;
        }
}

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

double psplat_matrix_determinant3(const double m[16]) {
    double c[3];
    cross(m + 4, m + 8, c);
    return psplat_dot3(m, c);
}

/* The columns of det(M) M^-T are the cross products of M's columns. */
void psplat_matrix_normal(const double m[16], double det, double normal[9]) {
    cross(m + 4, m + 8, normal);
    cross(m + 8, m, normal + 3);
    cross(m, m + 4, normal + 6);
    double scale = cbrt(fabs(det)) / det;
    for (int i = 0; i < 9; ++i) normal[i] *= scale;
}

/* The largest eigenvalue of the matrix of products of columns, whose greatest number was made 1, by
 * the trigonometric formula (Smith 1961, "Eigenvalues of a symmetric 3 x 3 matrix"). */
double psplat_matrix_stretch(const double m[16]) {
    double largest = 0.0, columns[3][3], a[3][3];
    for (int i = 0; i < 12; ++i)
        if (i % 4 < 3 && !(fabs(m[i]) <= largest)) largest = fabs(m[i]);
    if (!(largest > 0.0) || !isfinite(largest)) return largest;
    for (int i = 0; i < 9; ++i) columns[i / 3][i % 3] = m[i / 3 * 4 + i % 3] / largest;
    for (int i = 0; i < 9; ++i) a[i / 3][i % 3] = psplat_dot3(columns[i / 3], columns[i % 3]);
    double mean = (a[0][0] + a[1][1] + a[2][2]) / 3.0, squares = 0.0;
    for (int i = 0; i < 3; ++i) {
        a[i][i] -= mean;
        squares += psplat_dot3(a[i], a[i]);
    }
    double p = sqrt(squares / 6.0), c[3];
    if (!(p > 0.0)) return largest * sqrt(mean);
    cross(a[1], a[2], c);
    double half_determinant = psplat_dot3(a[0], c) / (p * p * p) / 2.0;
    double angle = acos(fmin(fmax(half_determinant, -1.0), 1.0)) / 3.0;
    return largest * sqrt(mean + 2.0 * p * cos(angle));
}

/* Applies Gauss-Jordan elimination with row pivoting to [m | 1]. */
int psplat_matrix_invert(const double m[16], double inverse[16]) {
    double rows[4][8] = {{0}};
    for (int i = 0; i < 16; ++i) rows[i % 4][i / 4] = m[i];
    for (int i = 0; i < 4; ++i) rows[i][4 + i] = 1.0;

    for (int column = 0; column < 4; ++column) {
        int pivot = column;
        for (int row = column + 1; row < 4; ++row)
            if (fabs(rows[row][column]) > fabs(rows[pivot][column])) pivot = row;
        double scale = 1.0 / rows[pivot][column];
        if (!isfinite(scale) || scale == 0.0) return 0;

        double swapped[8];
        memcpy(swapped, rows[pivot], sizeof swapped);
        memcpy(rows[pivot], rows[column], sizeof swapped);
        for (int k = 0; k < 8; ++k) rows[column][k] = swapped[k] * scale;
        for (int row = 0; row < 4; ++row) {
            double factor = row == column ? 0.0 : rows[row][column];
            for (int k = 0; k < 8; ++k) rows[row][k] -= factor * rows[column][k];
        }
    }
    for (int i = 0; i < 16; ++i) inverse[i] = rows[i % 4][4 + i / 4];
    return 1;
}

void psplat_matrix_basis(const double z[3], double x[3], double y[3]) {
    double sign = copysign(1.0, z[2]), a = -1.0 / (sign + z[2]), b = z[0] * z[1] * a;
    x[0] = 1.0 + sign * z[0] * z[0] * a;
    x[1] = sign * b;
    x[2] = -sign * z[0];
    y[0] = b;
    y[1] = sign + z[1] * z[1] * a;
    y[2] = -z[1];
}

void psplat_matrix_to_float(const double *m, int count, float *out) {
    for (int i = 0; i < count; ++i) out[i] = (float)m[i];
}
