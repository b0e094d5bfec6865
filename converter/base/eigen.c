/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * eigen.c - eigenvalues and eigenvectors of symmetric 3 x 3 matrices, by cyclic Jacobi rotations
 * (Golub, Van Loan, Matrix Computations, section 8.4).
 */
#include "base/eigen.h"

#include <math.h>
#include <string.h>

/* Rotates rows and columns p and q of the symmetric matrix m so that m[p][q] becomes 0, and applies
 * the rotation to the eigenvectors found so far. */
static void jacobi_rotate(double m[3][3], double vectors[3][3], int p, int q) {
    if (m[p][q] == 0) return;
    double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
    double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    double c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < 3; ++k) {
        double a = m[p][k], b = m[q][k];
        m[p][k] = c * a - s * b, m[q][k] = s * a + c * b;
    }
    for (int k = 0; k < 3; ++k) {
        double a = m[k][p], b = m[k][q];
        m[k][p] = c * a - s * b, m[k][q] = s * a + c * b;
        a = vectors[p][k], b = vectors[q][k];
        vectors[p][k] = c * a - s * b, vectors[q][k] = s * a + c * b;
    }
}

/* Puts the eigenvalues of rows a and b in ascending order. */
static void order_rows(double values[3], double vectors[3][3], int a, int b) {
    if (values[a] <= values[b]) return;
    double value = values[a], row[3];
    values[a] = values[b], values[b] = value;
    memcpy(row, vectors[a], sizeof row);
    memcpy(vectors[a], vectors[b], sizeof row);
    memcpy(vectors[b], row, sizeof row);
}

void psplat_eigen(const double matrix[6], double values[3], double vectors[3][3]) {
    double m[3][3] = {{matrix[0], matrix[1], matrix[2]},
                      {matrix[1], matrix[3], matrix[4]},
                      {matrix[2], matrix[4], matrix[5]}};
    memset(vectors, 0, 9 * sizeof(double));
    for (int k = 0; k < 3; ++k) vectors[k][k] = 1;
    double scale = fabs(m[0][0]) + fabs(m[1][1]) + fabs(m[2][2]);
    for (int sweep = 0; sweep < 12; ++sweep) {
        if (fabs(m[0][1]) + fabs(m[0][2]) + fabs(m[1][2]) <= 1e-17 * scale) break;
        jacobi_rotate(m, vectors, 0, 1);
        jacobi_rotate(m, vectors, 0, 2);
        jacobi_rotate(m, vectors, 1, 2);
    }
    for (int k = 0; k < 3; ++k) values[k] = m[k][k];
    order_rows(values, vectors, 0, 1);
    order_rows(values, vectors, 1, 2);
    order_rows(values, vectors, 0, 1);
}
