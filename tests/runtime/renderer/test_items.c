/* SPDX-License-Identifier: MIT
 *
 * test_items.c - tests that many items are drawn with few calls, and as they are when each is drawn
 * by calls of its own. Items of one model share calls. Items that have a copy of the model each
 * share none, and nothing else differs: so their pictures are compared, in one context.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "scene_asset.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 5, COUNT = SIDE * SIDE };

/* A context whose loader counts draw calls. */
typedef void (*draw_instances)(unsigned mode, int first, int count, int instances);

static struct {
    draw_instances real;
    int calls, instances;
} counter;

static void count_instances(unsigned mode, int first, int count, int instances) {
    ++counter.calls;
    counter.instances += instances;
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

static int open_canvas(void **state) {
    psplat_error error = {0};
    canvas *c = canvas_create(PSPLAT_API_GL);
    psplat_renderer_destroy(c->renderer);
    psplat_renderer_desc desc = {
        .get_proc = counting_get_proc, .user = c->host, .images = scene_images()};
    canvas_check(psplat_renderer_create(&desc, &c->renderer, &error), &error);
    *state = c;
    return 0;
}

static int close_canvas(void **state) {
    canvas_destroy(*state);
    return 0;
}

/* ---- items ------------------------------------------------------------------------------------
 */

/* Sets a matrix that scales along the axes, turns about y and moves. */
static void set_transform(double m[16], const double scale[3], double angle, const double at[3]) {
    double c = cos(angle), s = sin(angle);
    const double turn[9] = {c, 0, -s, 0, 1, 0, s, 0, c};
    memset(m, 0, 16 * sizeof *m);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            m[4 * column + row] = scale[column] * turn[3 * column + row];
    for (int i = 0; i < 3; ++i) m[12 + i] = at[i];
    m[15] = 1;
}

/* Places items on a grid around a point so that they do not overlap: turned, stretched, some of
 * them mirrored. Those of the outer columns lie beside the view of look_at_grid. */
static void place_on_grid(psplat_item items[COUNT], const double middle[3]) {
    for (int i = 0; i < COUNT; ++i) {
        const double stretch = 0.4 + 0.05 * (i % 7);
        const double scale[3] = {i % 3 ? stretch : -stretch, 0.8, i % 4 ? 0.6 : 0.7};
        const double at[3] = {middle[0] + 2.4 * (i % SIDE - SIDE / 2),
                              middle[1] + 2.4 * (i / SIDE - SIDE / 2), middle[2] - 0.3 * (i % 2)};
        set_transform(items[i].transform, scale, 0.7 * i, at);
    }
}

static psplat_view look_at_grid(const double middle[3]) {
    const double eye[3] = {middle[0], middle[1], middle[2] + 14};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, middle);
    camera_perspective(&view, 1.6 * CANVAS_SIZE, 10, 20);
    return view;
}

/* ---- comparison -------------------------------------------------------------------------------
 */

/* The greatest differences between two pictures, and pixels that both cover. */
typedef struct difference {
    double color, depth;
    int covered;
} difference;

/* Draws items of one model and items of copies of it, and compares. */
static difference compare(canvas *c, const psplat_asset *asset, const psplat_view *view,
                          psplat_item *items, size_t count) {
    static canvas together;
    psplat_model *one = canvas_model(c, asset);
    difference d = {0};
    for (size_t i = 0; i < count; ++i) items[i].model = one;
    canvas_draw(c, view, items, count);
    together = *c;
    for (size_t i = 0; i < count; ++i) items[i].model = canvas_model(c, asset);
    canvas_draw(c, view, items, count);
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) {
        d.covered += c->color[4 * i + 3] > 0 && together.color[4 * i + 3] > 0;
        d.depth = fmax(d.depth, fabs((double)c->depth[i] - (double)together.depth[i]));
        for (int k = 4 * i; k < 4 * i + 4; ++k)
            d.color = fmax(d.color, fabs((double)c->color[k] - (double)together.color[k]));
    }
    for (size_t i = 0; i < count; ++i) psplat_model_destroy(c->renderer, items[i].model);
    psplat_model_destroy(c->renderer, one);
    return d;
}

static void expect_equal(canvas *c, const scene *s, const psplat_view *view, psplat_item *items,
                         size_t count, double tolerance) {
    psplat_asset *asset = scene_open(s);
    difference d = compare(c, asset, view, items, count);
    psplat_asset_destroy(asset);
    if (d.covered < 1000) fail_msg("only %d pixels are covered", d.covered);
    if (!(d.color <= tolerance && d.depth <= tolerance))
        fail_msg("mode %d, shading %d: colours differ by %g and depths by %g, allowed %g",
                 (int)view->mode, (int)view->shading, d.color, d.depth, tolerance);
}

/* Draws in every mode and with every shading. Where the nearest splat wins, nothing is added up
 * whose rounding could depend on an order. */
static void expect_equal_in_all(canvas *c, const scene *s, psplat_view view, psplat_item *items,
                                size_t count, double tolerance) {
    for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode) {
        view.mode = (psplat_mode)mode;
        int blends = mode == PSPLAT_MODE_PHONG || mode == PSPLAT_MODE_GAUSSIAN;
        expect_equal(c, s, &view, items, count, blends ? tolerance : 0);
    }
    view.mode = PSPLAT_MODE_PHONG;
    for (int shading = 1; shading < PSPLAT_SHADING_COUNT; ++shading) {
        view.shading = (psplat_shading)shading;
        expect_equal(c, s, &view, items, count, shading == PSPLAT_SHADING_SPLATS ? 0 : tolerance);
    }
}

/* ---- tests ------------------------------------------------------------------------------------
 */

static const double origin[3] = {0, 0, 0};

/* Models of at most a chunk a batch are summed in the same order: their pictures are the same. */
static void test_batches(void **state) {
    canvas *c = *state;
    psplat_item items[COUNT] = {{.model = NULL}};
    place_on_grid(items, origin);
    scene s = scene_ellipses(200, 4, 7);
    for (size_t i = 0; i < s.count; ++i)
        for (int k = 0; k < 3; ++k) s.splats[i].center[k] -= 0.5f;
    s.has_color = 1;
    expect_equal_in_all(c, &s, look_at_grid(origin), items, COUNT, 0);
    s.material.double_sided = 1;
    psplat_view view = look_at_grid(origin);
    view.lights[0].casts_shadow = 1;
    view.lights[0].direction[0] = 0.4f;
    expect_equal(c, &s, &view, items, COUNT, 0);
    scene_add_textures(&s);
    expect_equal(c, &s, &view, items, COUNT, 0);
    scene_free(&s);
}

/* Culling leaves each item chunks of its own. Sums over more chunks than one have another order,
 * and with it other roundings: of some ten summands, 2^-24 of each. */
static void test_chunks(void **state) {
    canvas *c = *state;
    const double tolerance = 1e-5;
    psplat_item items[COUNT] = {{.model = NULL}};
    place_on_grid(items, origin);
    scene s = scene_sphere(3300, 1);
    expect_equal_in_all(c, &s, look_at_grid(origin), items, COUNT, tolerance);
    scene_curve(&s);
    s.depth_tolerance = 1e-4f;
    expect_equal_in_all(c, &s, look_at_grid(origin), items, COUNT, tolerance);
    scene_free(&s);
}

/* Of these items of one model some are drawn as curved, the farther ones as ellipses; one is
 * crossed by the near plane, some lie behind the eye. */
static void test_distances(void **state) {
    canvas *c = *state;
    psplat_item items[COUNT] = {{.model = NULL}};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0, 0, 0}, (double[]){0, 0, -1});
    camera_perspective(&view, 0.6 * CANVAS_SIZE, 1, 4000);
    for (int i = 0; i < COUNT; ++i) {
        double away = pow(1.5, i) - 8, scale[3] = {1, i % 2 ? 1 : -1, 1};
        const double at[3] = {0.8 * away * cos(2.0 * i), 0.8 * away * sin(2.0 * i), -away};
        set_transform(items[i].transform, scale, 0.3 * i, at);
    }
    set_transform(items[0].transform, (double[]){1, 1, 1}, 0, (double[]){1, 0, -1.2});
    scene s = scene_sphere(150, 1);
    scene_curve(&s);
    s.depth_tolerance = 1e-3f;
    expect_equal_in_all(c, &s, view, items, COUNT, 0);
    scene_free(&s);
}

/* A million units from the origin nothing changes but the last bits of matrices. */
static void test_far_away(void **state) {
    static canvas here;
    canvas *c = *state;
    const double middle[3] = {1e6, -1e6, 1e6};
    psplat_item items[COUNT] = {{.model = NULL}};
    scene s = scene_sphere(200, 1);
    psplat_asset *asset = scene_open(&s);
    psplat_model *model = canvas_model(c, asset);
    for (int is_far = 0; is_far < 2; ++is_far) {
        psplat_view view = look_at_grid(is_far ? middle : origin);
        place_on_grid(items, is_far ? middle : origin);
        for (int i = 0; i < COUNT; ++i) items[i].model = model;
        canvas_draw(c, &view, items, COUNT);
        if (!is_far) here = *c;
    }
    int covered = 0, differ = 0;
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) {
        double most = 0;
        for (int k = 4 * i; k < 4 * i + 4; ++k)
            most = fmax(most, fabs((double)c->color[k] - (double)here.color[k]));
        covered += here.color[4 * i + 3] > 0;
        differ += most > 1e-3;
    }
    assert_true(covered > 1000);
    assert_true(differ <= covered / 500); /* pixels that edges of splats pass through */
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* Where the nearest splat wins, the first item wins of those in the same place, whichever batches
 * the items have in common. */
static void test_ties(void **state) {
    canvas *c = *state;
    scene a = scene_ellipses(60, 4, 3), b = scene_ellipses(90, 4, 3);
    psplat_asset *assets[2] = {scene_open(&a), scene_open(&b)};
    psplat_model *models[2] = {canvas_model(c, assets[0]), canvas_model(c, assets[1])};
    /* The splats of a are among those of b. */
    psplat_item items[4] = {
        {.model = models[1]}, {.model = models[0]}, {.model = models[1]}, {.model = models[0]}};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0.5, 0.5, 4}, (double[]){0.5, 0.5, 0.5});
    camera_perspective(&view, 2 * CANVAS_SIZE, 1, 10);
    view.mode = PSPLAT_MODE_PARAMETERS;
    canvas_draw(c, &view, items, 4);
    int covered = 0;
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) {
        covered += c->color[4 * i + 3] > 0;
        assert_true(c->color[4 * i + 2] < (float)b.count);
    }
    assert_true(covered > 1000);
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(c->renderer, models[i]);
        psplat_asset_destroy(assets[i]);
    }
    scene_free(&a);
    scene_free(&b);
}

/* Draws a sphere of this size with this shading. */
static void draw_sphere(canvas *c, psplat_model *model, double size, int shading) {
    psplat_view view = look_at_grid(origin);
    psplat_item item = {.model = model};
    view.shading = (psplat_shading)shading;
    set_transform(item.transform, (double[]){size, size, size}, 0, (double[]){0.71, 0.3, 0});
    canvas_draw(c, &view, &item, 1);
}

/* A frame leaves nothing of the one before it, however small a part of the view it covers and
 * however far a shading looks. */
static void test_traces(void **state) {
    (void)state;
    static canvas first;
    scene s = scene_sphere(200, 1);
    psplat_asset *asset = scene_open(&s);
    for (int shading = 0; shading < PSPLAT_SHADING_COUNT; ++shading) {
        const double small = 0.02 + 0.1 * shading, large = 3;
        canvas *c = canvas_create(PSPLAT_API_GL); /* whose targets hold nothing yet */
        psplat_model *model = canvas_model(c, asset);
        draw_sphere(c, model, small, shading);
        assert_true(canvas_covered(c) > 0);
        first = *c;
        draw_sphere(c, model, large, PSPLAT_SHADING_LIT);
        draw_sphere(c, model, small, shading);
        assert_memory_equal(first.color, c->color, sizeof first.color);
        assert_memory_equal(first.depth, c->depth, sizeof first.depth);
        psplat_model_destroy(c->renderer, model);
        canvas_destroy(c);
    }
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* Two passes draw a model's batches once each, whatever the number of items; mirrored items have
 * other front faces and take calls of their own. */
static void test_calls(void **state) {
    canvas *c = *state;
    psplat_item items[COUNT] = {{.model = NULL}};
    psplat_view view = look_at_grid(origin);
    scene s = scene_ellipses(200, 4, 7);
    psplat_asset *asset = scene_open(&s);
    psplat_model *model = canvas_model(c, asset);
    size_t batches = psplat_asset_batch_count(asset);
    assert_true(batches > 1);
    for (int i = 0; i < COUNT; ++i) {
        items[i].model = model;
        set_transform(items[i].transform, (double[]){0.1, 0.1, 0.1}, 0, (double[]){0.1 * i, 0, 0});
    }
    counter.calls = counter.instances = 0;
    canvas_draw(c, &view, items, COUNT);
    assert_int_equal(counter.calls, 2 * batches);
    assert_int_equal(counter.instances, 2 * batches * COUNT);
    for (int i = 1; i < COUNT; i += 2) items[i].transform[0] *= -1;
    counter.calls = 0;
    canvas_draw(c, &view, items, COUNT);
    assert_int_equal(counter.calls, 2 * 2 * batches);
    for (int i = 0; i < COUNT; ++i) items[i].transform[14] = i ? 100 : 0; /* behind the eye */
    counter.calls = counter.instances = 0;
    canvas_draw(c, &view, items, COUNT);
    assert_int_equal(counter.instances, 2 * batches);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

int test_items_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_batches),   cmocka_unit_test(test_chunks),
        cmocka_unit_test(test_distances), cmocka_unit_test(test_far_away),
        cmocka_unit_test(test_ties),      cmocka_unit_test(test_calls),
        cmocka_unit_test(test_traces),
    };
    return cmocka_run_group_tests(tests, open_canvas, close_canvas);
}
