/* SPDX-License-Identifier: MIT
 *
 * test_parts.c - tests that curved splats which no clip line cuts are drawn by a program without
 * lines where splats are large, and that pictures do not tell: lines that cut nothing but are not
 * (1, 0, 1) make the same splats go through the program with lines.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "gl_canvas.h"
#include "reference_view.h"
#include "scene_asset.h"

#include <string.h>

/* A context whose loader counts draw calls. */
typedef void (*draw_instances)(unsigned mode, int first, int count, int instances);

static struct {
    draw_instances real;
    int calls;
} counter;

static void count_instances(unsigned mode, int first, int count, int instances) {
    ++counter.calls;
    counter.real(mode, first, count, instances);
}

static void *counting_get_proc(void *user, const char *name) {
    void *address = psplat_host_get_proc(user, name);
    if (strcmp(name, "glDrawArraysInstanced") != 0) return address;
    draw_instances mine = count_instances;
    memcpy(&counter.real, &address, sizeof address);
    memcpy(&address, &mine, sizeof address);
    return address;
}

static canvas *open_counting(psplat_api api) {
    psplat_error error = {0};
    canvas *c = canvas_create(api);
    psplat_renderer_destroy(c->renderer);
    psplat_renderer_desc desc = {.get_proc = counting_get_proc, .user = c->host};
    canvas_check(psplat_renderer_create(&desc, &c->renderer, &error), &error);
    return c;
}

/* Returns a sphere of twelve splats with two lines each. One in `every` is cut by its second one,
 * where is_bent is 1 by nothing but its bend; the other lines cut nothing. */
static scene sphere(size_t every, int is_bent, float beyond) {
    scene s = scene_sphere(12, 1);
    for (size_t i = 0; i < s.count; ++i) {
        psplat_splat *splat = &s.splats[i];
        int is_cut = every && i % every == 0;
        splat->clip_count = 2;
        for (int k = 0; k < 2; ++k) {
            splat->clip[k][0] = 1;
            splat->clip[k][2] = 1 + beyond;
        }
        if (is_cut) splat->clip[1][2] = is_bent ? 1 : 0.25f;
        if (is_cut && is_bent) splat->bend[1] = -1.5f;
    }
    scene_curve(&s);
    return s;
}

static psplat_view view_of(int is_parallel) {
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0.6, 0.4, 3}, (double[]){0, 0, 0});
    if (is_parallel)
        camera_parallel(&view, 1.1, 1, 10);
    else
        camera_perspective(&view, 1.2 * CANVAS_SIZE, 1, 10);
    return view;
}

/* Draws a scene and returns the number of calls. */
static int draw(canvas *c, const scene *s, const psplat_view *view) {
    psplat_asset *asset = scene_open(s);
    psplat_item item = {.model = canvas_model(c, asset)};
    counter.calls = 0;
    canvas_draw(c, view, &item, 1);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    return counter.calls;
}

/* Both draw two passes; with parts each pass draws both of them, but not where all splats are
 * uncut. Sums of some ten numbers in another order differ by less than 1e-5. */
static void expect_same(canvas *c, size_t every, int is_bent, const psplat_view *view) {
    static canvas parts;
    scene with = sphere(every, is_bent, 0), without = sphere(every, is_bent, 1e-3f);
    int passes = view->mode == PSPLAT_MODE_FLAT || view->depth_only ? 1 : 2;
    int has_parts = view->mode != PSPLAT_MODE_FLAT || view->depth_only;
    assert_int_equal(draw(c, &with, view), passes * (has_parts && every ? 2 : 1));
    parts = *c;
    assert_int_equal(draw(c, &without, view), passes);
    assert_true(view->depth_only || canvas_covered(c) > CANVAS_SIZE * CANVAS_SIZE / 4);
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) {
        assert_float_equal(parts.depth[i], c->depth[i], 1e-6f);
        for (int k = 4 * i; k < 4 * i + 4; ++k)
            assert_float_equal(parts.color[k], c->color[k], 1e-5f);
    }
    scene_free(&with);
    scene_free(&without);
}

static void test_parts(void **state) {
    canvas *c = *state;
    for (int kind = 0; kind < 8; ++kind) {
        psplat_view view = view_of(kind & 1);
        expect_same(c, 3, kind >> 1 & 1, &view);
        view.culling = PSPLAT_CULL_NEVER;
        expect_same(c, kind >> 2 & 1 ? 0 : 2, kind >> 1 & 1, &view);
    }
    for (int mode = 0; mode < 3; ++mode) {
        psplat_view view = view_of(0);
        view.mode = (psplat_mode)mode;
        expect_same(c, 4, 1, &view);
        view.depth_only = 1;
        expect_same(c, 4, 1, &view);
    }
}

/* Where few splats are uncut, and where splats are small, one program draws all. */
static void test_whole(void **state) {
    canvas *c = *state;
    psplat_view view = view_of(0);
    scene s = sphere(1, 0, 0);
    assert_int_equal(draw(c, &s, &view), 2);
    scene_free(&s);
    s = sphere(3, 0, 0);
    camera_perspective(&view, 0.1 * CANVAS_SIZE, 1, 10);
    assert_int_equal(draw(c, &s, &view), 2);
    scene_free(&s);
}

/* Seams are lines where they are weighed, and none where splats only have to be seen: where all
 * lines are seams, that pass has no parts. */
static void test_seams(void **state) {
    canvas *c = *state;
    static canvas parts;
    psplat_view view = view_of(0);
    for (uint32_t seams = 1; seams <= 2; ++seams) {
        scene with = sphere(3, 0, 0), without = sphere(3, 0, 1e-3f);
        with.seam_lines = without.seam_lines = seams;
        assert_int_equal(draw(c, &with, &view), (seams == 2 ? 1 : 2) + 2);
        parts = *c;
        assert_int_equal(draw(c, &without, &view), 2);
        assert_true(canvas_covered(c) > CANVAS_SIZE * CANVAS_SIZE / 4);
        for (int i = 0; i < 4 * CANVAS_SIZE * CANVAS_SIZE; ++i)
            assert_float_equal(parts.color[i], c->color[i], 1e-5f);
        scene_free(&with);
        scene_free(&without);
    }
}

static int open_gl(void **state) {
    *state = open_counting(PSPLAT_API_GL);
    return 0;
}

static int open_gles(void **state) {
    *state = open_counting(PSPLAT_API_GLES);
    return 0;
}

static int close_canvas(void **state) {
    canvas_destroy(*state);
    return 0;
}

int test_parts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts),
        cmocka_unit_test(test_whole),
        cmocka_unit_test(test_seams),
    };
    int failed = cmocka_run_group_tests_name("parts_gl", tests, open_gl, close_canvas);
    return failed + cmocka_run_group_tests_name("parts_gles", tests, open_gles, close_canvas);
}
