/* SPDX-License-Identifier: MIT
 *
 * test_gl_failures.c - tests that every failure is reported, leaves nothing behind and spoils
 * nothing: each allocation in turn, GL's memory, framebuffers, compilers and linkers, and contexts
 * that are lost at any call.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "ledger.h"
#include "scene_asset.h"
#include "spy.h"

/* A renderer between a spy and a counting allocator, and what it draws. */
typedef struct spied_renderer {
    psplat_host *host;
    spy spy;
    ledger ledger;
    scene scene;
    psplat_asset *asset;
    psplat_view view;
    psplat_renderer *renderer;
    psplat_item item;
} spied_renderer;

enum { SIZE = 24 };

static const float radiance[6 * 3] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1};
static const psplat_environment_desc sky = {radiance, 1};

/* A resolve function of the host's has a copy in the renderer. */
static const psplat_resolve own = {
    .source = "layout(location = 0) out vec4 o_color;\n"
              "void resolve(Pixel pixel) {\n"
              "    o_color = vec4(shade(pixel.normal, pixel.window, pixel.color,\n"
              "                         pixel.emissive, pixel.surface), 1.0);\n"
              "}\n"};

static psplat_view make_view(void) {
    const double eye[3] = {0.3, 0.2, 2}, target[3] = {0, 0, 0};
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.2, 0.5, 4.0);
    view.lights[0].casts_shadow = 1;
    view.shadow_size = 16;
    view.resolve = &own;
    return view;
}

static spied_renderer spied_renderer_open(psplat_api api) {
    psplat_error error = {0};
    spied_renderer s = {.ledger = {.fail_at = -1}};
    canvas_check(psplat_host_create(api, 1, &s.host, &error), &error);
    s.spy = (spy){.get_proc = psplat_host_get_proc, .user = s.host};
    s.scene = scene_ellipses(30, 2, 9);
    scene_add_textures(&s.scene);
    s.asset = scene_open(&s.scene);
    s.view = make_view();
    return s;
}

static void spied_renderer_close(spied_renderer *s) {
    psplat_asset_destroy(s->asset);
    scene_free(&s->scene);
    psplat_host_destroy(s->host);
}

static psplat_result make(spied_renderer *s, psplat_error *error) {
    psplat_renderer_desc desc = {.get_proc = spy_get_proc,
                                 .user = &s->spy,
                                 .allocator = ledger_allocator(&s->ledger),
                                 .images = scene_images()};
    psplat_result result = psplat_renderer_create(&desc, &s->renderer, error);
    if (result == PSPLAT_OK)
        result = psplat_model_create(s->renderer, s->asset, &s->item.model, error);
    return result;
}

static psplat_result draw(spied_renderer *s, psplat_error *error) {
    const float black[4] = {0};
    psplat_error ignored;
    canvas_check(psplat_host_begin(s->host, SIZE, SIZE, 1, black, &ignored), &ignored);
    return psplat_draw(s->renderer, &s->view, &s->item, 1, error);
}

/* Does everything once that a renderer does; the first failure ends it. */
static psplat_result use_once(spied_renderer *s, psplat_error *error) {
    psplat_result result = make(s, error);
    if (result == PSPLAT_OK) result = draw(s, error);
    return result;
}

static void end(spied_renderer *s) {
    psplat_model_destroy(s->renderer, s->item.model);
    psplat_renderer_destroy(s->renderer);
    s->item.model = NULL;
    s->renderer = NULL;
}

static void expect_nothing_left(const spied_renderer *s) {
    assert_int_equal(s->ledger.bytes, 0);
    assert_int_equal(spy_live(&s->spy), 0);
    assert_string_equal(s->spy.trouble, "");
}

static void expect_failure(psplat_result result, const psplat_error *error, psplat_result wanted) {
    assert_int_equal(result, wanted);
    assert_int_equal(error->code, wanted);
    assert_true(strlen(error->text) > 10);
}

/* What failed once works when it is tried again, down to the last pixel. */
static void expect_recovery(spied_renderer *s, const float *expected) {
    static float color[SIZE * SIZE * 4];
    psplat_error error = {0};
    if (!s->renderer || !s->item.model) {
        end(s);
        canvas_check(make(s, &error), &error);
    }
    canvas_check(draw(s, &error), &error);
    canvas_check(psplat_host_read_float(s->host, color, &error), &error);
    assert_memory_equal(color, expected, sizeof color);
}

static void draw_expected(spied_renderer *s, float *expected) {
    psplat_error error = {0};
    canvas_check(use_once(s, &error), &error);
    canvas_check(psplat_host_read_float(s->host, expected, &error), &error);
    end(s);
    expect_nothing_left(s);
}

/* ---- one thing at a time -------------------------------------------------------------------- */

static void try_allocations(psplat_api api) {
    static float expected[SIZE * SIZE * 4];
    spied_renderer s = spied_renderer_open(api);
    draw_expected(&s, expected);
    int failures = 0;
    for (int done = 0; !done; ++failures) {
        psplat_error error = {0};
        s.ledger.calls = 0;
        s.ledger.fail_at = failures;
        psplat_result result = use_once(&s, &error);
        done = result == PSPLAT_OK;
        if (!done) expect_failure(result, &error, PSPLAT_ERROR_MEMORY);
        s.ledger.fail_at = -1;
        expect_recovery(&s, expected);
        end(&s);
        expect_nothing_left(&s);
        assert_true(failures < 100);
    }
    assert_true(failures > 4); /* at least renderer, model, batches, staging */
    spied_renderer_close(&s);
}

/* Returns how many opportunities the fault had. */
static int try_fault(psplat_api api, spy_fault fault, psplat_result wanted, const char *word) {
    static float expected[SIZE * SIZE * 4];
    spied_renderer s = spied_renderer_open(api);
    draw_expected(&s, expected);
    int at = 0;
    for (int done = 0; !done; ++at) {
        psplat_error error = {0};
        s.spy.fault = fault;
        s.spy.at = at;
        s.spy.happened = 0;
        psplat_result result = use_once(&s, &error);
        done = s.spy.happened <= at;
        if (done) canvas_check(result, &error);
        if (!done) expect_failure(result, &error, wanted);
        if (!done) assert_non_null(strstr(error.text, word));
        s.spy.fault = SPY_FAULT_NONE;
        expect_recovery(&s, expected);
        end(&s);
        expect_nothing_left(&s);
        assert_true(at < 200);
    }
    spied_renderer_close(&s);
    return at - 1;
}

static void test_allocations(void **state) {
    (void)state;
    try_allocations(PSPLAT_API_GL);
    try_allocations(PSPLAT_API_GLES);
}

static void test_faults(void **state) {
    (void)state;
    static const struct {
        spy_fault fault;
        psplat_result result;
        const char *word;
        int least;
    } cases[] = {
        /* Two levels of two images, splats, clip lines, texture coordinates, targets. */
        {SPY_FAULT_TEXTURE_MEMORY, PSPLAT_ERROR_MEMORY, "memory", 10},
        {SPY_FAULT_UPLOAD_MEMORY, PSPLAT_ERROR_MEMORY, "memory", 5},
        {SPY_FAULT_FRAMEBUFFER, PSPLAT_ERROR_GRAPHICS, "refused", 2},    /* targets, shadow maps */
        {SPY_FAULT_COMPILE, PSPLAT_ERROR_GRAPHICS, "shader refused", 6}, /* three programs */
        {SPY_FAULT_LINK, PSPLAT_ERROR_GRAPHICS, "program refused", 3},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (int api = 0; api < 2; ++api) {
            int count = try_fault((psplat_api)api, cases[i].fault, cases[i].result, cases[i].word);
            assert_true(count >= cases[i].least);
        }
}

/* GL is asked whether it had memory for the instances where their buffer grows, as it does in the
 * first frame. */
static void test_instances(void **state) {
    (void)state;
    static float expected[SIZE * SIZE * 4];
    spied_renderer s = spied_renderer_open(PSPLAT_API_GL);
    psplat_error error = {0};
    draw_expected(&s, expected);
    s.spy.fault = SPY_FAULT_BUFFER_MEMORY;
    s.spy.at = s.spy.happened = 0;
    expect_failure(use_once(&s, &error), &error, PSPLAT_ERROR_MEMORY);
    s.spy.fault = SPY_FAULT_NONE;
    expect_recovery(&s, expected);
    end(&s);
    expect_nothing_left(&s);
    spied_renderer_close(&s);
}

/* An environment has several textures, most of many levels and faces, and takes long to filter. So
 * only the first, a middle and the last opportunity fail. */
static void test_environments(void **state) {
    (void)state;
    psplat_environment *environment = NULL;
    psplat_error error = {0};
    spied_renderer s = spied_renderer_open(PSPLAT_API_GL);
    canvas_check(make(&s, &error), &error);
    ledger before = s.ledger;
    s.spy.at = -1; /* -1 only counts */
    s.spy.fault = SPY_FAULT_TEXTURE_MEMORY;
    canvas_check(psplat_environment_create(s.renderer, &sky, &environment, &error), &error);
    int last = s.spy.happened - 1, allocations = s.ledger.calls - before.calls;
    psplat_environment_destroy(s.renderer, environment);
    assert_int_equal(s.ledger.bytes, before.bytes);
    size_t live = spy_live(&s.spy);
    for (int i = 0; i < 3; ++i) {
        s.spy.at = i * last / 2;
        s.spy.happened = 0;
        psplat_result result = psplat_environment_create(s.renderer, &sky, &environment, &error);
        expect_failure(result, &error, PSPLAT_ERROR_MEMORY);
        assert_null(environment);
        assert_int_equal(psplat_renderer_memory(s.renderer).environments, 0);
        assert_int_equal(spy_live(&s.spy), live);
    }
    s.spy.fault = SPY_FAULT_NONE;
    for (int i = 0; i < allocations; ++i) {
        s.ledger.calls = 0;
        s.ledger.fail_at = i;
        psplat_result result = psplat_environment_create(s.renderer, &sky, &environment, &error);
        expect_failure(result, &error, PSPLAT_ERROR_MEMORY);
        assert_int_equal(s.ledger.bytes, before.bytes);
    }
    end(&s);
    expect_nothing_left(&s);
    spied_renderer_close(&s);
}

/* Errors that GL raised before belong to the host and make nothing of the runtime fail. */
static void test_flags_of_the_host(void **state) {
    const unsigned out_of_memory = 0x0505;
    (void)state;
    psplat_error error = {0};
    psplat_environment *environment = NULL;
    spied_renderer s = spied_renderer_open(PSPLAT_API_GL);
    psplat_renderer_desc desc = {
        .get_proc = spy_get_proc, .user = &s.spy, .allocator = ledger_allocator(&s.ledger)};
    s.spy.error = out_of_memory;
    canvas_check(psplat_renderer_create(&desc, &s.renderer, &error), &error);
    s.spy.error = out_of_memory;
    canvas_check(psplat_model_create(s.renderer, s.asset, &s.item.model, &error), &error);
    s.spy.error = out_of_memory;
    canvas_check(psplat_environment_create(s.renderer, &sky, &environment, &error), &error);
    s.spy.error = out_of_memory;
    canvas_check(draw(&s, &error), &error); /* makes shadow maps */
    s.view.light_count = 0;
    s.view.width = SIZE / 2;
    s.spy.error = out_of_memory;
    canvas_check(draw(&s, &error), &error); /* makes only targets */
    psplat_environment_destroy(s.renderer, environment);
    end(&s);
    expect_nothing_left(&s);
    spied_renderer_close(&s);
}

/* ---- lost contexts -------------------------------------------------------------------------- */

/* Where the loss is not noticed at once, because it came after the last call that tells, the next
 * frame notices it. From then on every call reports it. */
static void expect_loss(spied_renderer *s) {
    psplat_error error = {0};
    psplat_result result = use_once(s, &error);
    if (result == PSPLAT_OK) result = psplat_draw(s->renderer, &s->view, &s->item, 1, &error);
    expect_failure(result, &error, PSPLAT_ERROR_GRAPHICS);
    assert_non_null(strstr(error.text, "context"));
    if (!s->renderer || !s->item.model) return;
    for (int i = 0; i < 2; ++i) {
        psplat_model *model = NULL;
        memset(&error, 0, sizeof error);
        result = psplat_draw(s->renderer, &s->view, &s->item, 1, &error);
        expect_failure(result, &error, PSPLAT_ERROR_GRAPHICS);
        assert_non_null(strstr(error.text, "lost"));
        result = psplat_draw(s->renderer, &s->view, NULL, 0, &error);
        expect_failure(result, &error, PSPLAT_ERROR_GRAPHICS);
        result = psplat_model_create(s->renderer, s->asset, &model, &error);
        expect_failure(result, &error, PSPLAT_ERROR_GRAPHICS);
        assert_null(model);
    }
    psplat_environment *environment = NULL;
    result = psplat_environment_create(s->renderer, &sky, &environment, &error);
    expect_failure(result, &error, PSPLAT_ERROR_GRAPHICS);
}

/* The renderer is destroyed while a new context is current, none of whose objects may be deleted.
 * In that context a new renderer draws what the old one did. */
static void expect_new_context(spied_renderer *s, const float *expected) {
    spied_renderer next = spied_renderer_open(PSPLAT_API_GL);
    psplat_error error = {0};
    canvas_check(use_once(&next, &error), &error);
    size_t live = spy_live(&next.spy);
    s->spy = (spy){.get_proc = psplat_host_get_proc, .user = next.host};
    memcpy(s->spy.real, next.spy.real, sizeof s->spy.real);
    spy_use(&s->spy);
    end(s);
    assert_string_equal(s->spy.trouble, ""); /* it deleted nothing */
    assert_int_equal(s->ledger.bytes, 0);
    spy_use(&next.spy);
    expect_recovery(&next, expected);
    assert_int_equal(spy_live(&next.spy), live);
    end(&next);
    expect_nothing_left(&next);
    spied_renderer_close(&next);
}

static void try_loss(psplat_api api, int no_reset_status, int tells_once) {
    static float expected[SIZE * SIZE * 4];
    spied_renderer s = spied_renderer_open(api);
    draw_expected(&s, expected);
    s.spy.fault = SPY_FAULT_LOST;
    s.spy.at = 1 << 30;
    s.spy.calls = 0;
    psplat_error error = {0};
    canvas_check(use_once(&s, &error), &error);
    int total = (int)s.spy.calls, tries = 0;
    end(&s);
    spied_renderer_close(&s);
    assert_true(total > 300);
    /* Some forty calls are lost in turn, spread over loading, uploading and drawing. */
    for (int at = 0; at <= total; at += total / 41 + 1, ++tries) {
        s = spied_renderer_open(api);
        s.spy.fault = SPY_FAULT_LOST;
        s.spy.no_reset_status = no_reset_status;
        s.spy.tells_once = tells_once;
        s.spy.at = at;
        expect_loss(&s);
        if (tries % 8 == 5 && s.renderer) {
            expect_new_context(&s, expected);
        } else {
            end(&s);
            assert_int_equal(s.ledger.bytes, 0);
        }
        spied_renderer_close(&s);
    }
    assert_true(tries > 35);
}

static void test_loss(void **state) {
    (void)state;
    try_loss(PSPLAT_API_GL, 0, 0);
    try_loss(PSPLAT_API_GLES, 0, 0);
}

static void test_loss_by_errors(void **state) {
    (void)state;
    try_loss(PSPLAT_API_GL, 1, 0);
    try_loss(PSPLAT_API_GLES, 1, 1);
}

int test_gl_failures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_allocations),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_environments),
        cmocka_unit_test(test_loss),
        cmocka_unit_test(test_loss_by_errors),
        cmocka_unit_test(test_flags_of_the_host),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
