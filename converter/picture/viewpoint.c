/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * viewpoint.c - the camera and light of a picture of a whole model: the camera is on a sphere
 * around the model, the light comes from behind the camera.
 */
#include "picture/viewpoint.h"

#include "base/angle.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <string.h>

/* The vertical field of view: that of a 50 mm lens on 35 mm film held horizontally. A shorter lens
 * would distort the model, a longer one would flatten it. */
static const double vertical_field_degrees = 27;

typedef struct frame {
    double right[3], up[3], back[3]; /* the camera's x, y and z axes in the scene */
} frame;

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the camera's axes. They follow from the angles alone, so that up is defined even in a
 * view straight down. */
static frame camera_axes(double azimuth, double elevation) {
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

/* Sets a key light above the camera and a little to its left, and ambient light that keeps surfaces
 * visible which face away from it. The numbers are chosen by hand: from the default viewpoint the
 * light meets the front, the top and the right side of a box at cosines of 0.53, 0.83 and 0.15, and
 * white appears with a brightness of about 1. */
static void set_light(const frame *f, psplat_view *view) {
    psplat_light *light = &view->lights[0];
    view->light_count = 1;
    for (int i = 0; i < 3; ++i) {
        light->direction[i] = (float)(0.15 * f->right[i] - 0.65 * f->up[i] - 0.85 * f->back[i]);
        light->color[i] = (float)(0.85 * PSPLAT_PI);
        view->ambient[i] = 0.12f;
    }
}

void psplat_viewpoint_fit(const psplat_viewpoint *viewpoint, const double center[3], double radius,
                          psplat_view *view) {
    double eye[3], half = vertical_field_degrees * PSPLAT_PI / 360;
    double aspect = (double)view->width / view->height;
    double narrow = atan(tan(half) * fmin(aspect, 1));
    double distance = (viewpoint->distance > 0 ? viewpoint->distance : 1) * radius / sin(narrow);
    frame f = camera_axes(viewpoint->azimuth_degrees * PSPLAT_PI / 180,
                          viewpoint->elevation_degrees * PSPLAT_PI / 180);
    for (int i = 0; i < 3; ++i) eye[i] = center[i] + distance * f.back[i];
    /* The planes lie 1 % beyond the sphere, so that splats which touch it are not cut. From within
     * the sphere the near plane is at a thousandth of the far one, which leaves a depth buffer of
     * 24 bits enough steps. */
    double far = distance + 1.01 * radius, near = fmax(distance - 1.01 * radius, far / 1000);
    set_view(&f, eye, view->view);
    set_projection(tan(half), aspect, near, far, view->projection);
    set_light(&f, view);
}

/* Changes a row of the column-major projection so that, of `whole` pixels, [begin, begin + size)
 * map to -1 ... 1. */
static void crop_row(double m[16], int row, int whole, int begin, int size) {
    double scale = (double)whole / size, shift = ((double)whole - 2.0 * begin - size) / size;
    for (int column = 0; column < 4; ++column)
        m[column * 4 + row] = scale * m[column * 4 + row] + shift * m[column * 4 + 3];
}

void psplat_viewpoint_crop(psplat_view *view, int x, int y, int width, int height) {
    crop_row(view->projection, 0, view->width, x, width);
    crop_row(view->projection, 1, view->height, y, height);
    view->width = width;
    view->height = height;
}

/* ---- the bounding sphere ------------------------------------------------------------------ */

enum { SIDES = 16, TANGENTS = 4, MAX_CORNERS = SIDES + TANGENTS * PSPLAT_MAX_CLIP_LINES };

typedef struct outline {
    double corners[MAX_CORNERS][2]; /* (u, v) */
    int count;
} outline;

/* Returns a polygon that contains the unit circle, so that the ellipse cannot leave the sphere. */
static outline circle(void) {
    outline o = {.count = SIDES};
    for (int i = 0; i < SIDES; ++i) {
        double angle = 2 * PSPLAT_PI * i / SIDES;
        o.corners[i][0] = cos(angle) / cos(PSPLAT_PI / SIDES);
        o.corners[i][1] = sin(angle) / cos(PSPLAT_PI / SIDES);
    }
    return o;
}

/* Returns the value of a line of a bend at a point (spec 3.6). */
static double line_value(const double line[3], double bend, const double at[2]) {
    double across = line[0] * at[1] - line[1] * at[0];
    return line[0] * at[0] + line[1] * at[1] + line[2] + bend * across * across / 2;
}

/* Stores the point between two where a line that keeps the first and not the second, and does not
 * bulge out, ends what it keeps. */
static void cross(const double line[3], double bend, const double in[2], const double out[2],
                  double at[2]) {
    double across = line[0] * (out[1] - in[1]) - line[1] * (out[0] - in[0]);
    double square = bend * across * across / 2, first = line_value(line, bend, in);
    double slope = line_value(line, bend, out) - first - square; /* below 0 */
    double t = 2 * first / (sqrt(slope * slope - 4 * square * first) - slope);
    for (int k = 0; k < 2; ++k) at[k] = in[k] + t * (out[k] - in[k]);
}

/* Clips a convex outline by one line that does not bulge out (Sutherland and Hodgman 1974), to the
 * convex hull of what that keeps. A straight line adds at most one corner, a bent one few. */
static outline cut(const outline *o, const double line[3], double bend) {
    outline kept = {.count = 0};
    for (int i = 0; i < o->count; ++i) {
        const double *a = o->corners[i], *b = o->corners[(i + 1) % o->count];
        int keeps_a = line_value(line, bend, a) >= 0, keeps_b = line_value(line, bend, b) >= 0;
        if (keeps_a && kept.count < MAX_CORNERS)
            memcpy(kept.corners[kept.count++], a, sizeof *kept.corners);
        if (keeps_a == keeps_b || kept.count == MAX_CORNERS) continue;
        cross(line, bend, keeps_a ? a : b, keeps_a ? b : a, kept.corners[kept.count++]);
    }
    return kept;
}

/* Clips an outline by one clip line and its bend. A line that bulges out keeps less than each of
 * its tangents does. */
static outline cut_by(const outline *o, const float clip[3], double bend) {
    const double line[3] = {(double)clip[0], (double)clip[1], (double)clip[2]};
    double length2 = line[0] * line[0] + line[1] * line[1];
    outline kept = *o;
    if (bend >= 0) return cut(o, line, bend);
    for (int i = 0; i < TANGENTS; ++i) {
        double place = ((2 * i + 1) / (double)TANGENTS - 1) * sqrt(length2);
        const double tangent[3] = {line[0] - bend * place * line[1],
                                   line[1] + bend * place * line[0],
                                   line[2] - bend * place * place / 2};
        kept = cut(&kept, tangent, 0);
    }
    return kept;
}

/* Rotates a vector by the unit quaternion q. */
static void rotate(const float q[4], const double v[3], double out[3]) {
    double x = (double)q[0], y = (double)q[1], z = (double)q[2], w = (double)q[3];
    double t[3] = {2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])};
    out[0] = v[0] + w * t[0] + y * t[2] - z * t[1];
    out[1] = v[1] + w * t[1] + z * t[0] - x * t[2];
    out[2] = v[2] + w * t[2] + x * t[1] - y * t[0];
}

/* Returns the height of a splat's surface over its plane at (u, v) (spec eq. 1a). */
static double height_of(const psplat_splat *s, double u, double v) {
    double q = (double)s->radius[1] / (double)s->radius[0];
    double along = (double)s->shape[0] + (double)s->shape[2] * u / 2 + (double)s->shape[4] * q * v;
    double across = (double)s->shape[1] + (double)s->shape[3] * v / 2;
    return -(double)s->radius[0] * (along * u + across * q * v);
}

static int is_curved(const psplat_splat *s) {
    for (int k = 0; k < 5; ++k)
        if (s->shape[k] != 0) return 1;
    return 0;
}

/* Calls visit with the point of a splat's surface at (u, v), placed by the matrix m. */
static void visit_point(const psplat_splat *s, const double m[16], double u, double v,
                        void (*visit)(void *user, const double p[3]), void *user) {
    double local[3] = {u * (double)s->radius[0], v * (double)s->radius[1], height_of(s, u, v)};
    double p[3], q[3];
    rotate(s->rotation, local, p);
    for (int r = 0; r < 3; ++r) p[r] += (double)s->center[r];
    for (int r = 0; r < 3; ++r) q[r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
    visit(user, q);
}

/* Calls visit with the corners of the outline of a splat, which so many lines cut. Within it a
 * curved splat may reach farther, so there it is visited on some rings around the outline's middle,
 * and in that. */
static void visit_splat(const psplat_splat *s, uint32_t lines, const double m[16],
                        void (*visit)(void *user, const double p[3]), void *user) {
    enum { RINGS = 4 };
    outline o = circle();
    double middle[2] = {0, 0};
    int rings = is_curved(s) ? RINGS : 1;
    /* Those that bulge in come last: the hull of what they keep is smaller then. */
    for (uint32_t k = 0; k < 2 * lines; ++k)
        if ((k < lines) == (s->bend[k % lines] <= 0))
            o = cut_by(&o, s->clip[k % lines], (double)s->bend[k % lines]);
    for (int k = 0; k < o.count; ++k)
        for (int i = 0; i < 2; ++i) middle[i] += o.corners[k][i] / o.count;
    for (int ring = 0; ring < rings; ++ring)
        for (int k = 0; k < o.count; ++k) {
            double t = (double)ring / RINGS;
            visit_point(s, m, o.corners[k][0] + t * (middle[0] - o.corners[k][0]),
                        o.corners[k][1] + t * (middle[1] - o.corners[k][1]), visit, user);
        }
    if (o.count && rings > 1) visit_point(s, m, middle[0], middle[1], visit, user);
}

/* Calls visit with points of the surface of every splat in the scene, in a pose or at rest. */
static void visit_all(const psplat_asset *asset, const psplat_pose *pose,
                      void (*visit)(void *user, const double p[3]), void *user) {
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        const double *m = pose ? psplat_pose_matrix(pose, b) : batch->model;
        for (size_t i = 0; i < batch->splat_count; ++i)
            visit_splat(&batch->splats[i], batch->clip_count - batch->seam_lines, m, visit, user);
    }
}

/* Calls visit with those points at several times of an animation, to which it sets the pose. */
static psplat_result visit_over(const psplat_asset *asset, size_t animation, psplat_pose *pose,
                                void (*visit)(void *user, const double p[3]), void *user,
                                psplat_error *error) {
    enum { TIMES = 9 };
    const psplat_animation *info = psplat_asset_get_animation(asset, animation);
    for (int i = 0; i < TIMES; ++i) {
        double time = info ? info->duration * i / (TIMES - 1) : 0;
        psplat_result result = psplat_pose_set(pose, animation, time, error);
        if (result) return result;
        visit_all(asset, pose, visit, user);
    }
    return PSPLAT_OK;
}

typedef struct extent {
    double min[3], max[3], center[3], radius;
} extent;

static void grow_box(void *user, const double p[3]) {
    extent *e = user;
    for (int i = 0; i < 3; ++i) {
        e->min[i] = fmin(e->min[i], p[i]);
        e->max[i] = fmax(e->max[i], p[i]);
    }
}

static void grow_sphere(void *user, const double p[3]) {
    extent *e = user;
    double d[3] = {p[0] - e->center[0], p[1] - e->center[1], p[2] - e->center[2]};
    e->radius = fmax(e->radius, sqrt(dot(d, d)));
}

/* Puts the middle of the box where it was found; bounds are those to fall back on. Clip lines may
 * leave nothing of any splat; then the centres and radii have to do. */
static void find_center(extent *e, const double min[3], const double max[3], double center[3]) {
    int is_empty = !(e->min[0] <= e->max[0]);
    for (int i = 0; i < 3; ++i) {
        if (is_empty) e->min[i] = min[i], e->max[i] = max[i];
        e->center[i] = center[i] = 0.5 * (e->min[i] + e->max[i]);
    }
}

static const extent nothing = {.min = {INFINITY, INFINITY, INFINITY},
                               .max = {-INFINITY, -INFINITY, -INFINITY}};

void psplat_viewpoint_sphere(const psplat_asset *asset, double center[3], double *radius) {
    extent e = nothing;
    double min[3], max[3];
    visit_all(asset, NULL, grow_box, &e);
    psplat_asset_bounds(asset, min, max);
    find_center(&e, min, max, center);
    visit_all(asset, NULL, grow_sphere, &e);
    *radius = e.radius > 0 ? e.radius : 1;
}

psplat_result psplat_viewpoint_sphere_over(const psplat_asset *asset, size_t animation,
                                           double center[3], double *radius, psplat_error *error) {
    extent e = nothing;
    double min[3], max[3];
    psplat_pose *pose;
    psplat_result result = psplat_pose_create(asset, &pose, error);
    if (!result) result = visit_over(asset, animation, pose, grow_box, &e, error);
    psplat_asset_bounds(asset, min, max);
    find_center(&e, min, max, center);
    if (!result) result = visit_over(asset, animation, pose, grow_sphere, &e, error);
    *radius = e.radius > 0 ? e.radius : 1;
    psplat_pose_destroy(pose);
    return result;
}
