/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fit.c - least squares: the plane of a splat, its linear normal field, and the curvature that the
 * normals tell of.
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

void psplat_fit_plane(const psplat_samples *samples, const uint32_t *chosen, size_t count,
                      double mean[3], double normal[3]) {
    double sum[3] = {0, 0, 0}, covariance[6] = {0};
    const double *origin = samples->positions + 3 * (size_t)chosen[0];
    mean[0] = mean[1] = mean[2] = 0;
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, samples->positions + 3 * (size_t)chosen[i], origin);
        mad3(mean, 1 / (double)count, d);
        const float *n = samples->normals + 3 * (size_t)chosen[i];
        for (int k = 0; k < 3; ++k) sum[k] += (double)n[k];
    }
    for (size_t i = 0; i < count; ++i) {
        double d[3];
        sub3(d, samples->positions + 3 * (size_t)chosen[i], origin);
        mad3(d, -1, mean);
        covariance[0] += d[0] * d[0], covariance[1] += d[0] * d[1], covariance[2] += d[0] * d[2];
        covariance[3] += d[1] * d[1], covariance[4] += d[1] * d[2], covariance[5] += d[2] * d[2];
    }
    mad3(mean, 1, origin);
    double values[3], vectors[3][3], length = normalize3(sum);
    psplat_fit_eigen(covariance, values, vectors);
    double facing = dot3(vectors[0], sum);
    /* A row of samples, or normals across the plane, say nothing about it: trust the normals. */
    int spans = values[1] > 1e-4 * values[2] && values[0] < 0.25 * values[1];
    if (length > 0 && (!spans || fabs(facing) < 0.5)) {
        memcpy(normal, sum, 3 * sizeof(double));
        return;
    }
    for (int k = 0; k < 3; ++k) normal[k] = facing < 0 ? -vectors[0][k] : vectors[0][k];
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

/* ---- curvature ----------------------------------------------------------------------------- */

void psplat_fit_curvature(const double (*st)[2], const double (*xy)[2], size_t count,
                          double direction[2], double curvature[2]) {
    double mean[4] = {0}, a = 0, b = 0, c = 0, r[2][2] = {{0}};
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 2; ++k)
            mean[k] += st[i][k] / (double)count, mean[2 + k] += xy[i][k] / (double)count;
    for (size_t i = 0; i < count; ++i) {
        double s = st[i][0] - mean[0], t = st[i][1] - mean[1];
        a += s * s, b += s * t, c += t * t;
        for (int k = 0; k < 2; ++k) {
            double value = xy[i][k] - mean[2 + k];
            r[k][0] += value * s, r[k][1] += value * t;
        }
    }
    direction[0] = 1, direction[1] = curvature[0] = curvature[1] = 0;
    double det = a * c - b * b;
    if (!(det > 1e-8 * (a + c) * (a + c))) return;
    /* Gradient rows of x and y over (s, t); its symmetric part is the curvature tensor. */
    double xs = (r[0][0] * c - r[0][1] * b) / det, xt = (r[0][1] * a - r[0][0] * b) / det;
    double ys = (r[1][0] * c - r[1][1] * b) / det, yt = (r[1][1] * a - r[1][0] * b) / det;
    double off = (xt + ys) / 2, angle = 0.5 * atan2(2 * off, xs - yt);
    double middle = (xs + yt) / 2, spread = hypot((xs - yt) / 2, off);
    int first = middle >= 0; /* the eigenvalue of greater magnitude is middle +- spread */
    direction[0] = first ? cos(angle) : -sin(angle);
    direction[1] = first ? sin(angle) : cos(angle);
    curvature[0] = fabs(first ? middle + spread : middle - spread);
    curvature[1] = fabs(first ? middle - spread : middle + spread);
}
