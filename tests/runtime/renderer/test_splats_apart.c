/* SPDX-License-Identifier: MIT
 *
 * test_splats_apart.c - tests that, of several splats in one plane or on one curved surface, the
 * shading `splats` shows the same one in every pixel and from every side. The splats differ in how
 * they are turned about their normal, so that their depths are rounded differently.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "scene_asset.h"

enum { SPLATS = 5, VIEWS = 24, MIDDLE = 20 /* pixels on either side of the centre */ };

/* Returns discs around one point, which overlap in a plane that is tilted to all axes, or on a
 * surface that is curved alike in all directions. */
static scene stack(int is_curved) {
    const double n[3] = {0.36, 0.48, 0.8}, a[3] = {0.8, -0.6, 0}, b[3] = {0.48, 0.64, -0.6};
    scene s = scene_blank(SPLATS);
    for (int i = 0; i < SPLATS; ++i) {
        double turn = 0.3 + 1.1 * i, u[3], v[3];
        for (int k = 0; k < 3; ++k) {
            u[k] = cos(turn) * a[k] + sin(turn) * b[k];
            v[k] = cos(turn) * b[k] - sin(turn) * a[k];
            s.splats[i].normal[k] = (float)n[k];
        }
        scene_set_axes(&s.splats[i], u, v);
        if (is_curved) s.splats[i].gradient[0] = s.splats[i].gradient[1] = 0.5f;
        if (is_curved) scene_curve_splat(&s.splats[i]);
    }
    s.depth_tolerance = 0.01f;
    s.material.double_sided = 1;
    return s;
}

static psplat_view view_from(int direction) {
    double turn = 0.5 * direction / VIEWS;
    const double eye[3] = {4 * sin(turn), 2.1 + 0.3 * turn, 4 * cos(turn)}, target[3] = {0, 0, 0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_perspective(&view, 2 * CANVAS_SIZE, 3, 6.5);
    view.shading = PSPLAT_SHADING_SPLATS;
    return view;
}

/* Counts pixels around the middle whose hue, which the shading keeps while it darkens colours to
 * the edge, is not that of the first one. */
static int count_others(const canvas *c, float hue[3]) {
    int others = 0;
    for (int y = -MIDDLE; y < MIDDLE; ++y)
        for (int x = -MIDDLE; x < MIDDLE; ++x) {
            const float *p = canvas_pixel(c, CANVAS_SIZE / 2 + x, CANVAS_SIZE / 2 + y);
            float most = fmaxf(fmaxf(p[0], p[1]), p[2]), off = 0;
            assert_true(p[3] > 0);
            if (hue[0] + hue[1] + hue[2] <= 0)
                for (int k = 0; k < 3; ++k) hue[k] = p[k] / most;
            for (int k = 0; k < 3; ++k) off = fmaxf(off, fabsf(p[k] / most - hue[k]));
            others += off > 0.01f; /* hues of neighbours are farther apart; rounding is not */
        }
    return others;
}

static void check_stack(canvas *c, int is_curved) {
    scene s = stack(is_curved);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    float hue[3] = {0, 0, 0};
    for (int direction = 0; direction < VIEWS; ++direction) {
        psplat_view view = view_from(direction);
        canvas_draw(c, &view, &item, 1);
        assert_int_equal(count_others(c, hue), 0);
    }
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

static void test_plane(void **state) {
    check_stack(*state, 0);
}

static void test_curved(void **state) {
    check_stack(*state, 1);
}

/* The order is that of the splats' numbers, not of the planes: a splat that is nearer by a
 * thousandth of the model is seen, whatever its number. */
static void test_nearer(void **state) {
    canvas *c = *state;
    float hue[2][3] = {{0}};
    for (int first = 0; first < 2; ++first) {
        scene s = stack(0);
        for (int i = 0; i < SPLATS; ++i)
            for (int k = 0; k < 3; ++k)
                s.splats[i].center[k] = (i == (first ? 0 : 3) ? 0.001f : 0) * s.splats[i].normal[k];
        psplat_asset *asset = scene_open(&s);
        psplat_item item = {.model = canvas_model(c, asset)};
        psplat_view view = view_from(3);
        canvas_draw(c, &view, &item, 1);
        assert_int_equal(count_others(c, hue[first]), 0);
        psplat_model_destroy(c->renderer, item.model);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
    double off = 0;
    for (int k = 0; k < 3; ++k) off += fabs((double)hue[0][k] - (double)hue[1][k]);
    assert_true(off > 0.1);
}

int test_splats_apart_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_curved),
        cmocka_unit_test(test_nearer),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, canvas_setup_gl, canvas_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, canvas_setup_gles, canvas_teardown);
}
