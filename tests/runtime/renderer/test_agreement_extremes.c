/* SPDX-License-Identifier: MIT
 *
 * test_agreement_extremes.c - tests the renderer against the reference rasteriser where renderers
 * usually fail: splats seen along their plane, through the near plane, from inside, far larger than
 * the view or far smaller than a pixel, and unusual viewports.
 */
#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "extreme_view.h"

static psplat_splat *turned(extreme *e, double radius, const double u[3], const double v[3]) {
    psplat_splat *splat = &e->s.splats[0];
    scene_set_axes(splat, u, v);
    for (int i = 0; i < 3; ++i)
        splat->normal[i] =
            (float)(u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
    splat->radius[0] = splat->radius[1] = (float)radius;
    return splat;
}

/* A tenth of a degree from edge-on, (u, v) changes by 1 within a 24th of a pixel, so that each 1e-5
 * of a pixel counts 2.4e-4. */
static void test_edge_on(void **state) {
    extreme e = extreme_of(scene_disc(1));
    double angle = 89.9 * CAMERA_PI / 180;
    psplat_splat *splat = turned(&e, 1, (double[]){1, 0, 0}, (double[]){0, cos(angle), sin(angle)});
    splat->center[1] = (float)(0.5 / 120 * 5); /* on a row of pixel centres */
    extreme_check(*state, "edge-on", &e, (extreme_bounds){.thin_uv = 5e-4, .least = 100});
}

static void test_near_crossing(void **state) {
    extreme e = extreme_of(scene_disc(1));
    psplat_splat *splat = turned(&e, 4, (double[]){0, 0, -1}, (double[]){0, 1, 0});
    splat->center[0] = 0.5f;
    splat->center[2] = 6;
    extreme_check(*state, "through the near plane", &e, (extreme_bounds){.least = 4 * 5000});
}

static void test_eye_inside(void **state) {
    extreme e = extreme_of(scene_disc(1));
    psplat_splat *splat = turned(&e, 10, (double[]){1, 0, 0}, (double[]){0, 0, -1});
    splat->center[1] = -0.01f;
    splat->center[2] = 5;
    extreme_check(*state, "the eye inside", &e, (extreme_bounds){.least = 4 * 400});
}

static void test_huge(void **state) {
    extreme e = extreme_of(scene_disc(1));
    psplat_splat *splat = turned(&e, 1000, (double[]){1, 0, 0}, (double[]){0, 1, 0});
    splat->center[0] = 800;
    splat->center[1] = 500;
    extreme_check(*state, "huge, its centre far outside", &e,
                  (extreme_bounds){.least = 4 * 160 * 120});
}

/* The needle is 4e-4 pixels wide and twice as long as the view; (u, v) changes by 2 a pixel across
 * it. */
static void test_needle(void **state) {
    extreme e = extreme_of(scene_disc(1));
    turned(&e, 200, (double[]){0.8, 0.6, 0}, (double[]){-0.6, 0.8, 0})->radius[1] = 0.02f;
    extreme_check(*state, "200 x 0.02", &e, (extreme_bounds){.thin_uv = 1e-3, .least = 4 * 100});
}

/* Draws 20000 splats of a 20th of a pixel. */
static void test_below_a_pixel(void **state) {
    extreme e = extreme_of(scene_sphere(20000, 1));
    camera_perspective(&e.view, 40, 1, 10);
    extreme_check(*state, "a 20th of a pixel each", &e,
                  (extreme_bounds){.thin_uv = 1e-3, .least = 4 * 150});
}

static void test_far_away(void **state) {
    extreme e = extreme_of(scene_sphere(2000, 1));
    camera_look(&e.view, (double[]){0, 0, 100}, (double[]){0, 0, 0});
    camera_perspective(&e.view, 2000, 90, 110);
    extreme_check(*state, "from 100 radii", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 1000});
}

static void test_no_tolerance(void **state) {
    extreme e = extreme_of(scene_ellipses(100, 2, 5));
    e.s.depth_tolerance = 0;
    extreme_check(*state, "epsilon 0", &e, (extreme_bounds){.thin_uv = 5e-4, .least = 500});
}

static void test_far_over_near(void **state) {
    extreme e = extreme_of(scene_disc(1));
    camera_perspective(&e.view, 120, 1e-3, 1e4);
    extreme_check(*state, "far / near = 1e7", &e, (extreme_bounds){.least = 4 * 1500});
}

/* ---- projections ---------------------------------------------------------------------------- */

/* Returns a sphere whose back faces are culled: where sides are confused, its inside shows. */
static extreme culled_sphere(void) {
    extreme e = extreme_of(scene_sphere(300, 1));
    e.s.material.double_sided = 0;
    camera_perspective(&e.view, 120, 1, 20);
    return e;
}

static void test_infinite_far_plane(void **state) {
    extreme e = culled_sphere();
    e.view.projection[10] = -1;
    e.view.projection[14] = -2;
    extreme_check(*state, "far plane at infinity", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 1500});
}

/* Planar reflections and framebuffers with row 0 on top use mirrored projections. */
static void test_mirrored_projection(void **state) {
    for (int axis = 0; axis < 2; ++axis) {
        extreme e = culled_sphere();
        for (int i = 0; i < 4; ++i) e.view.projection[4 * i + axis] *= -1;
        extreme_check(*state, axis ? "mirrored in y" : "mirrored in x", &e,
                      (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 1500});
    }
}

/* The projection is off the axis and turned by a quarter, and the whole matrix is multiplied by 3,
 * which is the same projection. */
static void test_odd_projection(void **state) {
    extreme e = culled_sphere();
    double *p = e.view.projection;
    const double x = p[0], y = p[5];
    p[0] = p[5] = 0;
    p[1] = x;
    p[4] = -y;
    p[8] = 0.2;
    p[9] = -0.1;
    for (int i = 0; i < 16; ++i) p[i] *= 3;
    extreme_check(*state, "off the axis, turned, times 3", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 1500});
}

/* Draws images of one pixel, and images one pixel high or wide. */
static void test_tiny_images(void **state) {
    const int sizes[][2] = {{1, 1}, {97, 1}, {1, 61}};
    for (int i = 0; i < 3; ++i) {
        extreme e = extreme_of(scene_disc(1));
        e.view.width = sizes[i][0];
        e.view.height = sizes[i][1];
        camera_perspective(&e.view, 120, 1, 10);
        extreme_check(*state, "1 x 1, 97 x 1, 1 x 61", &e,
                      (extreme_bounds){.thin_uv = 1e-5, .least = 4});
    }
}

/* ---- a viewport inside a larger framebuffer -------------------------------------------------- */

static void draw_at(gpu *g, psplat_model *model, psplat_view view, int x, int y, float *rgba) {
    psplat_error error;
    view.x = x;
    view.y = y;
    assert_int_equal(psplat_host_begin(g->host, 100, 80, 1, (float[]){0, 0, 0, 0}, &error), 0);
    assert_int_equal(psplat_draw(g->renderer, &view, &(psplat_item){.model = model}, 1, &error), 0);
    assert_int_equal(psplat_host_read_float(g->host, rgba, &error), 0);
}

/* The picture moves with the viewport in all modes, and nothing else changes. */
static void test_viewport(void **state) {
    gpu *g = *state;
    enum { size = 4 * 100 * 80, x0 = 33, y0 = 17 };
    extreme e = extreme_of(scene_sphere(200, 1));
    e.view.width = 64;
    e.view.height = 48;
    camera_perspective(&e.view, 80, 1, 10);
    psplat_asset *asset = scene_open(&e.s);
    psplat_model *model = NULL;
    float *origin = malloc(size * sizeof *origin), *moved = malloc(size * sizeof *moved);
    assert_int_equal(psplat_model_create(g->renderer, asset, &model, NULL), PSPLAT_OK);
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        e.view.mode = (psplat_mode)mode;
        draw_at(g, model, e.view, 0, 0, origin);
        draw_at(g, model, e.view, x0, y0, moved);
        size_t covered = 0;
        for (int i = 0; i < 100 * 80; ++i) {
            int x = i % 100 - x0, y = i / 100 - y0, inside = x >= 0 && y >= 0;
            for (int c = 0; c < 4; ++c) {
                float from = inside ? origin[4 * (y * 100 + x) + c] : 0;
                /* Interpolation starts at another place, so that the last bits may differ. */
                assert_true(fabsf(moved[4 * i + c] - from) <= 1e-4f);
            }
            covered += moved[4 * i + 3] > 0;
        }
        assert_true(covered > 500);
    }
    free(origin);
    free(moved);
    psplat_model_destroy(g->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&e.s);
}

int test_agreement_extremes_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_near_crossing),
        cmocka_unit_test(test_eye_inside),
        cmocka_unit_test(test_huge),
        cmocka_unit_test(test_needle),
        cmocka_unit_test(test_below_a_pixel),
        cmocka_unit_test(test_far_away),
        cmocka_unit_test(test_no_tolerance),
        cmocka_unit_test(test_far_over_near),
        cmocka_unit_test(test_tiny_images),
        cmocka_unit_test(test_viewport),
        cmocka_unit_test(test_infinite_far_plane),
        cmocka_unit_test(test_mirrored_projection),
        cmocka_unit_test(test_odd_projection),
    };
    return cmocka_run_group_tests(tests, gpu_setup_gl, gpu_teardown);
}
