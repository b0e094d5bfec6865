/* SPDX-License-Identifier: MIT
 *
 * matrix.h - double 4 x 4 matrices, column-major.
 */
#ifndef PHONGSPLAT_MATRIX_H
#define PHONGSPLAT_MATRIX_H

/* product = a b; product may be neither. */
void psplat_matrix_multiply(const double a[16], const double b[16], double product[16]);

/* Determinant of the upper left 3 x 3. */
double psplat_matrix_determinant3(const double m[16]);

/* |det|^(1/3) times the inverse transpose of the upper left 3 x 3 (spec 4), det its determinant. */
void psplat_matrix_normal(const double m[16], double det, double normal[9]);

/* 0 where m is singular or not finite. */
int psplat_matrix_invert(const double m[16], double inverse[16]);

/* x and y complete the unit vector z to a right-handed basis (Duff et al. 2017). */
void psplat_matrix_basis(const double z[3], double x[3], double y[3]);

void psplat_matrix_to_float(const double *m, int count, float *out);

#endif
