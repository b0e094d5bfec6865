/* SPDX-License-Identifier: MIT
 *
 * test_extremes_size.c - tests extreme sizes: of units, distances from the origin, images, splats
 * below a pixel, focal lengths, and of the number of splats in a pixel.
 */
#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "extreme_view.h"

static const agreement_ties usual = {2e-4, 2e-6, 0.02};

/* Returns a sphere whose back faces are culled. */
static extreme culled_sphere(size_t splats) {
    extreme e = extreme_of(scene_sphere(splats, 1));
    e.s.material.double_sided = 0;
    return e;
}

/* ---- units and places ----------------------------------------------------------------------- */

static void scale_asset(scene *s, double scale) {
    for (size_t i = 0; i < s->count; ++i) {
        for (int k = 0; k < 3; ++k) s->splats[i].center[k] *= (float)scale;
        for (int k = 0; k < 2; ++k) s->splats[i].radius[k] *= (float)scale;
    }
    s->depth_tolerance *= (float)scale;
}

/* The unit of the asset and that of the host are varied. */
static void test_units(void **state) {
    const double scales[] = {1e-15, 1e-9, 1e9, 1e15};
    for (int k = 0; k < 4; ++k) {
        char name[64];
        extreme e = culled_sphere(300);
        double scale = scales[k];
        int in_asset = k % 3 == 0;
        if (in_asset) scale_asset(&e.s, scale);
        for (int i = 0; i < 16 && !in_asset; i += 5) e.transform[i] = i < 15 ? scale : 1;
        camera_look(&e.view, (double[]){0, 0, 5 * scale}, (double[]){0, 0, 0});
        camera_perspective(&e.view, 120, scale, 20 * scale);
        snprintf(name, sizeof name, "unit of %g, %s", scale, in_asset ? "asset" : "transform");
        extreme_check(*state, name, &e, (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 1500});
    }
}

static void test_far_from_origin(void **state) {
    const double distances[] = {1e6, 1e8};
    for (int k = 0; k < 2; ++k) {
        char name[64];
        extreme e = culled_sphere(300);
        double far = distances[k];
        e.s.origin[0] = far, e.s.origin[1] = -2 * far, e.s.origin[2] = 3 * far;
        camera_look(&e.view, (double[]){far + 1, -2 * far + 2, 3 * far + 3}, e.s.origin);
        camera_perspective(&e.view, 120, 1, 10);
        snprintf(name, sizeof name, "%g units from the origin", 3.7 * far);
        /* The view's own translation is rounded to 2^-53 of 3.7e8, which is 4e-8. */
        extreme_check(*state, name, &e, (extreme_bounds){.thin_uv = 1e-3, .least = 4 * 1500});
    }
}

/* ---- where the eye is ----------------------------------------------------------------------- */

static void test_eye_in_model(void **state) {
    extreme e = extreme_of(scene_sphere(300, 1));
    camera_look(&e.view, (double[]){0.2, 0.1, 0.05}, (double[]){0.3, 0.3, -1});
    camera_perspective(&e.view, 60, 1e-3, 20);
    /* The limit errs as in near views, by 10 % of epsilon. */
    extreme_check(*state, "the eye inside a model", &e,
                  (extreme_bounds){.thin_uv = 5e-4,
                                   .depth = 2e-6,
                                   .color = 2e-4,
                                   .ties = {2e-4, 2e-6, 0.1},
                                   .least = 4 * 15000});
}

static void test_parallel(void **state) {
    extreme e = culled_sphere(300);
    camera_parallel(&e.view, 1.5, 0.1, 20);
    extreme_check(*state, "orthographic, a ball", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 3000});
    e = extreme_of(scene_sphere(300, 1));
    camera_parallel(&e.view, 1.5, 4.5, 20);
    extreme_check(*state, "orthographic, a ball cut by the near plane", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 3000});
    e = culled_sphere(300);
    camera_parallel(&e.view, 1.5, -20, 20);
    camera_look(&e.view, (double[]){0, 0, 0}, (double[]){0, 0, -1});
    extreme_check(*state, "orthographic, the eye inside a ball", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .least = 4 * 3000});
}

/* Draws a view of 179.3 degrees from inside, and one of 0.01 degrees from far away. */
static void test_focal_lengths(void **state) {
    extreme e = extreme_of(scene_sphere(300, 1));
    camera_look(&e.view, (double[]){0.2, 0.1, 0.05}, (double[]){0.3, 0.3, -1});
    camera_perspective(&e.view, 0.5, 1e-3, 20);
    /* At the view's margin (u, v) changes by several radii a pixel, and depth with it. */
    extreme_check(
        *state, "a view of 179.3 degrees", &e,
        (extreme_bounds){
            .uv = 5e-4, .thin_uv = 5e-4, .depth = 5e-6, .ties = {2e-4, 2e-6, 0.1}, .least = 40000});
    e = culled_sphere(300);
    camera_look(&e.view, (double[]){0, 0, 25000}, (double[]){0, 0, 0});
    camera_perspective(&e.view, 1e6, 20000, 30000);
    /* Depth is known to 2^-23 of the distance, which is 15 % of epsilon. */
    extreme_check(*state, "a view of 0.01 degrees", &e,
                  (extreme_bounds){.thin_uv = 5e-4, .ties = {2e-4, 5e-7, 0.3}, .least = 10000});
}

/* ---- images --------------------------------------------------------------------------------- */

/* A pixel's position is known to 2^-24 of the image's length, which in pixels is a hundred times
 * more than in an image of 160 pixels. */
static void test_long_images(void **state) {
    for (int axis = 0; axis < 2; ++axis) {
        extreme e = culled_sphere(300);
        agreement_ties ties = usual;
        e.view.width = axis ? 2 : 16384;
        e.view.height = axis ? 16384 : 2;
        ties.edge = 0.005;
        camera_perspective(&e.view, 30000, 1, 10);
        extreme_check(*state, axis ? "2 x 16384 pixels" : "16384 x 2 pixels", &e,
                      (extreme_bounds){.thin_uv = 5e-5, .ties = ties, .least = 80000});
    }
}

/* ---- splats in a pixel ---------------------------------------------------------------------- */

/* With the filter every splat is widened to a pixel. A tie is less than a hundredth of a radius. */
static void test_below_a_pixel(void **state) {
    const double focals[] = {1, 0.1};
    for (int k = 0; k < 4; ++k) {
        char name[64];
        extreme e = culled_sphere(1000);
        e.view.width = e.view.height = 15; /* the model lies in the middle of a pixel */
        e.view.no_filter = k / 2;
        camera_perspective(&e.view, 5 * focals[k % 2], 1, 10);
        snprintf(name, sizeof name, "splats of %g pixels, %s", 0.1 * focals[k % 2],
                 k / 2 ? "no filter" : "filter");
        agreement_ties ties = {k % 2 ? 1e-6 : 2e-4, 0, 0};
        extreme_check(*state, name, &e,
                      (extreme_bounds){.thin_uv = 5e-4, .ties = ties, .least = 4});
    }
}

/* Every pixel has ten thousand splats: every sum has ten thousand roundings of 2^-24 each, which
 * are 6e-4 at worst, all in one direction, and the root of their number times less at random. */
static void test_overdraw(void **state) {
    enum { COUNT = 10000 };
    for (int filter = 0; filter < 2; ++filter) {
        scene s = scene_blank(COUNT);
        uint32_t random = 7;
        s.has_color = 1;
        s.depth_tolerance = 1;
        for (int i = 0; i < COUNT; ++i) {
            for (int k = 0; k < 3; ++k) s.splats[i].center[k] = 0.5f * scene_random(&random);
            for (int k = 0; k < 3; ++k) s.splats[i].color[k] = scene_random(&random);
            for (int k = 0; k < 2; ++k) s.splats[i].radius[k] = 3;
        }
        extreme e = extreme_of(s);
        e.view.width = e.view.height = 9;
        e.view.no_filter = !filter;
        camera_perspective(&e.view, filter ? 0.5 : 30, 1, 10);
        extreme_check(*state, filter ? "overdraw 1e4, filtered" : "overdraw 1e4", &e,
                      (extreme_bounds){.depth = 2e-5,
                                       .color = 6e-4,
                                       .thin_uv = 5e-4,
                                       .ties = {2e-4, 1e-7, 0},
                                       .least = 4});
    }
}

int test_extremes_size_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_units),         cmocka_unit_test(test_far_from_origin),
        cmocka_unit_test(test_eye_in_model),  cmocka_unit_test(test_parallel),
        cmocka_unit_test(test_focal_lengths), cmocka_unit_test(test_long_images),
        cmocka_unit_test(test_below_a_pixel), cmocka_unit_test(test_overdraw),
    };
    return cmocka_run_group_tests(tests, gpu_setup_gl, gpu_teardown);
}
