/* SPDX-License-Identifier: MIT
 *
 * environment_light.c - image-based lighting by eq. (9) of spec 5.6, the split sum, with plain
 * quadrature instead of prefiltered textures. Between the centres of texels the radiance R is
 * interpolated linearly, across the edges of faces too, as GL filters seamless cube maps.
 */
#include "reference/oracle.h"

#include <math.h>

/* Numbers of points of the quadratures: of a half vector's angle to z and about z, and the least
 * along an edge of a face. Twice as many change no result by more than 1e-3 of it. */
#define POLAR_POINTS 96
#define AZIMUTH_POINTS 64
#define FACE_POINTS 32

/* ---- the cube ---------------------------------------------------------------------------- */

/* Each face has the directions in which s and t grow and its own direction (GL 4.6, table 8.19). */
static const double faces[6][3][3] = {
    {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}}, {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
    {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},   {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
};

/* Finds the direction, of any length, of the point (s, t) of a face's plane; the face itself is
 * -1 ... 1. */
static void direction_of(int face, double s, double t, double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = s * faces[face][0][i] + t * faces[face][1][i] + faces[face][2][i];
}

/* Returns the face that a direction meets, and the point (s, t) where it does. */
static int face_of(const double direction[3], double *s, double *t) {
    int best = 0;
    for (int face = 1; face < 6; ++face)
        if (psplat_oracle_dot(direction, faces[face][2]) >
            psplat_oracle_dot(direction, faces[best][2]))
            best = face;
    double depth = psplat_oracle_dot(direction, faces[best][2]);
    *s = psplat_oracle_dot(direction, faces[best][0]) / depth;
    *t = psplat_oracle_dot(direction, faces[best][1]) / depth;
    return best;
}

static int texel_at(double s, int size) {
    return (int)fmin(fmax(floor((s + 1) / 2 * size), 0), size - 1);
}

/* Returns the RGB of a texel of a face. Beyond its edge that is the nearest texel of the
 * neighbouring face. */
static const float *texel(const psplat_environment_desc *cube, int face, int column, int row) {
    int size = cube->size;
    if (column < 0 || row < 0 || column >= size || row >= size) {
        double direction[3], s = (2 * column + 1.0) / size - 1, t = (2 * row + 1.0) / size - 1;
        direction_of(face, s, t, direction);
        face = face_of(direction, &s, &t);
        column = texel_at(s, size);
        row = texel_at(t, size);
    }
    return cube->radiance +
           3 * (((size_t)face * (size_t)size + (size_t)row) * (size_t)size + (size_t)column);
}

/* Finds R for a direction of any length, interpolated between four texels. */
static void radiance_from(const psplat_environment_desc *cube, const double direction[3],
                          double out[3]) {
    double s = 0, t = 0;
    int face = face_of(direction, &s, &t);
    double x = (s + 1) / 2 * cube->size - 0.5, y = (t + 1) / 2 * cube->size - 0.5;
    int column = (int)floor(x), row = (int)floor(y);
    x -= column;
    y -= row;
    for (int i = 0; i < 3; ++i) out[i] = 0;
    for (int k = 0; k < 4; ++k) {
        const float *value = texel(cube, face, column + k % 2, row + k / 2);
        double weight = (k % 2 ? x : 1 - x) * (k / 2 ? y : 1 - y);
        for (int i = 0; i < 3; ++i) out[i] += weight * (double)value[i];
    }
}

/* ---- the integrals --------------------------------------------------------------------------- */

/* Integrates R max(n.l, 0) over all directions l. A part of a face at distance |d| from the centre
 * has a solid angle of its area over |d|^3. */
static void irradiance_of(const psplat_environment_desc *cube, const double n[3], double out[3]) {
    int points = cube->size * ((FACE_POINTS + cube->size - 1) / cube->size);
    double step = 2.0 / points;
    for (int i = 0; i < 3; ++i) out[i] = 0;
    for (int k = 0; k < 6 * points * points; ++k) {
        double direction[3], radiance[3];
        double s = (k % points + 0.5) * step - 1, t = (k / points % points + 0.5) * step - 1;
        direction_of(k / points / points, s, t, direction);
        double length = psplat_oracle_length(direction);
        double cosine = psplat_oracle_dot(n, direction) / length;
        if (cosine <= 0) continue;
        radiance_from(cube, direction, radiance);
        double weight = cosine * step * step / (length * length * length);
        for (int i = 0; i < 3; ++i) out[i] += weight * radiance[i];
    }
}

/* Finds the k-th half vector around z. Their density is D(h) (n.h), as in Walter et al. 2007, eq.
 * 35, but those far from z, which count at grazing angles, are more frequent: x = 1 - y^3 and
 * dx = 3 y^2 dy. Returns the weight that makes up for it, whose mean is 1. */
static double half_vector(int k, double alpha, double h[3]) {
    double y = 1 - (k / AZIMUTH_POINTS + 0.5) / POLAR_POINTS, x = 1 - y * y * y;
    double angle = 2 * PSPLAT_ORACLE_PI * (k % AZIMUTH_POINTS + 0.5) / AZIMUTH_POINTS;
    double tangent = alpha * sqrt(x / (1 - x)), cosine = 1 / sqrt(1 + tangent * tangent);
    h[0] = tangent * cosine * cos(angle);
    h[1] = tangent * cosine * sin(angle);
    h[2] = cosine;
    return 3 * y * y;
}

/* Averages R over the directions l = 2 (r.h) h - r with weights D(h) (r.h) max(r.l, 0), as if the
 * normal and the direction to the eye were both r. */
static void mean_reflection(const psplat_environment_desc *cube, const double r[3], double alpha,
                            double out[3]) {
    double x[3], y[3], helper[3] = {0, 0, 0}, sum = 0;
    helper[fabs(r[0]) < 0.6 ? 0 : 1] = 1; /* an axis that is far from parallel to r */
    psplat_oracle_cross(helper, r, x);
    psplat_oracle_normalise(x);
    psplat_oracle_cross(r, x, y);
    for (int i = 0; i < 3; ++i) out[i] = 0;
    for (int k = 0; k < POLAR_POINTS * AZIMUTH_POINTS; ++k) {
        double h[3], l[3], radiance[3];
        double weight = half_vector(k, alpha, h) * (2 * h[2] * h[2] - 1); /* r.l */
        if (weight <= 0) continue;
        for (int i = 0; i < 3; ++i)
            l[i] = 2 * h[2] * (h[0] * x[i] + h[1] * y[i] + h[2] * r[i]) - r[i];
        radiance_from(cube, l, radiance);
        for (int i = 0; i < 3; ++i) out[i] += weight * radiance[i];
        sum += weight;
    }
    for (int i = 0; i < 3; ++i) out[i] /= sum;
}

/* Computes a and b of eq. (9): the integrals of V D F (n.l) over l, with dl = 4 (e.h) dh, for the
 * two parts of Schlick's F. */
static void split_sums(double normal_eye, double alpha, double sums[2]) {
    double e[3] = {sqrt(1 - normal_eye * normal_eye), 0, normal_eye};
    sums[0] = sums[1] = 0;
    for (int k = 0; k < POLAR_POINTS * AZIMUTH_POINTS; ++k) {
        double h[3];
        double weight = half_vector(k, alpha, h) / (POLAR_POINTS * AZIMUTH_POINTS);
        double eye_half = psplat_oracle_dot(e, h), normal_light = 2 * eye_half * h[2] - e[2];
        if (eye_half <= 0 || normal_light <= 0) continue;
        double lobe = weight * psplat_oracle_visibility(normal_light, normal_eye, alpha) *
                      normal_light * 4 * eye_half / h[2];
        double grazing = pow(1 - eye_half, 5);
        sums[0] += lobe * (1 - grazing);
        sums[1] += lobe * grazing;
    }
}

static void to_scene(const double rows[3][3], const double v[3], double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = psplat_oracle_dot(rows[i], v);
}

void psplat_oracle_environment_add(const psplat_oracle_environment *environment,
                                   const psplat_oracle_surface *surface, const double normal[3],
                                   const double to_eye[3], double radiance[3]) {
    if (!environment->desc) return;
    double n[3], e[3], r[3], diffuse[3], glossy[3], sums[2];
    double alpha = fmax(surface->roughness * surface->roughness, 0.002);
    to_scene(environment->to_scene, normal, n);
    to_scene(environment->to_scene, to_eye, e);
    double normal_eye = psplat_oracle_dot(n, e);
    for (int i = 0; i < 3; ++i) r[i] = 2 * normal_eye * n[i] - e[i];
    irradiance_of(environment->desc, n, diffuse);
    mean_reflection(environment->desc, r, alpha, glossy);
    split_sums(fmin(fmax(normal_eye, 1e-4), 1), alpha, sums);
    for (int i = 0; i < 3; ++i) {
        double base = surface->base[i], f0 = 0.04 + (base - 0.04) * surface->metallic;
        radiance[i] +=
            surface->occlusion * (base * (1 - surface->metallic) / PSPLAT_ORACLE_PI * diffuse[i] +
                                  (f0 * sums[0] + sums[1]) * glossy[i]);
    }
}
