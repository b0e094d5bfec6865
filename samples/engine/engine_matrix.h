/* SPDX-License-Identifier: MIT
 *
 * engine_matrix.h - column-major double matrices, as psplat_view and psplat_item take them.
 */
#ifndef ENGINE_MATRIX_H
#define ENGINE_MATRIX_H

typedef struct matrix {
    double m[16];
} matrix;

matrix matrix_multiply(const matrix *a, const matrix *b);
matrix matrix_move(double x, double y, double z);
void matrix_to_float(const matrix *a, float out[16]);
matrix matrix_scale(double x, double y, double z);
matrix matrix_turn(double radians); /* about +y */
matrix matrix_look(const double eye[3], const double target[3]);
matrix matrix_unlook(const matrix *look);                     /* the inverse of matrix_look */
matrix matrix_parallel(double half, double near, double far); /* a square of 2 half */
matrix matrix_perspective(double focal, double aspect, double near, double far);

#endif
