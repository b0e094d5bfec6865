/* SPDX-License-Identifier: MIT
 *
 * subject.c - subjects and views; see subject.h.
 */
#include "subject.h"

#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the sphere ------------------------------------------------------------------------------ */

typedef struct place {
    uint32_t code; /* the cell's place on the Morton curve */
    uint32_t index;
} place;

static uint32_t morton(const float p[3]) {
    uint32_t code = 0;
    for (uint32_t bit = 0; bit < 10; ++bit)
        for (uint32_t axis = 0; axis < 3; ++axis) {
            uint32_t cell = (uint32_t)fminf(1023.0f, 512.0f * (p[axis] + 1.0f));
            code |= (cell >> bit & 1u) << (3 * bit + axis);
        }
    return code;
}

static int compare(const void *left, const void *right) {
    const place *a = left, *b = right;
    if (a->code != b->code) return a->code < b->code ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

static void sort(scene *s) {
    place *places = malloc(s->count * sizeof *places);
    psplat_splat *sorted = malloc(s->count * sizeof *sorted);
    if (!places || !sorted) abort();
    for (size_t i = 0; i < s->count; ++i)
        places[i] = (place){morton(s->splats[i].center), (uint32_t)i};
    qsort(places, s->count, sizeof *places, compare);
    for (size_t i = 0; i < s->count; ++i) sorted[i] = s->splats[places[i].index];
    free(places);
    free(s->splats);
    s->splats = sorted;
}

/* ---- subjects -------------------------------------------------------------------------------- */

static void place_center(const psplat_batch *batch, size_t splat, double out[3]) {
    const float *p = batch->splats[splat].center;
    for (int i = 0; i < 3; ++i) {
        const double *m = batch->model + i;
        out[i] = m[0] * (double)p[0] + m[4] * (double)p[1] + m[8] * (double)p[2] + m[12];
    }
}

/* Calls a function with each centre in turn. */
static void for_each_center(subject *s, void (*use)(subject *s, const double center[3])) {
    for (size_t i = 0; i < psplat_asset_batch_count(s->asset); ++i) {
        const psplat_batch *batch = psplat_asset_batch(s->asset, i);
        for (size_t k = 0; k < batch->splat_count; ++k) {
            double center[3];
            place_center(batch, k, center);
            use(s, center);
        }
    }
}

static void enlarge_box(subject *s, const double center[3]) {
    for (int i = 0; i < 3; ++i) {
        s->low[i] = s->splat_count ? fmin(s->low[i], center[i]) : center[i];
        s->high[i] = s->splat_count ? fmax(s->high[i], center[i]) : center[i];
    }
    ++s->splat_count;
}

static void enlarge_ball(subject *s, const double center[3]) {
    double square = 0;
    for (int i = 0; i < 3; ++i) square += (center[i] - s->center[i]) * (center[i] - s->center[i]);
    s->radius = fmax(s->radius, sqrt(square));
}

/* The asset's own bounds enclose whole ellipses, of which clip lines may leave only a small part;
 * the centres are used instead. */
static subject describe(const char *name, psplat_asset *asset) {
    subject s = {.name = name, .asset = asset};
    for_each_center(&s, enlarge_box);
    for (int i = 0; i < 3; ++i) s.center[i] = 0.5 * (s.low[i] + s.high[i]);
    for_each_center(&s, enlarge_ball);
    if (!(s.radius > 0)) s.radius = 1;
    return s;
}

subject subject_sphere(size_t count) {
    scene s = scene_sphere(count, 1.0f);
    sort(&s);
    subject sphere = describe("sphere", scene_open(&s));
    scene_free(&s);
    return sphere;
}

subject subject_curved_sphere(size_t count) {
    scene s = scene_sphere(count, 1.0f);
    sort(&s);
    scene_curve(&s);
    s.depth_tolerance = 0.1f * s.splats[0].radius[0] * s.splats[0].radius[0];
    subject sphere = describe("curved sphere", scene_open(&s));
    scene_free(&s);
    return sphere;
}

subject subject_open(const char *path) {
    psplat_asset *asset = NULL;
    psplat_error error;
    if (psplat_asset_open(path, NULL, &asset, &error)) {
        fprintf(stderr, "bench: %s: %s\n", path, error.text);
        exit(1);
    }
    const char *slash = strrchr(path, '/');
    return describe(slash ? slash + 1 : path, asset);
}

void subject_close(subject *s) {
    psplat_asset_destroy(s->asset);
    *s = (subject){0};
}

psplat_view subject_view(const subject *s, const double direction[3], int size, int light_count) {
    const double half_angle = CAMERA_PI / 8, filled = 0.95;
    psplat_view view = camera_view(size, size);
    double distance = s->radius / sin(half_angle * filled), eye[3];
    double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] +
                         direction[2] * direction[2]);
    for (int i = 0; i < 3; ++i) eye[i] = s->center[i] + distance * direction[i] / length;
    camera_look(&view, eye, s->center);
    camera_perspective(&view, 0.5 * size / tan(half_angle), distance - 1.6 * s->radius,
                       distance + 1.6 * s->radius);
    view.light_count = light_count;
    for (int k = 0; k < light_count; ++k) {
        double angle = 2 * CAMERA_PI * k / light_count;
        for (int i = 0; i < 3; ++i) {
            double right = view.view[4 * i], up = view.view[4 * i + 1], back = view.view[4 * i + 2];
            view.lights[k].direction[i] =
                (float)(-back + 0.5 * (cos(angle) * right + sin(angle) * up));
            view.lights[k].color[i] = (float)(CAMERA_PI / light_count);
        }
    }
    view.no_filter = 0;
    view.linear_output = 0;
    return view;
}
