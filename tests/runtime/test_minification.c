/* SPDX-License-Identifier: MIT
 * Models that shrink to 16 pixels do not flicker under camera motion below a pixel. The truth is
 * the renderer's own picture at eight times the size, averaged in linear light; flicker is how much
 * more than it a pixel changes from frame to frame. Only pixels that the model fills count:
 * outlines have no partial coverage, with the filter of spec 5.8 or without. */
#include "agreement.h"
#include "scene.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#define MODEL 16 /* pixels across */
#define SIZE (MODEL + 8)
#define FINER 8
#define FRAMES 16

/* ---- models ---------------------------------------------------------------------------------- */

/* A sphere of 24 x 48 black and white fields: at 16 pixels, one is a third of a pixel wide. */
static scene checkered(void) {
    const int fields = 24;
    scene s = scene_sphere(4000, 1);
    s.has_color = 1;
    s.material.unlit = 1;
    for (size_t i = 0; i < s.count; ++i) {
        const float *c = s.splats[i].center;
        double latitude = acos(fmin(fmax((double)c[2], -1), 1)) / CAMERA_PI * fields;
        double longitude = (atan2((double)c[1], (double)c[0]) / CAMERA_PI + 1) * fields;
        int is_white = ((int)floor(latitude) + (int)floor(longitude)) & 1;
        for (int k = 0; k < 3; ++k) s.splats[i].color[k] = is_white ? 1 : 0.05f;
    }
    return s;
}

static void normalise(double a[3]) {
    double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    for (int i = 0; i < 3; ++i) a[i] /= length;
}

/* The point in a direction of any length of a sphere with bumps all over. */
static void bump(const double direction[3], double out[3]) {
    double d[3] = {direction[0], direction[1], direction[2]};
    normalise(d);
    double height = 1 + 0.12 * sin(12 * d[0]) * sin(12 * d[1]) * sin(12 * d[2]);
    for (int i = 0; i < 3; ++i) out[i] = d[i] * height;
}

/* Tangents of the bumps where the splat's centre was, by differences. */
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
    for (int i = 0; i < 2; ++i) splat->radius[i] *= 1.4f; /* bumps are larger than the sphere */
}

/* A sphere with some 200 bumps, their flanks up to 55 degrees steep: at 16 pixels, one is a pixel
 * wide. */
static scene bumpy(void) {
    scene s = scene_sphere(4000, 1);
    for (size_t i = 0; i < s.count; ++i) settle(&s.splats[i]);
    s.depth_tolerance = 0.01f;
    return s;
}

/* ---- frames ---------------------------------------------------------------------------------- */

typedef struct frame {
    double value[SIZE * SIZE]; /* red, linear */
    double covered[SIZE * SIZE];
} frame;

/* Frame k of a camera that moves by a pixel along x and two thirds along y. */
static psplat_view view_of(int k) {
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){0, 0, 10}, (double[]){0, 0, 0});
    camera_perspective(&view, MODEL / 2.0 * sqrt(99), 8, 12);
    view.projection[8] = 2.0 * k / FRAMES / SIZE;
    view.projection[9] = 2.0 * k / (1.5 * FRAMES) / SIZE;
    for (int i = 0; i < 3; ++i) {
        view.lights[0].direction[i] = (float[]){-0.6f, -0.5f, -0.7f}[i];
        view.ambient[i] = 0.05f;
    }
    return view;
}

/* finer: pixels a pixel is averaged of, in each direction. */
static frame *draw(gpu *g, psplat_model *model, psplat_view view, int finer) {
    psplat_error error;
    psplat_item item = {.model = model};
    view.width *= finer;
    view.height *= finer;
    size_t pixels = (size_t)view.width * (size_t)view.height;
    float *rgba = malloc(pixels * 4 * sizeof *rgba);
    frame *f = calloc(1, sizeof *f);
    const float clear[4] = {0, 0, 0, 0};
    assert_true(rgba && f);
    assert_int_equal(psplat_host_begin(g->host, view.width, view.height, 1, clear, &error), 0);
    assert_int_equal(psplat_draw(g->renderer, &view, &item, 1, &error), 0);
    assert_int_equal(psplat_host_read_float(g->host, rgba, &error), 0);
    for (size_t i = 0; i < pixels; ++i) {
        size_t x = i % (size_t)view.width / (size_t)finer,
               y = i / (size_t)view.width / (size_t)finer;
        f->value[y * SIZE + x] += (double)rgba[4 * i] / (finer * finer);
        f->covered[y * SIZE + x] += (double)rgba[4 * i + 3] / (finer * finer);
    }
    free(rgba);
    return f;
}

/* Figures of one way to draw against the truth. */
typedef struct figures {
    double change, most_change;   /* of a pixel between frames: mean and most */
    double flicker, most_flicker; /* how that differs from the truth's */
    double error;                 /* mean difference from the truth */
    size_t count;
} figures;

static void compare(const frame *a, const frame *b, const frame *true_a, const frame *true_b,
                    figures *sum) {
    for (int i = 0; i < SIZE * SIZE; ++i) {
        if (true_a->covered[i] < 1 || true_b->covered[i] < 1) continue;
        double change = b->value[i] - a->value[i];
        double flicker = fabs(change - (true_b->value[i] - true_a->value[i]));
        sum->change += fabs(change);
        sum->most_change = fmax(sum->most_change, fabs(change));
        sum->flicker += flicker;
        sum->most_flicker = fmax(sum->most_flicker, flicker);
        sum->error += fabs(a->value[i] - true_a->value[i]);
        ++sum->count;
    }
}

static void report(const char *name, figures *f) {
    f->change /= (double)f->count;
    f->flicker /= (double)f->count;
    f->error /= (double)f->count;
    print_message("%-16s change mean %.4f most %.3f, flicker mean %.4f most %.3f, error %.4f\n",
                  name, f->change, f->most_change, f->flicker, f->most_flicker, f->error);
}

/* The truth, the renderer without the filter, and with it. */
static void measure(gpu *g, scene s, figures result[3]) {
    frame *frames[3][FRAMES];
    psplat_asset *asset = scene_open(&s);
    psplat_model *model = NULL;
    assert_int_equal(psplat_model_create(g->renderer, asset, &model, NULL), PSPLAT_OK);
    for (int k = 0; k < FRAMES; ++k)
        for (int way = 0; way < 3; ++way) {
            psplat_view view = view_of(k);
            view.no_filter = way < 2;
            frames[way][k] = draw(g, model, view, way ? 1 : FINER);
        }
    for (int way = 0; way < 3; ++way) {
        result[way] = (figures){0};
        for (int k = 0; k + 1 < FRAMES; ++k)
            compare(frames[way][k], frames[way][k + 1], frames[0][k], frames[0][k + 1],
                    &result[way]);
        report((const char *[]){" at 8 x 8", " without filter", " with filter"}[way], &result[way]);
    }
    for (int k = 0; k < 3 * FRAMES; ++k) free(frames[k / FRAMES][k % FRAMES]);
    psplat_model_destroy(g->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* ---- tests ----------------------------------------------------------------------------------- */

/* Far nearer to the truth with the filter than without; the checker, which averages to grey,
 * changes no more than it does in truth. */
static void test_checkered(void **state) {
    figures f[3];
    print_message("checkered sphere of 4000 splats, %d pixels across\n", MODEL);
    measure(*state, checkered(), f);
    assert_true(f[0].count > 100 * (FRAMES - 1));
    assert_true(f[2].flicker * 5 < f[1].flicker);
    assert_true(f[2].most_flicker * 4 < f[1].most_flicker);
    assert_true(f[2].error * 4 < f[1].error);
    assert_true(f[2].change < 1.25 * f[0].change);
}

/* Normals average, highlights do not, and what hides what is not filtered: less is gained. */
static void test_bumpy(void **state) {
    figures f[3];
    print_message("sphere with bumps of 4000 splats, %d pixels across\n", MODEL);
    measure(*state, bumpy(), f);
    assert_true(f[0].count > 100 * (FRAMES - 1));
    assert_true(f[2].flicker * 3 < f[1].flicker);
    assert_true(f[2].most_flicker < f[1].most_flicker);
    assert_true(f[2].error * 1.4 < f[1].error);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_checkered),
        cmocka_unit_test(test_bumpy),
    };
    return cmocka_run_group_tests(tests, gpu_setup_gl, gpu_teardown);
}
