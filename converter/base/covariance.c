/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * covariance.c - plane, principal axes and curvature of a set of oriented points, from sums.
 *
 * The sums are the generic homogeneous covariance of Pajarola, Sainz, Guidotti (2003), section 4:
 * the sum of x x^T over x = (p, n, 1), of which the parts that fits need are kept. The covariance
 * of a union is the sum of the covariances of its parts. A fit to a union therefore costs the same
 * however many points it has. Points are relative to a local origin, since sums at an offset of 1e6
 * would lose the plane to rounding.
 */
#include "base/covariance.h"

#include "base/eigen.h"
#include "base/vector.h"

#include <math.h>
#include <string.h>

void psplat_covariance_add(psplat_covariance *c, const double p[3], const double n[3]) {
    c->count += 1;
    for (int k = 0, at = 0; k < 3; ++k) {
        c->p[k] += p[k], c->n[k] += n[k];
        for (int l = k; l < 3; ++l) c->pp[at++] += p[k] * p[l];
        for (int l = 0; l < 3; ++l) c->np[k][l] += n[k] * p[l];
    }
}

void psplat_covariance_unite(psplat_covariance *c, const psplat_covariance *other) {
    c->count += other->count;
    for (int k = 0; k < 3; ++k) {
        c->p[k] += other->p[k], c->n[k] += other->n[k];
        for (int l = 0; l < 3; ++l) c->np[k][l] += other->np[k][l];
    }
    for (int k = 0; k < 6; ++k) c->pp[k] += other->pp[k];
}

void psplat_covariance_move(psplat_covariance *c, const double d[3]) {
    for (int k = 0, at = 0; k < 3; ++k)
        for (int l = k; l < 3; ++l, ++at)
            c->pp[at] += c->count * d[k] * d[l] - c->p[k] * d[l] - d[k] * c->p[l];
    for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) c->np[k][l] -= c->n[k] * d[l];
    for (int k = 0; k < 3; ++k) c->p[k] -= c->count * d[k];
}

/* Computes the mean and the central second moments xx xy xz yy yz zz of the positions. */
static void central_moments(const psplat_covariance *c, double mean[3], double central[6]) {
    for (int k = 0; k < 3; ++k) mean[k] = c->p[k] / c->count;
    for (int k = 0, at = 0; k < 3; ++k)
        for (int l = k; l < 3; ++l, ++at) central[at] = c->pp[at] / c->count - mean[k] * mean[l];
}

/* Returns a^T M b for the symmetric matrix M = xx xy xz yy yz zz. */
static double bilinear_form(const double m[6], const double a[3], const double b[3]) {
    return a[0] * (m[0] * b[0] + m[1] * b[1] + m[2] * b[2]) +
           a[1] * (m[1] * b[0] + m[3] * b[1] + m[4] * b[2]) +
           a[2] * (m[2] * b[0] + m[4] * b[1] + m[5] * b[2]);
}

/* Stores the unit normal of the least-squares plane, on the side of the mean normal. Where the
 * points do not span a plane, or span one that is nearly parallel to their normals, it stores the
 * mean normal itself. */
static void plane_normal(const psplat_covariance *c, const double central[6], double normal[3]) {
    double values[3], vectors[3][3];
    memcpy(normal, c->n, 3 * sizeof(double));
    double length = normalize3(normal);
    psplat_eigen(central, values, vectors);
    double facing = dot3(vectors[0], normal);
    /* Differences of large sums leave an error of about this size in the eigenvalues. */
    double rounding = 1e-14 * (c->pp[0] + c->pp[3] + c->pp[5]) / c->count;
    int spans = values[1] > 1e-4 * values[2] + rounding && values[0] < 0.25 * values[1];
    if (length > 0 && (!spans || fabs(facing) < 0.5)) return;
    for (int k = 0; k < 3; ++k) normal[k] = facing < 0 ? -vectors[0][k] : vectors[0][k];
}

void psplat_covariance_fit(const psplat_covariance *c, psplat_plane *plane) {
    double central[6], a[3], b[3];
    central_moments(c, plane->mean, central);
    plane_normal(c, central, plane->n);
    perpendicular3(a, plane->n);
    cross3(b, plane->n, a);
    double aa = bilinear_form(central, a, a), ab = bilinear_form(central, a, b),
           bb = bilinear_form(central, b, b);
    double middle = (aa + bb) / 2, spread = norm2((aa - bb) / 2, ab);
    double angle = 0.5 * atan2(2 * ab, aa - bb), x = cos(angle), y = sin(angle);
    for (int k = 0; k < 3; ++k) plane->u[k] = x * a[k] + y * b[k];
    cross3(plane->v, plane->n, plane->u);
    plane->variance[0] = middle + spread;
    plane->variance[1] = max2(middle - spread, 0);
    plane->variance[2] = max2(bilinear_form(central, plane->n, plane->n), 0);
}

int psplat_covariance_curvature(const psplat_covariance *c, const psplat_plane *plane,
                                double direction[2], double curvature[2]) {
    const double *axes[2] = {plane->u, plane->v};
    double rows[2][2], mean_normal = dot3(c->n, plane->n) / c->count;
    if (!(mean_normal > 0) || !(plane->variance[1] > 1e-8 * plane->variance[0])) return 0;
    /* The gradient of the normals in the plane is their covariance with the position, divided by
     * the variance of the position. */
    for (int k = 0; k < 2; ++k)
        for (int l = 0; l < 2; ++l) {
            double sum = 0;
            for (int i = 0; i < 3; ++i)
                sum +=
                    axes[k][i] * (dot3(c->np[i], axes[l]) - c->n[i] * dot3(plane->mean, axes[l]));
            rows[k][l] = sum / c->count / plane->variance[l] / mean_normal;
        }
    /* Its symmetric part is the curvature tensor. */
    double off_diagonal = (rows[0][1] + rows[1][0]) / 2, difference = (rows[0][0] - rows[1][1]) / 2;
    double middle = (rows[0][0] + rows[1][1]) / 2, spread = norm2(difference, off_diagonal);
    double angle = 0.5 * atan2(off_diagonal, difference);
    int first = middle >= 0; /* the eigenvalue of greater magnitude is middle +- spread */
    direction[0] = first ? cos(angle) : -sin(angle);
    direction[1] = first ? sin(angle) : cos(angle);
    curvature[0] = fabs(first ? middle + spread : middle - spread);
    curvature[1] = fabs(first ? middle - spread : middle + spread);
    return curvature[0] > 0;
}
