/* SPDX-License-Identifier: MIT
 *
 * test_agreement.c - tests that the renderer draws what the reference rasteriser draws, through GL
 * and through GLES, on spheres, cubes and random ellipses in ordinary and in near views.
 */
#include "agreement.h"
#include "scene_asset.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#define WIDTH 160
#define HEIGHT 120

/* What float32 and a rasteriser cannot decide: an edge nearer than 2e-4 of a radius or of a pixel,
 * and depths closer than 32 steps of a 24-bit buffer. The renderer moves the corners of a splat by
 * epsilon, each along its own ray, and interpolates: for splats of radius R at distance D that errs
 * by up to (2 R / D)^2 of epsilon, 1.5 % in ordinary views and 10 % in near ones. */
static const agreement_ties ordinary = {2e-4, 2e-6, 0.015}, close_up = {2e-4, 2e-6, 0.1};

/* The bounds of differences. UV (in radii) and DEPTH (of the depth range) are for ordinary views.
 * Where a splat is so slanted that it shows in single pixels (THIN), the position error of a pixel
 * counts, times the change of (u, v) or depth in a pixel. FLOAT and BYTE bound colours. */
#define BOUND_UV 5e-5
#define BOUND_DEPTH 1e-6
/* In near views splats of all angles blend, the slanted ones over twice epsilon (spec 5.3). Their
 * depth changes most with a pixel's position error. */
#define BOUND_CLOSE_DEPTH 2e-6
#define BOUND_CLOSE_FLOAT 2e-4 /* their weights change with it */
#define BOUND_THIN_UV 5e-4
#define BOUND_THIN_DEPTH 2e-5
#define BOUND_FLOAT 1e-4
#define BOUND_BYTE                                                                                 \
    (1.0 / 255) /* rounding is half of that; the rest is for the encoding's slope                  \
                 */

static void report(const char *name, const agreement *a) {
    print_message("%-22s covered %6zu skipped %4zu uv %.1e (thin %.1e) depth %.1e (thin %.1e) "
                  "color %.1e\n",
                  name, a->covered, a->skipped, a->uv, a->thin_uv, a->depth, a->thin_depth,
                  a->color);
}

static void assert_agrees(const char *name, const agreement *a, double depth, double color) {
    report(name, a);
    assert_true(a->covered > 1000);
    assert_true(a->skipped * 10 < a->covered); /* otherwise the test would compare too little */
    assert_int_equal(a->mismatches, 0);
    assert_int_equal(a->other, 0);
    assert_true(a->uv <= BOUND_UV);
    assert_true(a->depth <= depth);
    assert_true(a->thin_uv <= BOUND_THIN_UV);
    assert_true(a->thin_depth <= BOUND_THIN_DEPTH);
    assert_true(a->color <= color);
}

static psplat_view view_from(double x, double y, double z) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    const float light[3] = {1, 0.5f, 2}, color[3] = {2.5f, 2, 1.5f};
    camera_look(&view, (double[]){x, y, z}, (double[]){0, 0, 0});
    camera_perspective(&view, 120, 0.3, 10);
    for (int i = 0; i < 3; ++i) {
        view.lights[0].direction[i] = -light[i];
        view.lights[0].color[i] = color[i];
        view.ambient[i] = 0.1f;
    }
    return view;
}

/* Compares one picture, and the (u, v) behind it, in a float target. */
static void check_view(gpu *g, const char *name, const scene *s, const double transform[16],
                       psplat_view view, const agreement_ties *ties) {
    psplat_asset *asset = scene_open(s);
    const unsigned modes = 1u << PSPLAT_MODE_PHONG | 1u << PSPLAT_MODE_PARAMETERS;
    agreement all = agreement_measure_modes(g, asset, transform, &view, modes, 1, ties);
    psplat_asset_destroy(asset);
    int is_close = ties == &close_up;
    assert_agrees(name, &all, is_close ? BOUND_CLOSE_DEPTH : BOUND_DEPTH,
                  is_close ? BOUND_CLOSE_FLOAT : BOUND_FLOAT);
}

/* Compares the other modes, and RGBA8 with sRGB encoding. */
static void check_modes(gpu *g, const char *name, const scene *s, psplat_view view) {
    psplat_asset *asset = scene_open(s);
    const unsigned others = 1u << PSPLAT_MODE_GAUSSIAN | 1u << PSPLAT_MODE_FLAT;
    agreement modes = agreement_measure_modes(g, asset, NULL, &view, others, 1, &ordinary);
    view.linear_output = 0;
    agreement bytes =
        agreement_measure_modes(g, asset, NULL, &view, 1u << PSPLAT_MODE_PHONG, 0, &ordinary);
    psplat_asset_destroy(asset);
    assert_agrees(name, &modes, BOUND_DEPTH, BOUND_FLOAT);
    assert_agrees(" as sRGB bytes", &bytes, BOUND_DEPTH, BOUND_BYTE);
}

/* ---- scenes x views -------------------------------------------------------------------------- */

static scene tinted(scene s) {
    s.material.base_color[1] = 0.6f;
    s.material.metallic = 0.3f;
    s.material.emissive[2] = 0.05f;
    return s;
}

static void check_views(gpu *g, const char *name, const scene *s) {
    psplat_view view = view_from(1, 2, 3);
    print_message("%s\n", name);
    check_view(g, " perspective", s, NULL, view, &ordinary);
    check_modes(g, " gaussian and flat", s, view);
    camera_parallel(&view, 1.6, 1, 8);
    check_view(g, " parallel", s, NULL, view, &ordinary);
    check_view(g, " close", s, NULL, view_from(-0.9, 1.2, -1.1), &close_up);
}

static void test_sphere(void **state) {
    gpu *g = *state;
    scene s = tinted(scene_sphere(400, 1));
    check_views(g, "sphere of 400 splats", &s);
    scene_free(&s);
}

static void test_cube(void **state) {
    gpu *g = *state;
    scene s = tinted(scene_cube(0.8f));
    check_views(g, "cube of 6 splats, 4 clip lines each", &s);
    scene_free(&s);
}

static void test_ellipses(void **state) {
    gpu *g = *state;
    scene s = scene_ellipses(300, 4, 7);
    check_views(g, "300 ellipses, 0 to 4 clip lines", &s);
    s.material.double_sided = 1;
    s.material.unlit = 1;
    s.kernel = (psplat_kernel){4, 1.5f};
    s.depth_tolerance = 0.2f;
    check_view(g, " two-sided, unlit", &s, NULL, view_from(2, -1, 2), &close_up);
    s.material.unlit = s.has_color = 0;
    check_view(g, " without colours", &s, NULL, view_from(1, 2, 3), &close_up);
    scene_free(&s);
}

/* ---- transforms ------------------------------------------------------------------------------ */

static void test_transforms(void **state) {
    gpu *g = *state;
    const double stretched[16] = {1.2, 0, 0, 0, 0.3, 0.7, 0, 0, 0, 0.2, 1, 0, 0.1, 0, 0, 1};
    const double mirrored[16] = {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    scene s = tinted(scene_sphere(400, 1));
    print_message("sphere under transforms\n");
    check_view(g, " stretched, sheared", &s, stretched, view_from(2, 2, 3), &ordinary);
    check_view(g, " mirrored", &s, mirrored, view_from(2, 2, 3), &ordinary);
    scene_free(&s);
}

/* A node lies a million units away and is seen from there, so that matrices must be composed in
 * double. */
static void test_far_from_origin(void **state) {
    gpu *g = *state;
    scene s = tinted(scene_sphere(400, 1));
    const double at[3] = {1e6, -2e6, 3e6};
    for (int i = 0; i < 3; ++i) s.origin[i] = at[i];
    psplat_view view = view_from(1, 2, 3);
    camera_look(&view, (double[]){at[0] + 1, at[1] + 2, at[2] + 3}, at);
    check_view(g, "far from the origin", &s, NULL, view, &ordinary);
    scene_free(&s);
}

/* ---- the two APIs ---------------------------------------------------------------------------- */

/* The shaders of GLES are the same except for their prelude, so that a part of the tests is enough
 * there. */
int test_agreement_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sphere),          cmocka_unit_test(test_cube),
        cmocka_unit_test(test_ellipses),        cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_far_from_origin),
    };
    const struct CMUnitTest gles_tests[] = {
        cmocka_unit_test(test_ellipses),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
