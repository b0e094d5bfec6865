/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * eigen.h - eigenvalues and eigenvectors of symmetric 3 x 3 matrices.
 */
#ifndef PHONGSPLAT_BASE_EIGEN_H
#define PHONGSPLAT_BASE_EIGEN_H

/* Computes the eigenvalues, in ascending order, and the unit eigenvectors, as rows, of the
 * symmetric matrix xx xy xz yy yz zz by Jacobi rotations. */
void psplat_eigen(const double matrix[6], double values[3], double vectors[3][3]);

#endif
