/* SPDX-License-Identifier: MIT
 *
 * test_fade.c - tests psplat_item.fade: what an item that is gone leaves behind (nothing), what a
 * faded item alone looks like (as the reference draws it whole), and how two
 * items mix, in closed form.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "agreement.h"
#include "gl_canvas.h"
#include "near.h"
#include "reference_view.h"
#include "scene_asset.h"

enum { PIXELS = CANVAS_SIZE * CANVAS_SIZE };

/* The eye is 3 above the origin, and a unit sphere fills most of the view. */
static psplat_view view_of_sphere(void) {
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0.6, 0.4, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 1.2 * CANVAS_SIZE, 1, 10);
    return view;
}

/* Two scenes as they are drawn together. */
typedef struct couple {
    psplat_asset *assets[2];
    psplat_item items[2];
} couple;

static couple couple_of(canvas *c, const scene *a, const scene *b) {
    couple made = {{scene_open(a), scene_open(b)}, {{.model = NULL}}};
    for (int i = 0; i < 2; ++i) made.items[i].model = canvas_model(c, made.assets[i]);
    return made;
}

static void couple_free(canvas *c, couple *of) {
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(c->renderer, of->items[i].model);
        psplat_asset_destroy(of->assets[i]);
    }
}

/* Returns a sphere of curved splats of one colour channel, as bright as their place tells. */
static scene tinted_sphere(size_t count, int channel) {
    scene s = scene_sphere(count, 1);
    for (size_t i = 0; i < count; ++i) {
        const float shade = 0.5f + 0.4f * s.splats[i].center[0];
        for (int k = 0; k < 3; ++k) s.splats[i].color[k] = k == channel ? shade : 0.0f;
    }
    s.has_color = 1;
    s.material.unlit = 1;
    scene_curve(&s);
    s.depth_tolerance = 1e-3f;
    return s;
}

/* ---- items that are not drawn ------------------------------------------------------------- */

static void draw_and_keep(canvas *c, const psplat_view *view, const psplat_item *items,
                          size_t count, canvas *kept) {
    canvas_draw(c, view, items, count);
    *kept = *c;
}

/* An item of fade 1 is as one that is not in the list, whatever it would have needed: other
 * targets, another depth range, another shadow map. */
static void test_gone(void **state) {
    static canvas without;
    canvas *c = *state;
    scene s = tinted_sphere(300, 0), large = scene_sphere(100, 2);
    s.material.unlit = 0;
    s.material.double_sided = 1;
    large.material.metallic = 1;
    scene_add_textures(&large);
    couple two = couple_of(c, &large, &s);
    two.items[0].fade = 1;
    psplat_view view = view_of_sphere();
    view.lights[0].casts_shadow = 1;
    view.lights[0].direction[0] = 0.8f;
    for (int mode = 0; mode < PSPLAT_MODE_COUNT - 1; ++mode) {
        view.mode = (psplat_mode)mode;
        draw_and_keep(c, &view, two.items + 1, 1, &without);
        assert_true(canvas_covered(c) > PIXELS / 4);
        canvas_draw(c, &view, two.items, 2);
        assert_memory_equal(without.color, c->color, sizeof c->color);
        assert_memory_equal(without.depth, c->depth, sizeof c->depth);
    }
    two.items[0].fade = INFINITY;
    two.items[1].fade = 1.5f;
    for (int type = PSPLAT_LIGHT_DIRECTIONAL; type <= PSPLAT_LIGHT_SPOT; ++type) {
        view.lights[0].type = (psplat_light_type)type;
        canvas_draw(c, &view, two.items, 2);
        assert_int_equal(canvas_covered(c), 0);
    }
    couple_free(c, &two);
    scene_free(&s);
    scene_free(&large);
}

static void test_refused(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.5f);
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = view_of_sphere();
    const float wrong[] = {-1e-30f, -1, NAN, -INFINITY};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        psplat_error error = {0};
        item.fade = wrong[i];
        assert_int_equal(psplat_draw(c->renderer, &view, &item, 1, &error), PSPLAT_ERROR_ARGUMENT);
        assert_true(error.text[0] != 0);
    }
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* ---- an item alone ------------------------------------------------------------------------ */

/* Weights cancel where no other item is. Weights of 1e-2
 * and sums of some ten of them keep 1e-6 of a colour. */
static void test_alone(void **state) {
    canvas *c = *state;
    const float fades[] = {0.25f, 0.99f};
    for (int is_curved = 0; is_curved < 2; ++is_curved) {
        scene s = scene_sphere(300, 1);
        if (is_curved) scene_curve(&s);
        s.depth_tolerance = 5e-3f;
        psplat_asset *asset = scene_open(&s);
        psplat_item item = {.model = canvas_model(c, asset)};
        psplat_view view = view_of_sphere();
        view.no_filter = 1;
        picture p = picture_of(&s, NULL, &view);
        for (int k = 0; k < 2; ++k) {
            item.fade = fades[k];
            canvas_draw(c, &view, &item, 1);
            size_t compared = 0;
            for (int i = 0; i < PIXELS; ++i) {
                if (p.image.tie[i] < 1e-3 || p.image.epsilon_tie[i] < 1e-2) continue;
                const float *seen = &c->color[4 * i], *wanted = &p.image.color[4 * i];
                for (int channel = 0; channel < 4; ++channel)
                    assert_near(seen[channel], wanted[channel], 5e-5);
                compared += wanted[3] > 0;
            }
            assert_true(compared > PIXELS / 4);
        }
        picture_free(&p);
        psplat_model_destroy(c->renderer, item.model);
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
}

/* Draws an item whole and faded, and expects the same pixels. */
static void expect_whole(canvas *c, const psplat_view *view, psplat_item *item) {
    static canvas whole;
    item->fade = 0;
    draw_and_keep(c, view, item, 1, &whole);
    assert_true(canvas_covered(c) > PIXELS / 4);
    item->fade = 0.75f;
    canvas_draw(c, view, item, 1);
    assert_memory_equal(whole.color, c->color, sizeof c->color);
    assert_memory_equal(whole.depth, c->depth, sizeof c->depth);
}

/* Without weights there is nothing to fade. */
static void test_no_weights(void **state) {
    canvas *c = *state;
    scene s = scene_sphere(300, 1);
    s.depth_tolerance = 0;
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = view_of_sphere();
    view.mode = PSPLAT_MODE_FLAT;
    expect_whole(c, &view, &item);
    view.mode = PSPLAT_MODE_PARAMETERS;
    expect_whole(c, &view, &item);
    view.mode = PSPLAT_MODE_PHONG;
    view.shading = PSPLAT_SHADING_SPLATS;
    expect_whole(c, &view, &item);
    view.shading = PSPLAT_SHADING_OVERDRAW;
    expect_whole(c, &view, &item);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* In a shadow map a disc at height 0 lies as much deeper as its tolerance is, 0.01 of the 2 units
 * between the planes, faded or not. */
static void test_depth_only(void **state) {
    canvas *c = *state;
    scene s = scene_disc(0.8f);
    s.depth_tolerance = 0.01f;
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = canvas_model(c, asset)};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0, 0, 2}, (double[]){0, 0, 0});
    camera_parallel(&view, 1, 1, 3);
    view.depth_only = 1;
    for (int i = 0; i < 3; ++i) {
        const double wanted[3] = {0.505, 0.505, 1};
        item.fade = 0.5f * (float)i;
        canvas_draw(c, &view, &item, 1);
        assert_near(c->depth[PIXELS / 2 + CANVAS_SIZE / 2], wanted[i], 1e-6);
    }
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* ---- two items ---------------------------------------------------------------------------- */

/* Draws a red and a green sphere of the same splats with fades t and 1 - t: red is 1 - t of what it
 * is alone, and green t. Sums of some ten numbers keep 1e-6 of a colour. */
static void expect_mixed(canvas *c, const psplat_view *view, couple *two, float t) {
    static canvas red, green;
    two->items[0].fade = two->items[1].fade = 0;
    draw_and_keep(c, view, &two->items[0], 1, &red);
    draw_and_keep(c, view, &two->items[1], 1, &green);
    two->items[0].fade = t;
    two->items[1].fade = 1 - t;
    canvas_draw(c, view, two->items, 2);
    assert_true(canvas_covered(c) > PIXELS / 4);
    for (int i = 0; i < PIXELS; ++i) {
        assert_near(c->depth[i], red.depth[i], 1e-6);
        assert_near(c->color[4 * i + 3], red.color[4 * i + 3], 0);
        assert_near(c->color[4 * i], (1 - t) * red.color[4 * i], 2e-6);
        assert_near(c->color[4 * i + 1], t * green.color[4 * i + 1], 2e-6);
    }
}

static void test_cross_fade(void **state) {
    canvas *c = *state;
    psplat_view view = view_of_sphere();
    for (int is_small = 0; is_small < 2; ++is_small) {
        /* Small splats of no curvature that shows are drawn as ellipses, with the filter. */
        scene a = tinted_sphere(is_small ? 30000 : 200, 0);
        scene b = tinted_sphere(is_small ? 30000 : 200, 1);
        a.material.metallic = 0.5f; /* so that the two differ in more than colours */
        couple two = couple_of(c, &a, &b);
        for (int mode = 0; mode < 2; ++mode) {
            view.mode = mode ? PSPLAT_MODE_GAUSSIAN : PSPLAT_MODE_PHONG;
            for (int k = 1; k < 8; k += 3) expect_mixed(c, &view, &two, 0.125f * (float)k);
        }
        couple_free(c, &two);
        scene_free(&a);
        scene_free(&b);
    }
}

/* Items of one model keep fades of their own: four discs in one place have as weights at their
 * centre what their fades leave, and the two whose fades lie between are drawn by one call. */
static void test_weights(void **state) {
    canvas *c = *state;
    scene a = scene_disc(0.8f), b = scene_disc(0.8f);
    a.material.unlit = b.material.unlit = 1;
    a.material.base_color[1] = b.material.base_color[0] = 0;
    couple two = couple_of(c, &a, &b);
    psplat_item items[4] = {two.items[0], two.items[0], two.items[1], two.items[0]};
    const float fades[4] = {0, 0.875f, 0.25f, 0.5f};
    psplat_view view = view_of_sphere();
    for (int i = 0; i < 4; ++i) items[i].fade = fades[i];
    canvas_draw(c, &view, items, 4);
    const float *pixel = canvas_pixel(c, CANVAS_SIZE / 2, CANVAS_SIZE / 2);
    double red = 0.5 + 0.125 + 1, green = 0.75;
    assert_near(pixel[0], red / (red + green), 1e-6);
    assert_near(pixel[1], green / (red + green), 1e-6);
    couple_free(c, &two);
    scene_free(&a);
    scene_free(&b);
}

/* Of two discs of tolerance 0.01 the upper one hides the lower one where it is more than that
 * below, faded or not. */
static void test_replacement(void **state) {
    canvas *c = *state;
    const double below[] = {0.005, 0.015};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0, 0, 2}, (double[]){0, 0, 0});
    camera_parallel(&view, 1, 1, 3);
    for (int i = 0; i < 2; ++i)
        for (int is_faded = 0; is_faded < 2; ++is_faded) {
            scene a = scene_disc(0.8f), b = scene_disc(0.8f);
            a.depth_tolerance = b.depth_tolerance = 0.01f;
            a.material.unlit = b.material.unlit = 1;
            b.material.base_color[0] = 0;
            b.splats[0].center[2] = (float)-below[i];
            couple two = couple_of(c, &a, &b);
            two.items[0].fade = two.items[1].fade = is_faded ? 0.5f : 0;
            canvas_draw(c, &view, two.items, 2);
            double wanted = i == 0 ? 0.5 : 1;
            assert_near(canvas_pixel(c, CANVAS_SIZE / 2, CANVAS_SIZE / 2)[0], wanted, 1e-6);
            couple_free(c, &two);
            scene_free(&a);
            scene_free(&b);
        }
}

int test_fade_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gone),       cmocka_unit_test(test_refused),
        cmocka_unit_test(test_alone),      cmocka_unit_test(test_no_weights),
        cmocka_unit_test(test_depth_only), cmocka_unit_test(test_cross_fade),
        cmocka_unit_test(test_weights),    cmocka_unit_test(test_replacement),
    };
    int failed = cmocka_run_group_tests_name("fade_gl", tests, canvas_setup_gl, canvas_teardown);
    return failed +
           cmocka_run_group_tests_name("fade_gles", tests, canvas_setup_gles, canvas_teardown);
}
