/* SPDX-License-Identifier: MIT
 *
 * orbit.c - a camera that turns about a target, in double precision.
 */
#include "viewer.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
/* Half the field of view, in radians, as `phongsplat render` has it: a 50 mm lens on 35 mm film. */
static const double half_field = 27 * 3.14159265358979323846 / 360;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Computes the axes from the angles alone, so that up is defined when looking straight down as
 * well. */
void orbit_axes(const orbit *o, double axes[3][3]) {
    double sa = sin(o->azimuth), ca = cos(o->azimuth);
    double se = sin(o->elevation), ce = cos(o->elevation);
    const double values[3][3] = {{ca, 0, -sa}, {-se * sa, ce, -se * ca}, {ce * sa, se, ce * ca}};
    memcpy(axes, values, sizeof values);
}

void orbit_fit(orbit *o, const sphere *scene, double aspect) {
    double narrow = atan(tan(half_field) * fmin(aspect, 1));
    memcpy(o->target, scene->center, sizeof o->target);
    o->reach = scene->radius > 0 ? scene->radius : 1;
    o->distance = o->reach / sin(narrow);
}

/* A drag across the height of the window turns by half a turn. */
void orbit_turn(orbit *o, double x, double y) {
    o->azimuth = remainder(o->azimuth - pi * x, 2 * pi);
    o->elevation = fmax(-pi / 2, fmin(pi / 2, o->elevation - pi * y));
}

/* Returns the height of what is seen at the target's distance, in an orthographic view at any
 * distance. */
static double seen_height(const orbit *o) {
    return 2 * o->distance * tan(half_field);
}

void orbit_pan(orbit *o, double x, double y) {
    double axes[3][3], height = seen_height(o);
    orbit_axes(o, axes);
    for (int i = 0; i < 3; ++i) o->target[i] -= height * (x * axes[0][i] + y * axes[1][i]);
}

void orbit_zoom(orbit *o, double steps, double x, double y) {
    double before = o->distance, wanted = before * pow(0.88, steps);
    o->distance = fmax(1e-3 * o->reach, fmin(1e3 * o->reach, wanted));
    /* The point under the pointer, in the plane through the target, stays where it is. */
    double moved = 1 - o->distance / before, axes[3][3];
    double height = 2 * before * tan(half_field);
    orbit_axes(o, axes);
    for (int i = 0; i < 3; ++i) o->target[i] += moved * height * (x * axes[0][i] + y * axes[1][i]);
}

static void set_view(double axes[3][3], const double eye[3], double m[16]) {
    memset(m, 0, 16 * sizeof *m);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) m[column * 4 + row] = axes[row][column];
        m[12 + row] = -dot(axes[row], eye);
    }
    m[15] = 1;
}

static void set_perspective(double aspect, double near, double far, double m[16]) {
    memset(m, 0, 16 * sizeof *m);
    m[0] = 1 / (tan(half_field) * aspect);
    m[5] = 1 / tan(half_field);
    m[10] = -(far + near) / (far - near);
    m[11] = -1;
    m[14] = -2 * far * near / (far - near);
}

static void set_orthographic(double height, double aspect, double near, double far, double m[16]) {
    memset(m, 0, 16 * sizeof *m);
    m[0] = 2 / (height * aspect);
    m[5] = 2 / height;
    m[10] = -2 / (far - near);
    m[14] = -(far + near) / (far - near);
    m[15] = 1;
}

/* The planes lie 1 % beyond the sphere, so that splats that touch it are drawn. When the eye is
 * within the sphere, the near plane at a thousandth of the far plane leaves enough steps of a
 * 24-bit depth buffer. The eye of an orthographic view is moved back until all of the scene is
 * before it, which does not change the picture. */
void orbit_view(const orbit *o, const sphere *scene, int is_orthographic, psplat_view *view) {
    double axes[3][3], eye[3], offset[3];
    double reach = 1.01 * (scene->radius > 0 ? scene->radius : o->reach);
    double aspect = (double)view->width / view->height, distance = o->distance;
    orbit_axes(o, axes);
    for (int i = 0; i < 3; ++i) offset[i] = o->target[i] - scene->center[i];
    double depth = dot(axes[2], offset) + distance;
    if (is_orthographic && depth < 2 * reach) {
        distance += 2 * reach - depth;
        depth = 2 * reach;
    }
    for (int i = 0; i < 3; ++i) eye[i] = o->target[i] + distance * axes[2][i];
    double far = fmax(depth + reach, 1e-3 * reach), near = fmax(depth - reach, far / 1000);
    set_view(axes, eye, view->view);
    if (is_orthographic)
        set_orthographic(seen_height(o), aspect, near, far, view->projection);
    else
        set_perspective(aspect, near, far, view->projection);
}

void orbit_aim(orbit *o, const psplat_view *view, double x, double y, double depth) {
    const double *m = view->view, *p = view->projection;
    double aspect = (double)view->width / view->height, z = 2 * depth - 1;
    int is_orthographic = p[15] != 0;
    /* This is the inverse of either projection above. */
    double eye_z = is_orthographic ? (z - p[14]) / p[10] : -p[14] / (z + p[10]);
    double w = is_orthographic ? 1 : -eye_z;
    double q[3] = {2 * x / aspect * w / p[0], 2 * y * w / p[5], eye_z};
    for (int i = 0; i < 3; ++i) q[i] -= m[12 + i];
    for (int i = 0; i < 3; ++i)
        o->target[i] = m[i * 4] * q[0] + m[i * 4 + 1] * q[1] + m[i * 4 + 2] * q[2];
}
