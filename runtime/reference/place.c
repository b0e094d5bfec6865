/* SPDX-License-Identifier: MIT
 *
 * place.c - splats in eye space: the axes, parameters and normal field of a stored splat (spec 3),
 * moved by the transform of its node and by the view (spec 4).
 */
#include "reference/oracle.h"

#include <math.h>

/* Computes |det M3|^(1/3) M3^-T and its first factor. The columns of M3^-T are the cross products
 * of M3's columns over det M3, so a mirroring transform keeps outward normals outward (spec 4).
 * Returns 0 where M3 is singular. */
static int normal_matrix(const double m[16], double out[3][3], double *scale) {
    double columns[3][3];
    for (int i = 0; i < 3; ++i)
        psplat_oracle_cross(m + 4 * ((i + 1) % 3), m + 4 * ((i + 2) % 3), columns[i]);
    double determinant = psplat_oracle_dot(m, columns[0]);
    if (determinant == 0 || !isfinite(determinant)) return 0;
    *scale = cbrt(fabs(determinant));
    for (int row = 0; row < 3; ++row)
        for (int i = 0; i < 3; ++i) out[row][i] = *scale * columns[i][row] / determinant;
    return 1;
}

int psplat_oracle_place_batch(const psplat_batch *batch, const double transform[16],
                              const double view[16], psplat_oracle_space *space) {
    double placed[16], scale = 0;
    psplat_oracle_multiply(transform, batch->model, placed);
    psplat_oracle_multiply(view, placed, space->model_view);
    if (!normal_matrix(space->model_view, space->normal_matrix, &scale)) return 0;
    space->epsilon = scale * (double)batch->depth_tolerance;
    space->depth_tolerance = (double)batch->depth_tolerance;
    space->is_curved = batch->is_curved;
    space->seam_count = batch->seam_lines;
    return 1;
}

/* U, V and N are the columns of the quaternion's rotation (spec 3.3). The stored quaternion need
 * not have length 1 exactly. */
static void axes_of(const float rotation[4], double axes[3][3]) {
    double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    double s = 2 / (x * x + y * y + z * z + w * w);
    double rows[3][3] = {
        {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)},
        {s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)},
        {s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)},
    };
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) axes[i][k] = rows[i][k];
}

/* Finds the rows that take q - c to (u, v) (spec 3.4). They are the dual basis of the two axes in
 * their plane, which stays right where a transform makes the axes conjugate diameters (spec 4). */
static void parameter_rows(psplat_oracle_splat *placed) {
    psplat_oracle_cross(placed->axis[0], placed->axis[1], placed->plane);
    double area2 = psplat_oracle_dot(placed->plane, placed->plane);
    psplat_oracle_cross(placed->axis[1], placed->plane, placed->parameter[0]);
    psplat_oracle_cross(placed->plane, placed->axis[0], placed->parameter[1]);
    for (int i = 0; i < 3; ++i) {
        placed->parameter[0][i] /= area2;
        placed->parameter[1][i] /= area2;
    }
}

/* Does the same for the points of a curved splat, which are not in the plane: under a transform
 * that shears, (u, v) is constant along the image of N, which is not the plane's normal (spec 4).
 */
static void curved_parameter_rows(psplat_oracle_splat *placed) {
    psplat_oracle_cross(placed->axis[0], placed->axis[1], placed->plane);
    double volume = psplat_oracle_dot(placed->plane, placed->axis[2]);
    for (int k = 0; k < 3; ++k) {
        psplat_oracle_cross(placed->axis[(k + 1) % 3], placed->axis[(k + 2) % 3],
                            placed->parameter[k]);
        for (int i = 0; i < 3; ++i) placed->parameter[k][i] /= volume;
    }
}

/* Sets the surface of eq. (1a), which is the plane where the shape is 0. */
static void surface(const psplat_splat *splat, psplat_oracle_splat *placed) {
    double q = (double)splat->radius[1] / (double)splat->radius[0];
    const float *second = placed->is_curved ? splat->shape + 2 : splat->gradient;
    for (int k = 0; k < 2; ++k) placed->slope[k] = placed->is_curved ? (double)splat->shape[k] : 0;
    placed->slope[1] *= q;
    placed->bend[0] = (double)second[0];
    placed->bend[1] = q * (double)second[2];
    placed->bend[2] = q * (double)second[1];
}

static void clip_lines(const psplat_splat *splat, uint32_t count, uint32_t seam_count,
                       psplat_oracle_splat *placed) {
    placed->clip_count = count - seam_count;
    placed->line_count = count;
    for (uint32_t k = 0; k < count; ++k) {
        for (int i = 0; i < 3; ++i) placed->clip[k][i] = splat->clip[k][i];
        placed->clip[k][3] = splat->bend[k];
    }
}

/* Multiplies a vector by a matrix that is stored row by row. */
static void apply(const double matrix[3][3], const double v[3], double out[3]) {
    for (int row = 0; row < 3; ++row) out[row] = psplat_oracle_dot(matrix[row], v);
}

/* Computes the normal field of eq. (2) and (3), whose terms are transformed as normals. */
static void normal_field(const psplat_splat *splat, double axes[3][3], const double matrix[3][3],
                         psplat_oracle_splat *placed) {
    double stored[3] = {splat->normal[0], splat->normal[1], splat->normal[2]};
    double along = psplat_oracle_dot(stored, axes[2]);
    double x = psplat_oracle_dot(stored, axes[0]) / along;
    double y = psplat_oracle_dot(stored, axes[1]) / along;
    double gamma = splat->gradient[2], q = (double)splat->radius[1] / (double)splat->radius[0];
    double u[3], v[3];
    apply(matrix, axes[0], u);
    apply(matrix, axes[1], v);
    apply(matrix, axes[2], placed->side);
    for (int i = 0; i < 3; ++i) {
        placed->normal[0][i] = placed->side[i] + x * u[i] + y * v[i];
        placed->normal[1][i] = (double)splat->gradient[0] * u[i] + gamma * v[i];
        placed->normal[2][i] = gamma * q * u[i] + (double)splat->gradient[1] * v[i];
    }
    psplat_oracle_normalise(placed->side);
}

void psplat_oracle_place_splat(const psplat_splat *splat, uint32_t line_count,
                               const psplat_oracle_space *space, psplat_oracle_splat *placed) {
    double axes[3][3], moved[4];
    double center[3] = {splat->center[0], splat->center[1], splat->center[2]};
    axes_of(splat->rotation, axes);
    psplat_oracle_transform(space->model_view, center, 1, moved);
    for (int i = 0; i < 3; ++i) placed->center[i] = moved[i];
    for (int axis = 0; axis < 3; ++axis) {
        psplat_oracle_transform(space->model_view, axes[axis], 0, moved);
        for (int i = 0; i < 3; ++i)
            placed->axis[axis][i] = (double)splat->radius[axis % 2] * moved[i];
    }
    placed->is_curved = space->is_curved;
    surface(splat, placed);
    placed->peek = 2 * space->depth_tolerance / (double)splat->radius[0];
    placed->wall = placed->is_curved ? space->depth_tolerance / 4 / (double)splat->radius[0] : 0;
    if (placed->is_curved)
        curved_parameter_rows(placed);
    else
        parameter_rows(placed);
    normal_field(splat, axes, space->normal_matrix, placed);
    clip_lines(splat, line_count, space->seam_count, placed);
    placed->epsilon = space->epsilon;
}
