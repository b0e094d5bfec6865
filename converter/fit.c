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

/* Least-norm least-squares solution of the 2x2 normal equations (count, s; s, ss) (x; y) = (t; ts)
 * by the pseudo-inverse of the symmetric matrix (BSK04 eq. 3, 4). */
static void solve_pair(double count, double s, double ss, double t, double ts, double *x,
                       double *y) {
    double middle = (count + ss) / 2, spread = hypot((count - ss) / 2, s);
    double angle = 0.5 * atan2(2 * s, count - ss), c = cos(angle), n = sin(angle);
    double large = middle + spread, little = large > 0 ? (count * ss - s * s) / large : 0;
    double along = c * t + n * ts, across = c * ts - n * t;
    double p = large > 0 ? along / large : 0;
    double q = little > 1e-9 * large ? across / little : 0;
    *x = c * p - n * q;
    *y = n * p + c * q;
}

void psplat_fit_normals(const double (*uv)[2], const double (*xy)[2], size_t count,
                        double field[4]) {
    for (int k = 0; k < 2; ++k) {
        double s = 0, ss = 0, t = 0, ts = 0;
        for (size_t i = 0; i < count; ++i) {
            s += uv[i][k], ss += uv[i][k] * uv[i][k];
            t += xy[i][k], ts += xy[i][k] * uv[i][k];
        }
        solve_pair((double)count, s, ss, t, ts, &field[k], &field[2 + k]);
    }
}

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
