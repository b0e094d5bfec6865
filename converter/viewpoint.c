/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * viewpoint.c - a view of a whole model: a camera on a sphere around it, lit over the shoulder.
 */
#include "command.h"

#include <math.h>
#include <string.h>

/* A short lens distorts the model, a long one flattens it; this is a 50 mm lens on 35 mm film,
 * held horizontally. */
static const double vertical_field_degrees = 27;
static const double pi = 3.14159265358979323846;

typedef struct frame {
    double right[3], up[3], back[3]; /* the camera's x, y and z axes in the scene */
} frame;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* From the angles alone, so that looking straight down has a defined up as well. */
static frame look(double azimuth, double elevation) {
    double sa = sin(azimuth), ca = cos(azimuth), se = sin(elevation), ce = cos(elevation);
    frame f = {{ca, 0, -sa}, {-se * sa, ce, -se * ca}, {ce * sa, se, ce * ca}};
    return f;
}

static void set_view(const frame *f, const double eye[3], double m[16]) {
    const double *axes[3] = {f->right, f->up, f->back};
    memset(m, 0, 16 * sizeof *m);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) m[column * 4 + row] = axes[row][column];
        m[12 + row] = -dot(axes[row], eye);
    }
    m[15] = 1;
}

static void set_projection(double half_height, double aspect, double near, double far,
                           double m[16]) {
    memset(m, 0, 16 * sizeof *m);
    m[0] = 1 / (half_height * aspect);
    m[5] = 1 / half_height;
    m[10] = -(far + near) / (far - near);
    m[11] = -1;
    m[14] = -2 * far * near / (far - near);
}

/* A key light from the upper left behind the camera separates faces that meet at any edge; the
 * ambient term keeps those turned away from it visible. Together they light white to about 1. */
static void set_light(const frame *f, psplat_light *light) {
    for (int i = 0; i < 3; ++i) {
        light->direction[i] = (float)(f->back[i] + 0.8 * f->up[i] - 0.6 * f->right[i]);
        light->color[i] = (float)(0.85 * pi);
        light->ambient[i] = 0.12f;
    }
}

void psplat_viewpoint_fit(const psplat_viewpoint *viewpoint, const double min[3],
                          const double max[3], psplat_view *view) {
    double center[3], eye[3], radius = 0;
    for (int i = 0; i < 3; ++i) {
        center[i] = 0.5 * (min[i] + max[i]);
        radius += 0.25 * (max[i] - min[i]) * (max[i] - min[i]);
    }
    radius = sqrt(radius);
    double half = vertical_field_degrees * pi / 360, aspect = (double)view->width / view->height;
    double narrow = atan(tan(half) * fmin(aspect, 1));
    double distance = (viewpoint->distance > 0 ? viewpoint->distance : 1) * radius / sin(narrow);
    frame f = look(viewpoint->azimuth_degrees * pi / 180, viewpoint->elevation_degrees * pi / 180);
    for (int i = 0; i < 3; ++i) eye[i] = center[i] + distance * f.back[i];
    /* 1 % beyond the sphere for splats that touch it; from within, a thousandth of the far plane
     * leaves depth of 24 bits enough steps. */
    double far = distance + 1.01 * radius, near = fmax(distance - 1.01 * radius, far / 1000);
    set_view(&f, eye, view->view);
    set_projection(tan(half), aspect, near, far, view->projection);
    set_light(&f, &view->light);
}
