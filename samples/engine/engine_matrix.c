/* SPDX-License-Identifier: MIT
 *
 * engine_matrix.c - column-major double matrices; see engine_matrix.h.
 */
#include "engine_matrix.h"

#include <math.h>

matrix matrix_multiply(const matrix *a, const matrix *b) {
    matrix product = {{0}};
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            for (int i = 0; i < 4; ++i)
                product.m[4 * column + row] += a->m[4 * i + row] * b->m[4 * column + i];
    return product;
}

void matrix_to_float(const matrix *a, float out[16]) {
    for (int i = 0; i < 16; ++i) out[i] = (float)a->m[i];
}

matrix matrix_scale(double x, double y, double z) {
    return (matrix){{[0] = x, [5] = y, [10] = z, [15] = 1}};
}

matrix matrix_move(double x, double y, double z) {
    return (matrix){{[0] = 1, [5] = 1, [10] = 1, [12] = x, [13] = y, [14] = z, [15] = 1}};
}

matrix matrix_turn(double radians) {
    double c = cos(radians), s = sin(radians);
    return (matrix){{[0] = c, [2] = -s, [5] = 1, [8] = s, [10] = c, [15] = 1}};
}

/* Up is +y, which must not be the viewing direction. */
matrix matrix_look(const double eye[3], const double target[3]) {
    double back[3], length = 0;
    for (int i = 0; i < 3; ++i) back[i] = eye[i] - target[i], length += back[i] * back[i];
    for (int i = 0; i < 3; ++i) back[i] /= sqrt(length);
    double flat = hypot(back[0], back[2]);
    double right[3] = {back[2] / flat, 0, -back[0] / flat};
    double up[3] = {back[1] * right[2], back[2] * right[0] - back[0] * right[2],
                    -back[1] * right[0]};
    const double *rows[3] = {right, up, back};
    matrix result = {{[15] = 1}};
    for (int row = 0; row < 3; ++row)
        for (int i = 0; i < 3; ++i) {
            result.m[4 * i + row] = rows[row][i];
            result.m[12 + row] -= rows[row][i] * eye[i];
        }
    return result;
}

/* The inverse of a rotation is its transpose. */
matrix matrix_unlook(const matrix *look) {
    matrix result = {{[15] = 1}};
    for (int row = 0; row < 3; ++row)
        for (int i = 0; i < 3; ++i) {
            result.m[4 * i + row] = look->m[4 * row + i];
            result.m[12 + row] -= look->m[4 * row + i] * look->m[12 + i];
        }
    return result;
}

matrix matrix_parallel(double half, double near, double far) {
    return (matrix){{[0] = 1 / half,
                     [5] = 1 / half,
                     [10] = 2 / (near - far),
                     [14] = (near + far) / (near - far),
                     [15] = 1}};
}

matrix matrix_perspective(double focal, double aspect, double near, double far) {
    return (matrix){{[0] = focal / aspect,
                     [5] = focal,
                     [10] = (near + far) / (near - far),
                     [11] = -1,
                     [14] = 2 * near * far / (near - far)}};
}
