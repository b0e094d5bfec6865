/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fit.c - least squares: eigenvectors of small matrices and the linear normal field of a splat.
 */
#include "stages.h"
#include "vector.h"

#include <string.h>

/* Rotates rows p and q of the symmetric matrix m to make m[p][q] zero (Golub, Van Loan 8.4). */
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

static void swap_rows(double values[3], double vectors[3][3], int a, int b) {
    if (values[a] <= values[b]) return;
    double value = values[a], row[3];
    values[a] = values[b], values[b] = value;
    memcpy(row, vectors[a], sizeof row);
    memcpy(vectors[a], vectors[b], sizeof row);
    memcpy(vectors[b], row, sizeof row);
}

void psplat_fit_eigen(const double matrix[6], double values[3], double vectors[3][3]) {
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
    swap_rows(values, vectors, 0, 1);
    swap_rows(values, vectors, 1, 2);
    swap_rows(values, vectors, 0, 1);
}

/* ---- the normal field ---------------------------------------------------------------------- */

/* Greatest sum of slopes that a fitted field may have (spec 3.5 allows 20). */
static const double greatest_slope = 19.9;

enum { UNKNOWNS = 5 }; /* x, y, alpha, beta, gamma */

/* Factor of gamma in x per unit of v: makes the gradient symmetric in physical units. */
static double field_ratio(const double radius[2]) {
    return radius[0] > 0 ? radius[1] / radius[0] : 1;
}

/* Normal equations of x + alpha u + gamma ratio v and y + gamma u + beta v, one each a sample. */
static void normal_equations(const double (*uv)[2], const double (*xy)[2], size_t count,
                             double ratio, double m[UNKNOWNS][UNKNOWNS], double right[UNKNOWNS]) {
    double n = (double)count, u = 0, v = 0, uu = 0, w = 0, vv = 0;
    memset(right, 0, UNKNOWNS * sizeof *right);
    for (size_t i = 0; i < count; ++i) {
        const double *a = uv[i], *b = xy[i];
        u += a[0], v += a[1];
        uu += a[0] * a[0], w += a[0] * a[1], vv += a[1] * a[1];
        right[0] += b[0], right[1] += b[1];
        right[2] += a[0] * b[0], right[3] += a[1] * b[1];
        right[4] += ratio * a[1] * b[0] + a[0] * b[1];
    }
    const double rows[UNKNOWNS][UNKNOWNS] = {{n, 0, u, 0, ratio * v},
                                             {0, n, 0, v, u},
                                             {u, 0, uu, 0, ratio * w},
                                             {0, v, 0, vv, w},
                                             {ratio * v, u, ratio * w, w, ratio * ratio * vv + uu}};
    memcpy(m, rows, sizeof rows);
}

/* Factors m + shift I = L D L^T in place: L below the diagonal, D on it. */
static void factor(double m[UNKNOWNS][UNKNOWNS], double shift) {
    for (int i = 0; i < UNKNOWNS; ++i) {
        m[i][i] += shift;
        for (int j = 0; j < i; ++j) {
            for (int k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k] * m[k][k];
            m[i][j] /= m[j][j];
        }
        for (int k = 0; k < i; ++k) m[i][i] -= m[i][k] * m[i][k] * m[k][k];
    }
}

/* Adds (L D L^T)^-1 right to x. */
static void add_solution(const double l[UNKNOWNS][UNKNOWNS], const double right[UNKNOWNS],
                         double x[UNKNOWNS]) {
    double y[UNKNOWNS];
    for (int i = 0; i < UNKNOWNS; ++i) {
        y[i] = right[i];
        for (int k = 0; k < i; ++k) y[i] -= l[i][k] * y[k];
    }
    for (int i = 0; i < UNKNOWNS; ++i) y[i] /= l[i][i];
    for (int i = UNKNOWNS; i-- > 0;) {
        for (int k = i + 1; k < UNKNOWNS; ++k) y[i] -= l[k][i] * y[k];
        x[i] += y[i];
    }
}

/* Least-norm solution of the positive semidefinite system m x = right by iterated Tikhonov
 * regularisation (Riley 1956): each step takes the part of the solution along an eigenvector of
 * eigenvalue e to within shift / (e + shift) of the step before, and leaves that of eigenvalue 0
 * at 0. No threshold decides about ranks, so that a field changes smoothly with its samples. */
static void solve_least_norm(double m[UNKNOWNS][UNKNOWNS], const double right[UNKNOWNS],
                             double x[UNKNOWNS]) {
    enum { STEPS = 3 };
    double l[UNKNOWNS][UNKNOWNS], rest[UNKNOWNS], trace = 0;
    for (int i = 0; i < UNKNOWNS; ++i) trace += m[i][i];
    memcpy(l, m, sizeof l);
    factor(l, 1e-9 * trace);
    memset(x, 0, sizeof rest);
    for (int step = 0; step < STEPS; ++step) {
        for (int i = 0; i < UNKNOWNS; ++i) {
            rest[i] = right[i];
            for (int k = 0; k < UNKNOWNS; ++k) rest[i] -= m[i][k] * x[k];
        }
        add_solution((const double(*)[UNKNOWNS])l, rest, x);
    }
}

void psplat_fit_normals(const double (*uv)[2], const double (*xy)[2], size_t count,
                        const double radius[2], double field[5]) {
    double m[UNKNOWNS][UNKNOWNS], right[UNKNOWNS], ratio = field_ratio(radius);
    normal_equations(uv, xy, count, ratio, m, right);
    solve_least_norm(m, right, field);
    double gradient =
        field[2] * field[2] + field[3] * field[3] + field[4] * field[4] * (1 + ratio * ratio);
    if (hypot(field[0], field[1]) + sqrt(gradient) <= greatest_slope) return;
    for (int k = 0; k < 2; ++k) field[k] = right[k] / (double)count;
    field[2] = field[3] = field[4] = 0;
}

void psplat_fit_normal_at(const double field[5], const double radius[2], const double uv[2],
                          double xy[2]) {
    xy[0] = field[0] + field[2] * uv[0] + field[4] * field_ratio(radius) * uv[1];
    xy[1] = field[1] + field[4] * uv[0] + field[3] * uv[1];
}
