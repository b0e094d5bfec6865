/* SPDX-License-Identifier: MIT
 *
 * detail.c - scenes full of detail; see detail.h.
 */
#include "detail.h"

#include "reference_view.h"

#include <math.h>
#include <stdlib.h>

enum { COUNT = 4000 };

static void normalise(double a[3]) {
    double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

/* ---- fields ---------------------------------------------------------------------------------- */

/* Makes the splat black or white, by the field of the checkerboard that (x, y) lies in. */
static void appearance(psplat_splat *splat, double x, double y) {
    int is_white = ((int)floor(x) + (int)floor(y)) & 1;
    for (int k = 0; k < 3; ++k) splat->color[k] = is_white ? 1 : 0.05f;
}

scene detail_checkered(void) {
    const int fields = 24;
    scene s = scene_sphere(COUNT, 1);
    s.has_color = 1;
    s.material.unlit = 1;
    for (size_t i = 0; i < s.count; ++i) {
        const float *c = s.splats[i].center;
        appearance(&s.splats[i], acos(fmin(fmax((double)c[2], -1), 1)) / CAMERA_PI * fields,
                   (atan2((double)c[1], (double)c[0]) / CAMERA_PI + 1) * fields);
    }
    return s;
}

/* ---- bumps ----------------------------------------------------------------------------------- */

/* Computes the point of a bumpy sphere that lies in a direction, which may have any length. */
static void bump(const double direction[3], double out[3]) {
    double d[3] = {direction[0], direction[1], direction[2]};
    normalise(d);
    double height = 1 + 0.12 * sin(12 * d[0]) * sin(12 * d[1]) * sin(12 * d[2]);
    for (int i = 0; i < 3; ++i) out[i] = d[i] * height;
}

/* Moves the splat to the bumpy sphere and turns it into the tangent plane, which is found by
 * differences. */
static void settle(psplat_splat *splat) {
    double at[3], moved[3], point[3], tangent[2][3], along = 0;
    for (int i = 0; i < 3; ++i) at[i] = (double)splat->center[i];
    bump(at, point);
    for (int axis = 0; axis < 2; ++axis) {
        int least = fabs(at[0]) < 0.6 ? 0 : 1, other = (least + 1 + axis) % 3;
        for (int i = 0; i < 3; ++i) moved[i] = at[i] + (i == (axis ? other : least) ? 1e-5 : 0);
        bump(moved, tangent[axis]);
        for (int i = 0; i < 3; ++i) tangent[axis][i] -= point[i];
        normalise(tangent[axis]);
    }
    for (int i = 0; i < 3; ++i) along += tangent[0][i] * tangent[1][i];
    for (int i = 0; i < 3; ++i) tangent[1][i] -= along * tangent[0][i];
    normalise(tangent[1]);
    double outward = 0, n[3];
    for (int i = 0; i < 3; ++i) {
        n[i] = tangent[0][(i + 1) % 3] * tangent[1][(i + 2) % 3] -
               tangent[0][(i + 2) % 3] * tangent[1][(i + 1) % 3];
        outward += n[i] * at[i];
    }
    for (int i = 0; i < 3; ++i) {
        if (outward < 0) tangent[1][i] = -tangent[1][i];
        splat->normal[i] = (float)(outward < 0 ? -n[i] : n[i]);
        splat->center[i] = (float)point[i];
        splat->gradient[i] = 0;
    }
    scene_set_axes(splat, tangent[0], tangent[1]);
    for (int i = 0; i < 2; ++i) splat->radius[i] *= 1.4f; /* bumps have more area than the sphere */
}

scene detail_bumpy(void) {
    scene s = scene_sphere(COUNT, 1);
    for (size_t i = 0; i < s.count; ++i) settle(&s.splats[i]);
    s.depth_tolerance = 0.01f;
    return s;
}

/* ---- turned from the camera ------------------------------------------------------------------ */

/* Turns about x, so that +z goes towards +y. */
static void turn(double a[3], double cosine) {
    double sine = sqrt(1 - cosine * cosine), y = a[1], z = a[2];
    a[1] = cosine * y + sine * z;
    a[2] = cosine * z - sine * y;
}

/* Places a round splat with these axes and turns it. */
static void place(psplat_splat *splat, double center[3], double u[3], double v[3], double radius,
                  double cosine) {
    turn(center, cosine);
    turn(u, cosine);
    turn(v, cosine);
    scene_set_axes(splat, u, v);
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        splat->center[i] = (float)center[i];
        splat->normal[i] = (float)(u[j] * v[k] - u[k] * v[j]);
    }
    splat->radius[0] = splat->radius[1] = (float)radius;
}

/* Places rows of splats along the ring. The number of splats in a row depends on its length, so
 * that all lie about as far apart as the rows do. */
scene detail_torus(void) {
    const double ring = 0.72, tube = 0.28;
    const int rows = 40;
    double apart = 2 * CAMERA_PI * tube / rows, radius = 0.9 * apart;
    scene s = scene_blank(2 * COUNT);
    s.count = 0;
    for (int row = 0; row < rows; ++row) {
        double a = 2 * CAMERA_PI * row / rows, distance = ring + tube * cos(a);
        int columns = (int)ceil(2 * CAMERA_PI * distance / apart);
        for (int column = 0; column < columns; ++column) {
            double b = 2 * CAMERA_PI * (column + 0.5 * (row % 2)) / columns;
            double u[3] = {-sin(b), cos(b), 0}, v[3] = {-sin(a) * cos(b), -sin(a) * sin(b), cos(a)};
            double center[3] = {distance * cos(b), distance * sin(b), tube * sin(a)};
            psplat_splat *splat = &s.splats[s.count++];
            place(splat, center, u, v, radius, 0.5);
            splat->gradient[0] = (float)(radius * cos(a) / distance);
            splat->gradient[1] = (float)(radius / tube);
        }
    }
    return s;
}

/* Places splats on a disc by the lattice of scene_sphere. */
scene detail_plate(void) {
    const double golden_angle = 2.399963229728653, fields = 4;
    scene s = scene_blank(COUNT);
    s.has_color = 1;
    s.material.unlit = 1;
    for (size_t i = 0; i < s.count; ++i) {
        double out = sqrt(((double)i + 0.5) / COUNT), angle = golden_angle * (double)i;
        double center[3] = {out * cos(angle), out * sin(angle), 0};
        double u[3] = {1, 0, 0}, v[3] = {0, 1, 0};
        appearance(&s.splats[i], fields * center[0], fields * center[1]);
        place(&s.splats[i], center, u, v, 0.9 * sqrt(CAMERA_PI / COUNT), 0.2);
    }
    return s;
}
