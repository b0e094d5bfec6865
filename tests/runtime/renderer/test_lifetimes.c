/* SPDX-License-Identifier: MIT
 *
 * test_lifetimes.c - tests that what is created a thousand times and destroyed leaves no byte and
 * no GL object behind, and that psplat_renderer_memory tells how much there is in the meantime.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "ledger.h"
#include "scene_asset.h"
#include "spy.h"

enum { TIMES = 1000 };

typedef struct spied_renderer {
    canvas *canvas; /* its renderer draws through spy and ledger */
    spy spy;
    ledger ledger;
    scene scene;
    psplat_asset *asset;
    psplat_view view;
} spied_renderer;

static psplat_renderer *make_renderer(spied_renderer *s) {
    psplat_error error = {0};
    psplat_renderer *renderer = NULL;
    psplat_renderer_desc desc = {
        .get_proc = spy_get_proc, .user = &s->spy, .allocator = ledger_allocator(&s->ledger)};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    return renderer;
}

/* Counts that must not grow. */
typedef struct count {
    size_t objects, allocated;
    psplat_memory memory;
} count;

static count take(const spied_renderer *s) {
    return (count){spy_live(&s->spy), s->ledger.bytes, psplat_renderer_memory(s->canvas->renderer)};
}

static void expect_same(const spied_renderer *s, const count *before) {
    count now = take(s);
    assert_int_equal(now.objects, before->objects);
    assert_int_equal(now.allocated, before->allocated);
    assert_memory_equal(&now.memory, &before->memory, sizeof now.memory);
    assert_string_equal(s->spy.trouble, "");
}

static void draw(spied_renderer *s, psplat_model *model, int size) {
    psplat_error error = {0};
    psplat_item item = {.model = model};
    s->view.width = s->view.height = size;
    canvas_check(psplat_draw(s->canvas->renderer, &s->view, &item, 1, &error), &error);
}

static void test_renderers(void **state) {
    spied_renderer *s = *state;
    count before = take(s);
    for (int i = 0; i < TIMES; ++i) psplat_renderer_destroy(make_renderer(s));
    expect_same(s, &before);
}

/* Renderers with programs and targets are made fewer times, since each compiles its own
 * programs. */
static void test_used_renderers(void **state) {
    spied_renderer *s = *state;
    psplat_renderer *kept = s->canvas->renderer;
    count before = take(s);
    for (int i = 0; i < 40; ++i) {
        s->canvas->renderer = make_renderer(s);
        psplat_model *model = canvas_model(s->canvas, s->asset);
        s->view.mode = (psplat_mode)(i % PSPLAT_MODE_COUNT);
        draw(s, model, 8 + i);
        assert_true(psplat_renderer_memory(s->canvas->renderer).targets > 0);
        psplat_model_destroy(s->canvas->renderer, model);
        psplat_renderer_destroy(s->canvas->renderer);
    }
    s->canvas->renderer = kept;
    expect_same(s, &before);
}

static void test_models(void **state) {
    spied_renderer *s = *state;
    count before = take(s);
    for (int i = 0; i < TIMES; ++i) {
        psplat_model *model = canvas_model(s->canvas, s->asset);
        size_t bytes = psplat_renderer_memory(s->canvas->renderer).models - before.memory.models;
        assert_true(bytes > 0);
        assert_int_equal(bytes, psplat_model_describe(model).bytes);
        psplat_model_destroy(s->canvas->renderer, model);
    }
    expect_same(s, &before);
}

static psplat_result make_environment(spied_renderer *s, psplat_environment **environment) {
    static const float radiance[6 * 3] = {1, 1, 1};
    const psplat_environment_desc desc = {radiance, 1};
    return psplat_environment_create(s->canvas->renderer, &desc, environment, NULL);
}

/* Most environments are made to fail at their first texture or upload, because filtering takes
 * long. */
static void test_environments(void **state) {
    spied_renderer *s = *state;
    psplat_environment *environment = NULL;
    count before = take(s);
    for (int i = 0; i < TIMES; ++i) {
        s->spy.fault = SPY_FAULT_TEXTURE_MEMORY;
        s->spy.at = s->spy.happened = 0;
        assert_int_equal(make_environment(s, &environment), PSPLAT_ERROR_MEMORY);
        assert_null(environment);
    }
    s->spy.fault = SPY_FAULT_NONE;
    expect_same(s, &before);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(make_environment(s, &environment), PSPLAT_OK);
        assert_true(take(s).memory.environments > 0);
        psplat_environment_destroy(s->canvas->renderer, environment);
        expect_same(s, &before);
    }
    psplat_environment_destroy(s->canvas->renderer, NULL);
}

/* The second frame of every mode and shading, with shadows too, allocates and makes nothing. */
static void test_frames(void **state) {
    spied_renderer *s = *state;
    psplat_model *model = canvas_model(s->canvas, s->asset);
    s->view.lights[0].casts_shadow = 1;
    s->view.shadow_size = 16;
    size_t made = 0;
    int calls = 0;
    for (int frame = 0; frame < 2; ++frame) {
        made = s->spy.made;
        calls = s->ledger.calls;
        for (int mode = 0; mode < PSPLAT_MODE_COUNT; ++mode)
            for (int shading = 0; shading < PSPLAT_SHADING_COUNT; ++shading) {
                s->view.mode = (psplat_mode)mode;
                s->view.shading = (psplat_shading)shading;
                draw(s, model, 16);
            }
    }
    assert_int_equal(s->spy.made, made);
    assert_int_equal(s->ledger.calls, calls);
    psplat_model_destroy(s->canvas->renderer, model);
}

/* Shadow maps stay while their size does and no view needs more of them. Splats that are large in a
 * map have another program than small ones, so that both are made first. */
static void test_shadows(void **state) {
    spied_renderer *s = *state;
    psplat_model *model = canvas_model(s->canvas, s->asset);
    s->view.light_count = 2;
    s->view.lights[1] = s->view.lights[0];
    s->view.lights[0].casts_shadow = 1;
    s->view.shadow_size = 40;
    draw(s, model, 8);
    s->view.shadow_size = 16;
    draw(s, model, 8);
    count before = take(s);
    assert_int_equal(before.memory.shadows, 16 * 16 * 4);
    for (int i = 0; i < TIMES; ++i) {
        s->view.shadow_size = 16 + i % 24;
        s->view.lights[1].casts_shadow = i % 2;
        draw(s, model, 8);
        size_t least = (size_t)(s->view.shadow_size * s->view.shadow_size * 4);
        assert_in_range(take(s).memory.shadows, least, 2 * least);
    }
    s->view.lights[1].casts_shadow = 0;
    s->view.shadow_size = 16;
    draw(s, model, 8);
    expect_same(s, &before);
    psplat_model_destroy(s->canvas->renderer, model);
}

/* Targets are kept for the last view and, for some draws, for the one before. Programs of large and
 * of small splats are made first. */
static void test_targets(void **state) {
    spied_renderer *s = *state;
    psplat_model *model = canvas_model(s->canvas, s->asset);
    draw(s, model, 1);
    for (int i = 0; i < 70; ++i) draw(s, model, 50);
    count before = take(s);
    size_t last = 50 * 50;
    for (int i = 0; i < TIMES; ++i) {
        int size = 1 + i % 64;
        draw(s, model, size);
        /* There are at least a depth and a normal, and at most four colours in 32 bits. */
        size_t pixels = (size_t)(size * size), bytes = take(s).memory.targets;
        assert_true(bytes >= pixels * (4 + 8) && bytes <= (pixels + last) * (4 + 4 * 16));
        last = pixels;
    }
    for (int i = 0; i < 70; ++i) draw(s, model, 50);
    expect_same(s, &before);
    psplat_model_destroy(s->canvas->renderer, model);
}

/* Views of two sizes in each frame, many of the first size and the second sometimes missing, make
 * nothing after the first time. */
static void test_two_views(void **state) {
    spied_renderer *s = *state;
    psplat_model *model = canvas_model(s->canvas, s->asset);
    draw(s, model, 50);
    draw(s, model, 20);
    size_t made = s->spy.made;
    for (int i = 0; i < 120; ++i) {
        draw(s, model, 50);
        if (i % 40 == 0) draw(s, model, 20);
    }
    assert_int_equal(s->spy.made, made);
    psplat_model_destroy(s->canvas->renderer, model);
}

static void test_nothing(void **state) {
    spied_renderer *s = *state;
    psplat_memory none = psplat_renderer_memory(NULL);
    assert_true(none.models + none.targets + none.environments + none.shadows == 0);
    assert_int_equal(psplat_model_describe(NULL).splat_count, 0);
    psplat_model *model = canvas_model(s->canvas, s->asset);
    psplat_model_info info = psplat_model_describe(model);
    assert_int_equal(info.splat_count, s->scene.count);
    assert_int_equal(info.batch_count, psplat_asset_batch_count(s->asset));
    psplat_model_destroy(s->canvas->renderer, model);
}

/* ---- fixtures ------------------------------------------------------------------------------- */

static int setup(void **state, psplat_api api) {
    const double eye[3] = {0.3, 0.2, 2}, target[3] = {0, 0, 0};
    spied_renderer *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->canvas = canvas_create(api);
    psplat_renderer_destroy(s->canvas->renderer);
    s->spy = (spy){.get_proc = psplat_host_get_proc, .user = s->canvas->host};
    s->ledger.fail_at = -1;
    s->canvas->renderer = make_renderer(s);
    s->scene = scene_ellipses(60, 2, 7);
    s->asset = scene_open(&s->scene);
    s->view = camera_view(8, 8);
    camera_look(&s->view, eye, target);
    camera_parallel(&s->view, 1.2, 0.5, 4.0);
    canvas_begin(s->canvas);
    *state = s;
    return 0;
}

static int setup_gl(void **state) {
    return setup(state, PSPLAT_API_GL);
}

static int setup_es(void **state) {
    return setup(state, PSPLAT_API_GLES);
}

static int teardown(void **state) {
    spied_renderer *s = *state;
    psplat_renderer_destroy(s->canvas->renderer);
    s->canvas->renderer = NULL;
    assert_int_equal(spy_live(&s->spy), 0);
    assert_int_equal(s->ledger.bytes, 0);
    canvas_destroy(s->canvas);
    psplat_asset_destroy(s->asset);
    scene_free(&s->scene);
    free(s);
    return 0;
}

#define BOTH(test)                                                                                 \
    cmocka_unit_test_setup_teardown(test, setup_gl, teardown),                                     \
        cmocka_unit_test_setup_teardown(test, setup_es, teardown)

int test_lifetimes_main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(test_renderers), BOTH(test_used_renderers), BOTH(test_models),
        BOTH(test_targets),   BOTH(test_shadows),        BOTH(test_environments),
        BOTH(test_two_views), BOTH(test_nothing),        BOTH(test_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
