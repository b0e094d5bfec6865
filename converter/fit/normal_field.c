/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * normal_field.c - the least-squares fit of the linear normal field of a splat (spec 3.5).
 *
 * The five unknowns are the slopes at the centre and a symmetric gradient. The normal equations are
 * solved by iterated Tikhonov regularisation, since few samples may not determine all of them.
 */
#include "base/vector.h"
#include "fit/normal_field.h"

#include <math.h>
#include <string.h>

/* The greatest sum of the slope at the centre and that of the gradient; spec 3.5 allows 20. */
static const double greatest_field_slope = 19.9;

enum { UNKNOWNS = 5 }; /* x, y, alpha, beta, gamma */

/* Returns the factor of gamma v in x, which makes the gradient symmetric in lengths. */
static double field_ratio(const double radius[2]) {
    return radius[0] > 0 ? radius[1] / radius[0] : 1;
}

/* Finds the normal equations m field = right of the two equations of each sample: its x is
 * field x + alpha u + gamma ratio v, and its y is field y + gamma u + beta v. */
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

/* Factors m + shift I = L D L^T in place, with L below the diagonal and D on it. */
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

/* Finds the least-norm solution of the positive semidefinite system m x = right by iterated
 * Tikhonov regularisation (Riley 1956). Each step multiplies the error along an eigenvector of
 * eigenvalue e by shift / (e + shift), and leaves the solution along those of eigenvalue 0 at 0. No
 * threshold decides about the rank, so a field changes smoothly with its samples. */
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

void psplat_fit_normal_field(const double (*uv)[2], const double (*xy)[2], size_t count,
                             const double radius[2], double field[5]) {
    double m[UNKNOWNS][UNKNOWNS], right[UNKNOWNS], ratio = field_ratio(radius);
    normal_equations(uv, xy, count, ratio, m, right);
    solve_least_norm(m, right, field);
    double gradient =
        field[2] * field[2] + field[3] * field[3] + field[4] * field[4] * (1 + ratio * ratio);
    if (norm2(field[0], field[1]) + sqrt(gradient) <= greatest_field_slope) return;
    for (int k = 0; k < 2; ++k) field[k] = right[k] / (double)count;
    field[2] = field[3] = field[4] = 0;
}

void psplat_normal_field_at(const double field[5], const double radius[2], const double uv[2],
                            double xy[2]) {
    xy[0] = field[0] + field[2] * uv[0] + field[4] * field_ratio(radius) * uv[1];
    xy[1] = field[1] + field[4] * uv[0] + field[3] * uv[1];
}
