/* SPDX-License-Identifier: MIT
 *
 * volume.c - transforms bounding volumes and measures them.
 */
#include "tileset/volume.h"

#include "core/matrix.h"

#include <math.h>
#include <string.h>

/* How far cosines between axes may be from 0 where these count as orthogonal; volumes are grown by
 * as much of their size. */
static const double tolerance = 1e-6;

static const double pi = 3.14159265358979323846;

void psplat_tile_y_up(const double z_up[3], double y_up[3]) {
    double y = z_up[1];
    y_up[0] = z_up[0];
    y_up[1] = z_up[2];
    y_up[2] = 0.0 - y; /* never -0 */
}

/* With R the rotation from z up to y up, y_up = R z_up R^-1. */
void psplat_tile_transform_y_up(const double z_up[16], double y_up[16]) {
    double columns[4][3];
    for (int i = 0; i < 4; ++i) psplat_tile_y_up(z_up + 4 * i, columns[i]);
    memset(y_up, 0, 16 * sizeof *y_up);
    for (int i = 0; i < 3; ++i) {
        y_up[i] = columns[0][i];
        y_up[4 + i] = columns[2][i];
        y_up[8 + i] = 0.0 - columns[1][i];
        y_up[12 + i] = columns[3][i];
    }
    y_up[15] = 1.0;
}

/* ---- scales of transforms ----------------------------------------------------------------- */

static int is_orthogonal(const double a[3], const double b[3]) {
    return fabs(psplat_dot3(a, b)) <= tolerance * sqrt(psplat_dot3(a, a) * psplat_dot3(b, b));
}

static int has_orthogonal_columns(const double m[16]) {
    return is_orthogonal(m, m + 4) && is_orthogonal(m, m + 8) && is_orthogonal(m + 4, m + 8);
}

/* Where columns are orthogonal, the greatest of their lengths is exact. */
double psplat_tile_stretch(const double m[16]) {
    static const double above = 1.0 + 1e-7; /* the accuracy of psplat_matrix_stretch */
    double greatest = 0.0;
    if (!has_orthogonal_columns(m)) return above * psplat_matrix_stretch(m);
    for (int i = 0; i < 3; ++i) greatest = fmax(greatest, psplat_dot3(m + 4 * i, m + 4 * i));
    return sqrt(greatest);
}

/* The singular values of a matrix multiply to its determinant, and none is beyond the stretch. */
double psplat_tile_shrink(const double m[16]) {
    double stretch = psplat_tile_stretch(m), least = HUGE_VAL;
    if (!has_orthogonal_columns(m))
        return fabs(psplat_matrix_determinant3(m)) / (stretch * stretch);
    for (int i = 0; i < 3; ++i) least = fmin(least, psplat_dot3(m + 4 * i, m + 4 * i));
    return sqrt(least);
}

int psplat_tile_is_similarity(const double m[16]) {
    return has_orthogonal_columns(m) &&
           psplat_tile_shrink(m) >= (1.0 - tolerance) * psplat_tile_stretch(m);
}

/* ---- volumes ------------------------------------------------------------------------------- */

static void transform_vector(const double m[16], const double v[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = m[i] * v[0] + m[4 + i] * v[1] + m[8 + i] * v[2];
}

static void transform_point(const double m[16], const double p[3], double out[3]) {
    transform_vector(m, p, out);
    for (int i = 0; i < 3; ++i) out[i] += m[12 + i];
}

static void use_coordinate_axes(psplat_tile_volume *volume) {
    memset(volume->axis, 0, sizeof volume->axis);
    for (int i = 0; i < 3; ++i) volume->axis[i][i] = 1.0;
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* Gives axes without length (of flat boxes) a direction that completes the others. */
static void complete_axes(psplat_tile_volume *v) {
    for (int i = 0; i < 3; ++i) {
        double *axis = v->axis[i], *next = v->axis[(i + 1) % 3], *last = v->axis[(i + 2) % 3];
        if (v->half[i] > 0.0) continue;
        if (v->half[(i + 1) % 3] > 0.0 && v->half[(i + 2) % 3] > 0.0)
            cross(next, last, axis);
        else if (v->half[(i + 1) % 3] > 0.0)
            psplat_matrix_basis(next, last, axis);
        else if (v->half[(i + 2) % 3] > 0.0)
            psplat_matrix_basis(last, axis, next);
    }
}

static void grow(psplat_tile_volume *volume) {
    volume->round += tolerance * psplat_tile_radius(volume);
}

void psplat_tile_volume_box(const double box[12], const double transform[16],
                            psplat_tile_volume *volume) {
    double y_up[3], axes[3][3];
    memset(volume, 0, sizeof *volume);
    psplat_tile_y_up(box, y_up);
    transform_point(transform, y_up, volume->center);
    for (int i = 0; i < 3; ++i) {
        psplat_tile_y_up(box + 3 + 3 * i, y_up);
        transform_vector(transform, y_up, axes[i]);
    }
    if (is_orthogonal(axes[0], axes[1]) && is_orthogonal(axes[0], axes[2]) &&
        is_orthogonal(axes[1], axes[2])) {
        for (int i = 0; i < 3; ++i) {
            volume->half[i] = sqrt(psplat_dot3(axes[i], axes[i]));
            for (int k = 0; k < 3 && volume->half[i] > 0.0; ++k)
                volume->axis[i][k] = axes[i][k] / volume->half[i];
        }
        if (!(volume->half[0] > 0.0 || volume->half[1] > 0.0 || volume->half[2] > 0.0))
            use_coordinate_axes(volume);
        complete_axes(volume);
    } else {
        use_coordinate_axes(volume);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) volume->half[k] += fabs(axes[i][k]);
    }
    grow(volume);
}

void psplat_tile_volume_sphere(const double sphere[4], const double transform[16],
                               psplat_tile_volume *volume) {
    double y_up[3];
    memset(volume, 0, sizeof *volume);
    use_coordinate_axes(volume);
    psplat_tile_y_up(sphere, y_up);
    transform_point(transform, y_up, volume->center);
    volume->round = sphere[3] * psplat_tile_stretch(transform);
    grow(volume);
}

/* Geodetic coordinates are orthogonal, so that a straight way in them from the region's middle to
 * any of its points is no longer than the root of the sum of three squares: neither radius of
 * curvature of the ellipsoid is beyond a^2 / b. */
void psplat_tile_volume_region(const double region[6], psplat_tile_volume *volume) {
    const double a = 6378137.0, b = 6356752.3142451793;
    double east = region[2] < region[0] ? region[2] + 2.0 * pi : region[2];
    double longitude = 0.5 * (region[0] + east), latitude = 0.5 * (region[1] + region[3]);
    double height = 0.5 * (region[4] + region[5]), e2 = 1.0 - b * b / (a * a);
    double most = a * a / b + fmax(region[5], 0.0);
    double widest =
        region[1] <= 0.0 && region[3] >= 0.0 ? 1.0 : cos(fmin(fabs(region[1]), fabs(region[3])));
    double normal = a / sqrt(1.0 - e2 * sin(latitude) * sin(latitude));
    const double z_up[3] = {(normal + height) * cos(latitude) * cos(longitude),
                            (normal + height) * cos(latitude) * sin(longitude),
                            (normal * (1.0 - e2) + height) * sin(latitude)};
    double ways[3] = {most * 0.5 * (region[3] - region[1]),
                      most * widest * 0.5 * (east - region[0]), 0.5 * (region[5] - region[4])};
    memset(volume, 0, sizeof *volume);
    use_coordinate_axes(volume);
    psplat_tile_y_up(z_up, volume->center);
    volume->round = sqrt(psplat_dot3(ways, ways));
    if (volume->round > most) { /* the ball around the earth is smaller */
        memset(volume->center, 0, sizeof volume->center);
        volume->round = most;
    }
    grow(volume);
}

double psplat_tile_distance(const psplat_tile_volume *volume, const double point[3]) {
    double from[3], sum = 0.0;
    for (int i = 0; i < 3; ++i) from[i] = point[i] - volume->center[i];
    for (int i = 0; i < 3; ++i) {
        double beyond = fabs(psplat_dot3(from, volume->axis[i])) - volume->half[i];
        if (beyond > 0.0) sum += beyond * beyond;
    }
    return fmax(sqrt(sum) - volume->round, 0.0);
}

double psplat_tile_reach(const psplat_tile_volume *volume, const double direction[3]) {
    double reach = volume->round * sqrt(psplat_dot3(direction, direction));
    for (int i = 0; i < 3; ++i)
        reach += volume->half[i] * fabs(psplat_dot3(direction, volume->axis[i]));
    return reach;
}

double psplat_tile_radius(const psplat_tile_volume *volume) {
    return sqrt(psplat_dot3(volume->half, volume->half)) + volume->round;
}
