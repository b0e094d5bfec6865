/* SPDX-License-Identifier: MIT
 *
 * test_renderer.c - tests drawings whose result is known in closed form, on GL and on GLES. The
 * views are parallel, 128 pixels over 2 units, so that a pixel is 1/64 unit and (u, v) of a unit
 * disc follow from it.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "near.h"
#include "scene_asset.h"

/* The eye is at z = 2 and looks down; the window depth of height h is (2 - h - 1) / 2. */
static psplat_view top_view(void) {
    const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.0, 1.0, 3.0);
    return view;
}

static double coordinate(int pixel) {
    return (pixel + 0.5) / 64.0 - 1.0;
}

static void draw_scene(canvas *c, const psplat_view *view, const scene *s,
                       const double transform[16]) {
    psplat_asset *asset = scene_open(s);
    psplat_item item = {.model = canvas_model(c, asset)};
    if (transform) memcpy(item.transform, transform, sizeof item.transform);
    canvas_draw(c, view, &item, 1);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
}

/* Every pixel whose centre is inside the ellipse and the line is covered, and no other one is.
 * Pixels within 1e-5 of the edge may be either, because float32 keeps (u, v) to about 1e-6. */
static void check_ellipse(const canvas *c, double ru, double rv, const double line[3]) {
    for (int y = 0; y < CANVAS_SIZE; ++y)
        for (int x = 0; x < CANVAS_SIZE; ++x) {
            double u = coordinate(x) / ru, v = coordinate(y) / rv;
            double inside = 1.0 - (u * u + v * v);
            double kept = line[0] * u + line[1] * v + line[2];
            double margin = fmin(inside, kept);
            if (fabs(margin) < 1e-5) continue;
            assert_int_equal(canvas_pixel(c, x, y)[3] > 0.0f, margin > 0.0);
        }
}

static const double no_line[3] = {0, 0, 1};

static void test_disc(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    psplat_view view = top_view();
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        view.mode = (psplat_mode)mode;
        draw_scene(c, &view, &s, NULL);
        check_ellipse(c, 0.8, 0.8, no_line);
        /* The disc lies in the middle of the depth range; the tolerance is two steps of 2^-24. */
        assert_near(c->depth[64 * CANVAS_SIZE + 64], 0.5, 1.2e-7);
        assert_near(c->depth[0], 1.0, 0.0);
    }
    scene_free(&s);
}

static void test_parameters(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    psplat_view view = top_view();
    view.mode = PSPLAT_MODE_PARAMETERS;
    draw_scene(c, &view, &s, NULL);
    for (int y = 30; y < 98; y += 3)
        for (int x = 30; x < 98; x += 3) {
            const float *p = canvas_pixel(c, x, y);
            /* The bound for (u, v) is 5e-5 in general; here nothing is far away. */
            assert_near(p[0], coordinate(x) / 0.8, 1e-6);
            assert_near(p[1], coordinate(y) / 0.8, 1e-6);
            assert_near(p[2], 0.0, 0.0);
        }
    scene_free(&s);
}

static void test_clip_line(void **state) {
    canvas *c = *state;
    const double line[3] = {0.6, 0.8, 0.3};
    scene s = scene_disc(0.8f);
    s.splats[0].clip_count = 1;
    for (int i = 0; i < 3; ++i) s.splats[0].clip[0][i] = (float)line[i];
    psplat_view view = top_view();
    draw_scene(c, &view, &s, NULL);
    check_ellipse(c, 0.8, 0.8, line);
    scene_free(&s);
}

/* Edge-on a disc covers no pixel centre. Tilted by 60 degrees it is an ellipse of half the height:
 * its far side lies below its near one, which does not matter in parallel views. */
static void test_edge_on(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    s.material.double_sided = 1;
    psplat_view view = top_view();
    const double up[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};
    draw_scene(c, &view, &s, up);
    assert_int_equal(canvas_covered(c), 0);
    double h = 0.5, w = sqrt(0.75);
    const double tilt[16] = {1, 0, 0, 0, 0, h, w, 0, 0, -w, h, 0, 0, 0, 0, 1};
    draw_scene(c, &view, &s, tilt);
    check_ellipse(c, 0.8, 0.4, no_line);
    scene_free(&s);
}

/* Two discs lie in one plane, a red and a green one. Where both cover, the colour is their weighted
 * mean (spec 5.4), which unlit materials show unchanged. */
static void test_overlap(void **state) {
    canvas *c = *state;
    scene s = scene_blank(2);
    for (int i = 0; i < 2; ++i) {
        s.splats[i].radius[0] = s.splats[i].radius[1] = 0.5f;
        s.splats[i].center[0] = i ? 0.25f : -0.25f;
        s.splats[i].color[0] = i ? 0.0f : 1.0f;
        s.splats[i].color[1] = i ? 1.0f : 0.0f;
    }
    s.has_color = 1;
    s.material.unlit = 1;
    psplat_view view = top_view();
    draw_scene(c, &view, &s, NULL);
    for (int x = 50; x < 78; ++x) {
        double a = (coordinate(x) + 0.25) / 0.5, b = (coordinate(x) - 0.25) / 0.5;
        double v = coordinate(64) / 0.5;
        double wa = exp(-2 * (a * a + v * v)), wb = exp(-2 * (b * b + v * v));
        const float *p = canvas_pixel(c, x, 64);
        /* The exp of llvmpipe is accurate to about 1e-6. */
        if (a * a + v * v > 1 || b * b + v * v > 1) continue;
        assert_near(p[0], wa / (wa + wb), 1e-5);
        assert_near(p[1], wb / (wa + wb), 1e-5);
    }
    scene_free(&s);
}

static void test_culling(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    psplat_view view = top_view();
    const double over[16] = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
    draw_scene(c, &view, &s, over);
    assert_int_equal(canvas_covered(c), 0);
    view.culling = PSPLAT_CULL_NEVER;
    draw_scene(c, &view, &s, over);
    check_ellipse(c, 0.8, 0.8, no_line);
    float behind = canvas_pixel(c, 64, 64)[0];
    draw_scene(c, &view, &s, NULL);
    /* Seen from behind the normal is negated, so that the light from the eye shines on it
     * nevertheless. */
    assert_near(behind, canvas_pixel(c, 64, 64)[0], 1e-6);
    assert_true(behind > 0.5f);
    s.material.double_sided = 1;
    view.culling = PSPLAT_CULL_BY_MATERIAL;
    draw_scene(c, &view, &s, over);
    check_ellipse(c, 0.8, 0.8, no_line);
    view.culling = PSPLAT_CULL_ALWAYS;
    draw_scene(c, &view, &s, over);
    assert_int_equal(canvas_covered(c), 0);
    scene_free(&s);
}

/* A mirror plane that contains the view direction keeps the front in front; one across it turns the
 * front away (spec 4, 5.2). */
static void test_mirrored(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    s.splats[0].radius[1] = 0.4f;
    psplat_view view = top_view();
    const double across[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const double along[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
    draw_scene(c, &view, &s, across);
    check_ellipse(c, 0.8, 0.4, no_line);
    assert_true(canvas_pixel(c, 64, 64)[0] > 0.5f);
    draw_scene(c, &view, &s, along);
    assert_int_equal(canvas_covered(c), 0);
    scene_free(&s);
}

static void test_singular(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    psplat_view view = top_view();
    const double flat[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
    draw_scene(c, &view, &s, flat);
    assert_int_equal(canvas_covered(c), 0);
    scene_free(&s);
}

/* Items share the depth buffer: what a second call draws is hidden behind the first and is cut by
 * it. */
static void test_occlusion(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.5f);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = top_view();
    psplat_error error = {0};
    canvas_begin(c);
    canvas_check(psplat_draw(c->renderer, &view, &item, 1, &error), &error);
    /* The second disc is tilted by 45 degrees about y: its half with x > 0 rises above the first
     * disc. */
    double r = sqrt(0.5);
    const double tilt[16] = {r, 0, r, 0, 0, 1, 0, 0, -r, 0, r, 0, 0, 0, 0, 1};
    memcpy(item.transform, tilt, sizeof tilt);
    view.mode = PSPLAT_MODE_PARAMETERS;
    canvas_check(psplat_draw(c->renderer, &view, &item, 1, &error), &error);
    canvas_read(c);
    /* Window depth is 0.5 in the first disc and less by half the height where the second is in
     * front. */
    assert_near(c->depth[64 * CANVAS_SIZE + 48], 0.5, 1.2e-7);
    assert_near(c->depth[64 * CANVAS_SIZE + 80], 0.5 - coordinate(80) / 2, 2e-7);
    assert_near(canvas_pixel(c, 80, 64)[0], coordinate(80) / r / 0.5, 1e-5);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* With an epsilon of 0.01 a disc 0.005 below blends, and one 0.02 below does not (spec 5.3). */
static void test_tolerance(void **state) {
    canvas *c = *state;
    psplat_view view = top_view();
    for (int hidden = 0; hidden < 2; ++hidden) {
        scene s = scene_blank(2);
        s.splats[1].center[2] = hidden ? -0.02f : -0.005f;
        s.splats[1].color[1] = s.splats[1].color[2] = 0.0f;
        s.has_color = 1;
        s.material.unlit = 1;
        s.depth_tolerance = 0.01f;
        draw_scene(c, &view, &s, NULL);
        /* Both have weight 1 at the centre, so that green is 1 or the mean of 1 and 0. */
        assert_near(canvas_pixel(c, 64, 64)[1], hidden ? 1.0 : 0.5, 1e-6);
        scene_free(&s);
    }
}

/* Two models of one frame emit 0.25 red and 0.5 green. Each keeps its own material, and where they
 * lie in one plane they mix by weight. */
static void test_materials(void **state) {
    canvas *c = *state;
    psplat_view view = top_view();
    view.light_count = 0;
    psplat_item items[2] = {{0}};
    psplat_asset *assets[2];
    for (int i = 0; i < 2; ++i) {
        scene s = scene_disc(0.5f);
        s.splats[0].center[0] = i ? 0.25f : -0.25f;
        s.material.emissive[i] = i ? 0.5f : 0.25f;
        assets[i] = scene_open(&s);
        items[i].model = canvas_model(c, assets[i]);
        scene_free(&s);
    }
    canvas_draw(c, &view, items, 2);
    assert_near(canvas_pixel(c, 30, 64)[0], 0.25, 1e-6);
    assert_near(canvas_pixel(c, 30, 64)[1], 0.0, 0.0);
    assert_near(canvas_pixel(c, 98, 64)[0], 0.0, 0.0);
    assert_near(canvas_pixel(c, 98, 64)[1], 0.5, 1e-6);
    double a = (coordinate(64) + 0.25) / 0.5, b = (coordinate(64) - 0.25) / 0.5;
    double share = 1 / (1 + exp(-2 * (b * b - a * a)));
    assert_near(canvas_pixel(c, 64, 64)[0], 0.25 * share, 1e-5);
    assert_near(canvas_pixel(c, 64, 64)[1], 0.5 * (1 - share), 1e-5);
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(c->renderer, items[i].model);
        psplat_asset_destroy(assets[i]);
    }
}

/* Mode phong varies light over one splat, gaussian does not; flat has no blending and equals
 * gaussian for a single splat. */
static void test_modes(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    s.splats[0].gradient[0] = s.splats[0].gradient[1] = 0.8f;
    psplat_view view = top_view();
    float edge[3], center[3];
    for (int mode = 0; mode < 3; ++mode) {
        view.mode = (psplat_mode)mode;
        draw_scene(c, &view, &s, NULL);
        edge[mode] = canvas_pixel(c, 95, 64)[0];
        center[mode] = canvas_pixel(c, 64, 64)[0];
    }
    assert_near(center[PSPLAT_MODE_PHONG], center[PSPLAT_MODE_GAUSSIAN], 1e-3);
    assert_true(edge[PSPLAT_MODE_PHONG] < 0.95f * edge[PSPLAT_MODE_GAUSSIAN]);
    assert_near(edge[PSPLAT_MODE_GAUSSIAN], edge[PSPLAT_MODE_FLAT], 1e-6);
    assert_near(edge[PSPLAT_MODE_GAUSSIAN], center[PSPLAT_MODE_GAUSSIAN], 1e-6);
    scene_free(&s);
}

/* Draws the variants that scenes need: every number of clip lines with and without gamma and
 * colour, kernel power, near plane and materials, in an array of four runs that holds each pair of
 * them. All must compile and give finite numbers. */
static void draw_variant(canvas *c, int color, int power, int near, int materials) {
    const double eye[3] = {near ? 0.1 : 2, near ? 0.2 : 2, near ? 0.3 : 2}, target[3] = {0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    psplat_item items[2] = {{0}};
    psplat_asset *assets[2];
    camera_look(&view, eye, target);
    camera_perspective(&view, 100, 0.1, 10);
    for (int i = 0; i < 2; ++i) {
        scene s = scene_ellipses(50, PSPLAT_MAX_CLIP_LINES, 5);
        s.has_color = color;
        for (size_t k = 0; i && k < s.count; ++k) s.splats[k].gradient[2] = 0;
        s.kernel.exponent = power ? 3.0f : 2.0f;
        s.material.double_sided = 1;
        if (materials) s.material.metallic = (float)i;
        assets[i] = scene_open(&s);
        items[i].model = canvas_model(c, assets[i]);
        scene_free(&s);
    }
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        view.mode = (psplat_mode)mode;
        canvas_draw(c, &view, items, 2);
        assert_true(canvas_covered(c) > 100);
        for (int i = 0; i < 4 * CANVAS_SIZE * CANVAS_SIZE; ++i) assert_true(isfinite(c->color[i]));
    }
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(c->renderer, items[i].model);
        psplat_asset_destroy(assets[i]);
    }
}

static void test_variants(void **state) {
    draw_variant(*state, 0, 0, 0, 0);
    draw_variant(*state, 1, 1, 1, 0);
    draw_variant(*state, 0, 1, 0, 1);
    draw_variant(*state, 1, 0, 1, 1);
}

/* A plane is far larger than the view and the eye 0.1 above it: everything below the horizon is
 * covered, although two corners of the triangle lie behind the eye. */
static void test_huge(void **state) {
    canvas *c = *state;
    scene s = scene_disc(1e4f);
    s.depth_tolerance = 0.01f;
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    const double eye[3] = {0, 0, 0.1}, target[3] = {0, 1, 0.1};
    camera_look(&view, eye, target);
    camera_perspective(&view, 64, 0.01, 1e5);
    draw_scene(c, &view, &s, NULL);
    /* camera_look puts +z up: rows below the middle see the plane, the others the sky. */
    for (int y = 0; y < 62; ++y) assert_true(canvas_pixel(c, 64, y)[3] > 0.0f);
    for (int y = 66; y < CANVAS_SIZE; ++y) assert_true(canvas_pixel(c, 64, y)[3] == 0.0f);
    scene_free(&s);
}

/* What lies in front of the near plane hides nothing, not even within epsilon of it. */
static void test_near_plane(void **state) {
    canvas *c = *state;
    scene s = scene_blank(2);
    s.splats[0].center[2] = 1.005f; /* the near plane of the top view is at z = 1 */
    s.splats[1].center[2] = 0.5f;
    s.depth_tolerance = 0.01f;
    psplat_view view = top_view();
    draw_scene(c, &view, &s, NULL);
    assert_near(c->depth[64 * CANVAS_SIZE + 64], 0.25, 1.2e-7);
    scene_free(&s);
}

static void test_one_pixel(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    psplat_view view = top_view();
    view.width = view.height = 1;
    view.x = 5;
    view.y = 7;
    draw_scene(c, &view, &s, NULL);
    assert_int_equal(canvas_covered(c), 1);
    assert_true(canvas_pixel(c, 5, 7)[3] > 0.0f);
    scene_free(&s);
}

static void test_nothing(void **state) {
    canvas *c = *state;
    psplat_view view = top_view();
    canvas_draw(c, &view, NULL, 0);
    assert_int_equal(canvas_covered(c), 0);
}

static void expect_argument(canvas *c, psplat_view view, const psplat_item *items, size_t count) {
    psplat_error error = {0};
    assert_int_equal(psplat_draw(c->renderer, &view, items, count, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(error.code, PSPLAT_ERROR_ARGUMENT);
    assert_true(error.text[0] != '\0');
}

static void expect_bad_lights(canvas *c, const psplat_item *item) {
    psplat_view view = top_view();
    view.light_count = PSPLAT_MAX_LIGHTS + 1;
    expect_argument(c, view, item, 1);
    view.light_count = -1;
    expect_argument(c, view, item, 1);
    view.light_count = 1;
    view.lights[0].type = (psplat_light_type)(PSPLAT_LIGHT_SPOT + 1);
    expect_argument(c, view, item, 1);
    view = top_view();
    view.lights[0].color[1] = -1;
    expect_argument(c, view, item, 1);
    view.lights[0].color[1] = NAN;
    expect_argument(c, view, item, 1);
    view = top_view();
    view.lights[0].type = PSPLAT_LIGHT_SPOT;
    view.lights[0].inner_angle = 0.5f;
    view.lights[0].outer_angle = 0.5f;
    expect_argument(c, view, item, 1);
    view.lights[0].outer_angle = 2;
    expect_argument(c, view, item, 1);
}

static void test_bad_arguments(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)}, empty = {0};
    psplat_view view = top_view();
    expect_argument(c, view, NULL, 1);
    expect_argument(c, view, &empty, 1);
    view.width = 0;
    expect_argument(c, view, &item, 1);
    view = top_view();
    view.height = 1 << 20;
    expect_argument(c, view, &item, 1);
    view = top_view();
    view.mode = PSPLAT_MODE_COUNT;
    expect_argument(c, view, &item, 1);
    view = top_view();
    view.projection[5] = 0.0;
    expect_argument(c, view, &item, 1);
    view = top_view();
    view.shading = PSPLAT_SHADING_COUNT;
    expect_argument(c, view, &item, 1);
    view = top_view();
    view.shadow_size = 15;
    expect_argument(c, view, &item, 1);
    expect_bad_lights(c, &item);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

int test_renderer_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_disc),       cmocka_unit_test(test_parameters),
        cmocka_unit_test(test_clip_line),  cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_overlap),    cmocka_unit_test(test_culling),
        cmocka_unit_test(test_mirrored),   cmocka_unit_test(test_singular),
        cmocka_unit_test(test_occlusion),  cmocka_unit_test(test_tolerance),
        cmocka_unit_test(test_materials),  cmocka_unit_test(test_modes),
        cmocka_unit_test(test_variants),   cmocka_unit_test(test_huge),
        cmocka_unit_test(test_near_plane), cmocka_unit_test(test_one_pixel),
        cmocka_unit_test(test_nothing),    cmocka_unit_test(test_bad_arguments),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, canvas_setup_gl, canvas_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, canvas_setup_gles, canvas_teardown);
}
