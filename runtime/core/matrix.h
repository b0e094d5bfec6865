/* SPDX-License-Identifier: MIT
 *
 * matrix.h - 4 x 4 matrices of doubles: product, inverse, normal matrix, stretch, orthonormal
 * basis. All are column-major (m[column * 4 + row]) and act on column vectors. An output may not
 * overlap an input.
 */
#ifndef PHONGSPLAT_CORE_MATRIX_H
#define PHONGSPLAT_CORE_MATRIX_H

/* Returns the dot product of two vectors. */
static inline double psplat_dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Computes the product a b. */
void psplat_matrix_multiply(const double a[16], const double b[16], double product[16]);

/* Returns the determinant of the upper left 3 x 3 matrix. */
double psplat_matrix_determinant3(const double m[16]);

/* Computes the normal matrix of spec 4, 3 x 3 and column-major: |det|^(1/3) times the inverse
 * transpose of the upper left 3 x 3 matrix, whose determinant det the caller gives; it is not 0. */
void psplat_matrix_normal(const double m[16], double det, double normal[9]);

/* Returns by how much the upper left 3 x 3 matrix lengthens vectors at most: its largest singular
 * value, within 1e-7 of it; infinite or NaN where the matrix is not finite. */
double psplat_matrix_stretch(const double m[16]);

/* Computes the inverse of m. Returns 0 where m is singular or not finite. */
int psplat_matrix_invert(const double m[16], double inverse[16]);

/* Finds x and y that complete the unit vector z to a right-handed orthonormal basis (Duff et al.
 * 2017). */
void psplat_matrix_basis(const double z[3], double x[3], double y[3]);

/* Rounds count numbers to float. */
void psplat_matrix_to_float(const double *m, int count, float *out);

#endif
