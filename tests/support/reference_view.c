/* SPDX-License-Identifier: MIT
 *
 * reference_view.c - views, and images drawn by the reference rasteriser; see reference_view.h.
 */
#include "reference_view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

psplat_view camera_view(int width, int height) {
    psplat_view view = {
        .width = width, .height = height, .light_count = 1, .no_filter = 1, .linear_output = 1};
    for (int i = 0; i < 16; i += 5) view.view[i] = view.projection[i] = 1;
    view.lights[0].direction[2] = -1;
    for (int i = 0; i < 3; ++i) view.lights[0].color[i] = (float)CAMERA_PI;
    return view;
}

static void normalise(double a[3]) {
    double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

void camera_look(psplat_view *view, const double eye[3], const double target[3]) {
    double back[3] = {eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]};
    normalise(back);
    double up[3] = {0, 1, 0}, right[3];
    if (fabs(back[1]) > 0.999) up[1] = 0, up[2] = 1;
    cross(up, back, right);
    normalise(right);
    cross(back, right, up);
    const double *rows[3] = {right, up, back};
    for (int row = 0; row < 3; ++row) {
        double moved = 0;
        for (int i = 0; i < 3; ++i) {
            view->view[4 * i + row] = rows[row][i];
            moved -= rows[row][i] * eye[i];
        }
        view->view[12 + row] = moved;
    }
}

void camera_perspective(psplat_view *view, double focal, double near, double far) {
    double *m = view->projection;
    memset(m, 0, sizeof view->projection);
    m[0] = 2 * focal / view->width;
    m[5] = 2 * focal / view->height;
    m[10] = -(far + near) / (far - near);
    m[11] = -1;
    m[14] = -2 * far * near / (far - near);
}

void camera_parallel(psplat_view *view, double half_height, double near, double far) {
    double *m = view->projection;
    memset(m, 0, sizeof view->projection);
    m[0] = view->height / (half_height * view->width);
    m[5] = 1 / half_height;
    m[10] = -2 / (far - near);
    m[14] = -(far + near) / (far - near);
    m[15] = 1;
}

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory) return memory;
    fprintf(stderr, "camera: out of memory\n");
    abort();
}

/* Draws what p has arrays for. */
static void draw(const psplat_reference_scene *from, const psplat_view *view, picture *p) {
    psplat_reference_scene with_images = *from, *scene = &with_images;
    psplat_pixels images[8];
    size_t image_count = psplat_asset_image_count(from->asset);
    if (!from->images && image_count > 0 && image_count <= sizeof images / sizeof *images) {
        for (size_t i = 0; i < image_count; ++i) images[i] = scene_pixels(from->asset, i);
        with_images.images = images;
        with_images.image_count = image_count;
    }
    psplat_error error;
    if (psplat_reference_draw(scene, view, &p->image, &error)) {
        fprintf(stderr, "camera: %s\n", error.text);
        abort();
    }
}

static picture nearest_arrays(const psplat_view *view) {
    size_t count = (size_t)view->width * (size_t)view->height;
    picture p = {.width = view->width, .height = view->height};
    p.image.uv = allocate(count, 2 * sizeof(double));
    p.image.splat = allocate(count, sizeof(int32_t));
    return p;
}

picture picture_of_nearest(const psplat_reference_scene *from, const psplat_view *view) {
    picture p = nearest_arrays(view);
    draw(from, view, &p);
    return p;
}

picture picture_of_scene(const psplat_reference_scene *from, const psplat_view *view) {
    size_t count = (size_t)view->width * (size_t)view->height;
    picture p = nearest_arrays(view);
    p.image.color = allocate(count, 4 * sizeof(float));
    p.image.count = allocate(count, sizeof(uint32_t));
    double **arrays[] = {&p.image.depth, &p.image.tie, &p.image.depth_tie, &p.image.epsilon_tie,
                         &p.image.alpha_tie};
    for (int i = 0; i < 5; ++i) *arrays[i] = allocate(count, sizeof(double));
    draw(from, view, &p);
    return p;
}

picture picture_draw(const psplat_asset *asset, const double transform[16],
                     const psplat_view *view) {
    psplat_reference_scene scene = {.asset = asset};
    if (transform) memcpy(scene.transform, transform, sizeof scene.transform);
    return picture_of_scene(&scene, view);
}

picture picture_of(const scene *s, const double transform[16], const psplat_view *view) {
    psplat_asset *asset = scene_open(s);
    picture p = picture_draw(asset, transform, view);
    psplat_asset_destroy(asset);
    return p;
}

size_t picture_covered(const picture *p) {
    size_t count = 0;
    for (int i = 0; i < p->width * p->height; ++i) count += p->image.count[i] > 0;
    return count;
}

void picture_free(picture *p) {
    free(p->image.color);
    free(p->image.uv);
    free(p->image.splat);
    free(p->image.count);
    free(p->image.depth);
    free(p->image.tie);
    free(p->image.depth_tie);
    free(p->image.epsilon_tie);
    free(p->image.alpha_tie);
    *p = (picture){0};
}
