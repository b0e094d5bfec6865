/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * covariance.h - covariance sums of oriented points, and the least-squares plane and principal
 * curvatures that follow from them (Pajarola, Sainz, Guidotti 2003, section 4).
 */
#ifndef PHONGSPLAT_BASE_COVARIANCE_H
#define PHONGSPLAT_BASE_COVARIANCE_H

/* The parts that fits need of the sum of x x^T over x = (p, n, 1), with positions p relative to a
 * local origin and unit normals n. Zero-initialise. */
typedef struct psplat_covariance {
    double count;
    double p[3], n[3];
    double pp[6];    /* xx xy xz yy yz zz */
    double np[3][3]; /* rows: components of n */
} psplat_covariance;

/* A least-squares plane. The axes u, v, n are a right-handed orthonormal frame: u and v are the
 * principal directions of the points in the plane, u that of the greater variance. */
typedef struct psplat_plane {
    double mean[3];
    double u[3], v[3], n[3];
    double variance[3]; /* along u, v, n */
} psplat_plane;

/* Adds one point p with its unit normal n. */
void psplat_covariance_add(psplat_covariance *covariance, const double p[3], const double n[3]);

/* Adds the sums of other, relative to the same origin. The result is the covariance of the union of
 * both sets. */
void psplat_covariance_unite(psplat_covariance *covariance, const psplat_covariance *other);

/* Changes the sums to those of the same points relative to the origin plus d. */
void psplat_covariance_move(psplat_covariance *covariance, const double d[3]);

/* Fits the plane through the points, with its normal on the side of their mean normal. Where the
 * points do not span a plane, the normal is their mean normal. count must be positive. */
void psplat_covariance_fit(const psplat_covariance *covariance, psplat_plane *plane);

/* Estimates the principal curvatures from the gradient of the normals over the plane. curvature
 * holds their magnitudes, in 1 / length, the greater one first; direction is the unit direction of
 * curvature[0] in coordinates u, v. Returns 0 where the surface is flat or the points lie on a
 * line, so that no direction is known. */
int psplat_covariance_curvature(const psplat_covariance *covariance, const psplat_plane *plane,
                                double direction[2], double curvature[2]);

#endif
