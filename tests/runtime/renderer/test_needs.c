/* SPDX-License-Identifier: MIT
 *
 * test_needs.c - tests that a scene takes only what it needs: the passes, targets and vertices
 * follow from what is drawn. Expected numbers are counted from the specification of passes and
 * layouts.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "packed.h"
#include "scene_asset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- a loader that counts what is drawn ------------------------------------------------------ */

typedef void (*draw_arrays)(unsigned mode, int first, int count);
typedef void (*draw_instances)(unsigned mode, int first, int count, int instances);

static struct {
    draw_arrays real;
    draw_instances real_instances;
    psplat_host *host;
    int draws, vertices;
} counter;

static void count_draw(unsigned mode, int first, int count) {
    ++counter.draws;
    counter.vertices += count;
    counter.real(mode, first, count);
}

static void count_instances(unsigned mode, int first, int count, int instances) {
    ++counter.draws;
    counter.vertices += count * instances;
    counter.real_instances(mode, first, count, instances);
}

static void *counting_get_proc(void *user, const char *name) {
    void *address = psplat_host_get_proc(counter.host, name);
    (void)user;
    if (strcmp(name, "glDrawArrays") == 0) {
        draw_arrays mine = count_draw;
        memcpy(&counter.real, &address, sizeof address);
        memcpy(&address, &mine, sizeof address);
    } else if (strcmp(name, "glDrawArraysInstanced") == 0) {
        draw_instances mine = count_instances;
        memcpy(&counter.real_instances, &address, sizeof address);
        memcpy(&address, &mine, sizeof address);
    }
    return address;
}

typedef struct drawn {
    int draws, vertices;
    psplat_memory memory;
} drawn;

/* Draws one frame with a new renderer. */
static drawn draw_all(const scene *const *scenes, size_t count, const psplat_view *view) {
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    const float zeros[4] = {0};
    psplat_item items[2] = {{.model = NULL}};
    const psplat_renderer_desc desc = {.get_proc = counting_get_proc};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    for (size_t i = 0; i < count; ++i) {
        psplat_asset *asset = scene_open(scenes[i]);
        canvas_check(psplat_model_create(renderer, asset, &items[i].model, &error), &error);
        psplat_asset_destroy(asset);
    }
    canvas_check(psplat_host_begin(counter.host, view->width, view->height, 1, zeros, &error),
                 &error);
    counter.draws = counter.vertices = 0;
    canvas_check(psplat_draw(renderer, view, items, count, &error), &error);
    drawn result = {counter.draws, counter.vertices, psplat_renderer_memory(renderer)};
    for (size_t i = 0; i < count; ++i) psplat_model_destroy(renderer, items[i].model);
    psplat_renderer_destroy(renderer);
    return result;
}

static drawn draw(const scene *s, const psplat_view *view) {
    return draw_all(&s, 1, view);
}

static psplat_view view_of(void) {
    psplat_view view = camera_view(64, 64);
    camera_look(&view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_perspective(&view, 100, 1, 10);
    return view;
}

/* ---- passes ---------------------------------------------------------------------------------- */

static void test_passes(void **state) {
    (void)state;
    scene s = scene_sphere(100, 1);
    psplat_view view = view_of();
    assert_int_equal(draw(&s, &view).draws, 3); /* visibility, attributes, resolve */
    view.mode = PSPLAT_MODE_FLAT;
    assert_int_equal(draw(&s, &view).draws, 2); /* no visibility pass, as the nearest splat shows */
    view.mode = PSPLAT_MODE_PHONG;
    view.lights[0].casts_shadow = 1;
    view.lights[1] = view.lights[0];
    view.light_count = 2;
    assert_int_equal(draw(&s, &view).draws, 5); /* two shadow maps more */
    view.shading = PSPLAT_SHADING_NORMAL;
    assert_int_equal(draw(&s, &view).draws, 3); /* shadows do not matter here */
    scene_free(&s);
}

/* A model that faces away or lies beside the view is not even sent to the vertex stage. */
static void test_vertices(void **state) {
    (void)state;
    scene s = scene_disc(1);
    psplat_view view = view_of();
    assert_int_equal(draw(&s, &view).vertices, 3 + 3 + 3);
    camera_look(&view, (double[]){0, 0, -5}, (double[]){0, 0, 0});
    assert_int_equal(draw(&s, &view).vertices, 0);
    view.culling = PSPLAT_CULL_NEVER;
    assert_int_equal(draw(&s, &view).vertices, 9);
    camera_look(&view, (double[]){0, 0, 5}, (double[]){9, 0, 5});
    assert_int_equal(draw(&s, &view).vertices, 0);
    scene_free(&s);
}

/* ---- targets --------------------------------------------------------------------------------- */

/* Bytes a pixel: 16 for normal and weight, 4 for the depth sum, 4 for the depth buffer. */
static void test_targets(void **state) {
    (void)state;
    const size_t pixels = 64 * 64;
    scene s = scene_sphere(100, 1);
    psplat_view view = view_of();
    psplat_memory memory = draw(&s, &view).memory;
    assert_int_equal(memory.targets, pixels * (16 + 4 + 4));
    assert_int_equal(memory.shadows + memory.environments, 0);
    assert_int_equal(memory.models, 512 * 48); /* a splat takes a row of three texels */
    s.has_color = 1;
    for (size_t i = 0; i < s.count; ++i) s.splats[i].color[0] = (float)(i % 2);
    assert_int_equal(draw(&s, &view).memory.targets, pixels * (16 + 4 + 4 + 16));
    /* The colours are not used here: */
    view.shading = PSPLAT_SHADING_NORMAL;
    assert_int_equal(draw(&s, &view).memory.targets, pixels * (16 + 4 + 4));
    view.shading = PSPLAT_SHADING_LIT;
    view.lights[0].casts_shadow = 1;
    view.shadow_size = 128;
    assert_int_equal(draw(&s, &view).memory.shadows, 128 * 128 * 4);
    scene_free(&s);
}

/* Metallic and roughness take a target of colours and half of a depth target; emission and unlit
 * take a target of their own. Only lighting reads them. */
static void test_materials(void **state) {
    (void)state;
    const size_t pixels = 64 * 64;
    scene s = scene_sphere(100, 1), rough = scene_sphere(100, 1);
    const scene *both[] = {&s, &rough};
    psplat_view view = view_of();
    assert_int_equal(draw_all(both, 2, &view).memory.targets, pixels * (16 + 4 + 4));
    rough.material.roughness = 1;
    assert_int_equal(draw_all(both, 2, &view).memory.targets, pixels * (16 + 8 + 4 + 16));
    rough.material.unlit = 1;
    assert_int_equal(draw_all(both, 2, &view).memory.targets, pixels * (16 + 8 + 4 + 16 + 16));
    rough.material.unlit = 0;
    rough.material.emissive[1] = 0.5f;
    assert_int_equal(draw_all(both, 2, &view).memory.targets, pixels * (16 + 8 + 4 + 16 + 16));
    view.shading = PSPLAT_SHADING_UNLIT;
    assert_int_equal(draw_all(both, 2, &view).memory.targets, pixels * (16 + 4 + 4));
    rough.material.base_color[1] = 0.5f;
    assert_int_equal(draw_all(both, 2, &view).memory.targets, pixels * (16 + 4 + 4 + 16));
    scene_free(&s);
    scene_free(&rough);
}

/* ---- materials that vary -------------------------------------------------------------------- */

/* Returns the memory of one splat with these attributes. */
static psplat_memory draw_varied(const char *const names[2], const psplat_view *view) {
    static const double values[3] = {0.5, 0.5, 0.5};
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    psplat_asset *asset = NULL;
    psplat_item item = {.model = NULL};
    const float zeros[4] = {0};
    packed p = packed_default();
    for (size_t i = 0; i < 2 && names[i]; ++i)
        p.attributes[4 + i] = (packed_attribute){names[i], PACKED_FLOAT, 3, 0, values};
    char *text = packed_text(&p);
    canvas_check(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error), &error);
    free(text);
    const psplat_renderer_desc desc = {.get_proc = counting_get_proc};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    canvas_check(psplat_model_create(renderer, asset, &item.model, &error), &error);
    psplat_asset_destroy(asset);
    canvas_check(psplat_host_begin(counter.host, view->width, view->height, 1, zeros, &error),
                 &error);
    canvas_check(psplat_draw(renderer, view, &item, 1, &error), &error);
    psplat_memory memory = psplat_renderer_memory(renderer);
    assert_int_equal(psplat_model_describe(item.model).bytes, memory.models);
    psplat_model_destroy(renderer, item.model);
    psplat_renderer_destroy(renderer);
    return memory;
}

/* Three numbers take twelve bytes a splat. A pixel takes the targets of test_materials, and eight
 * bytes more where occlusion varies. */
static void test_finishes(void **state) {
    (void)state;
    static const char *const none[2] = {NULL, NULL}, *const glow[2] = {"EMISSIVE", NULL};
    static const char *const surface[2] = {"OCCLUSION_ROUGHNESS_METALLIC", NULL};
    static const char *const gradient[2] = {"COLOR_U", "COLOR_V"};
    const size_t pixels = 64 * 64;
    psplat_view view = view_of();
    psplat_memory plain = draw_varied(none, &view), glowing = draw_varied(glow, &view);
    psplat_memory rough = draw_varied(surface, &view), colored = draw_varied(gradient, &view);
    assert_int_equal(plain.models, 512 * 48);
    assert_int_equal(plain.targets, pixels * (16 + 4 + 4));
    assert_int_equal(glowing.models, 512 * (48 + 12));
    assert_int_equal(glowing.targets, pixels * (16 + 8 + 4 + 16 + 16));
    assert_int_equal(rough.models, 512 * (48 + 12));
    assert_int_equal(rough.targets, pixels * (16 + 16 + 4 + 16));
    assert_int_equal(colored.models, 512 * (48 + 24));
    assert_int_equal(colored.targets, pixels * (16 + 4 + 4 + 16));
    view.shading = PSPLAT_SHADING_NORMAL;
    assert_int_equal(draw_varied(surface, &view).targets, pixels * (16 + 4 + 4));
}

/* ---- many splats in a pixel ------------------------------------------------------------------ */

/* Every pixel has ten thousand splats: sums stay finite, and their quotients are those of one
 * splat. */
static void test_overdraw(void **state) {
    (void)state;
    enum { COUNT = 10000 };
    scene s = scene_blank(COUNT), single = scene_disc(2);
    for (int i = 0; i < COUNT; ++i) s.splats[i] = single.splats[0];
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_perspective(&view, 20, 1, 10);
    canvas *c = canvas_create(PSPLAT_API_GL);
    float one[4], depth = 0, weight = 0;
    for (int many = 0; many < 2; ++many) {
        psplat_asset *asset = scene_open(many ? &s : &single);
        psplat_item item = {.model = canvas_model(c, asset)};
        canvas_draw(c, &view, &item, 1);
        const float *middle = canvas_pixel(c, 64, 64);
        float at = c->depth[64 * CANVAS_SIZE + 64];
        if (!many) memcpy(one, middle, sizeof one);
        if (!many) depth = at;
        /* The tolerance covers 10000 roundings of 2^-24 each, at worst all in one direction. */
        for (int i = 0; i < 3; ++i) assert_true(fabsf(middle[i] - one[i]) < 1e-3f);
        assert_true(fabsf(at - depth) < 1e-3f);
        view.shading = PSPLAT_SHADING_OVERDRAW;
        canvas_draw(c, &view, &item, 1);
        weight = *canvas_pixel(c, 64, 64);
        assert_true(weight == (many ? (float)COUNT : 1));
        view.shading = PSPLAT_SHADING_LIT;
        psplat_model_destroy(c->renderer, item.model);
        psplat_asset_destroy(asset);
    }
    canvas_destroy(c);
    scene_free(&s);
    scene_free(&single);
}

static int open_host(void **state) {
    psplat_error error = {0};
    (void)state;
    canvas_check(psplat_host_create(PSPLAT_API_GL, 1, &counter.host, &error), &error);
    return 0;
}

static int close_host(void **state) {
    (void)state;
    psplat_host_destroy(counter.host);
    return 0;
}

int test_needs_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_passes),   cmocka_unit_test(test_vertices),
        cmocka_unit_test(test_targets),  cmocka_unit_test(test_materials),
        cmocka_unit_test(test_finishes), cmocka_unit_test(test_overdraw), /* makes a context */
    };
    return cmocka_run_group_tests(tests, open_host, close_host);
}
