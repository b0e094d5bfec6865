/* SPDX-License-Identifier: MIT
 *
 * test_contexts.c - tests several of everything in one process: renderers in one context, GL and
 * GLES contexts in turn, a context in each of several threads at once, and assets opened by threads
 * while others draw. The pictures must equal those of a single renderer bit by bit. Built with
 * -fsanitize=thread this finds data races of the runtime, which has no state to share.
 */
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "scene_asset.h"

enum { VIEWS = 6, PIXELS = CANVAS_SIZE * CANVAS_SIZE };

/* The file that all of them open, and what a single renderer of each API draws in each view. */
typedef struct common {
    uint8_t *glb;
    size_t size;
    float *expected[2][VIEWS]; /* [PSPLAT_API_GL], [PSPLAT_API_GLES]; CANVAS_SIZE^2 RGBA */
} common;

static psplat_view make_view(int index) {
    const double eye[3] = {0.4 * index - 1, 0.7, 2}, target[3] = {0, 0, 0};
    static const psplat_mode modes[VIEWS] = {PSPLAT_MODE_PHONG,    PSPLAT_MODE_FLAT,
                                             PSPLAT_MODE_GAUSSIAN, PSPLAT_MODE_PHONG,
                                             PSPLAT_MODE_FLAT,     PSPLAT_MODE_PARAMETERS};
    int size = CANVAS_SIZE - 10 * index;
    psplat_view view = camera_view(size, size);
    view.mode = modes[index];
    view.no_filter = index % 2;
    camera_look(&view, eye, target);
    camera_perspective(&view, size * 1.2, 0.5, 5.0);
    return view;
}

/* ---- a renderer that threads can have ------------------------------------------------------- */

typedef struct thread_renderer {
    const common *common;
    psplat_api api;
    psplat_host *host;
    psplat_renderer *renderer;
    psplat_asset *asset;
    psplat_item item;
    float *pixels;
    psplat_error error; /* the first error */
    int different;      /* pictures that differ from the expected ones */
} thread_renderer;

static psplat_result thread_renderer_open(thread_renderer *a) {
    a->pixels = malloc(4 * PIXELS * sizeof *a->pixels);
    psplat_result result = psplat_host_create(a->api, 1, &a->host, &a->error);
    psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = a->host};
    if (!result) result = psplat_renderer_create(&desc, &a->renderer, &a->error);
    if (!result)
        result =
            psplat_asset_open_memory(a->common->glb, a->common->size, NULL, &a->asset, &a->error);
    if (!result) result = psplat_model_create(a->renderer, a->asset, &a->item.model, &a->error);
    return result;
}

static void thread_renderer_close(thread_renderer *a) {
    psplat_host_make_current(a->host, NULL);
    psplat_model_destroy(a->renderer, a->item.model);
    psplat_renderer_destroy(a->renderer);
    psplat_asset_destroy(a->asset);
    psplat_host_destroy(a->host);
    free(a->pixels);
}

static psplat_result thread_renderer_draw(thread_renderer *a, int index) {
    static const float clear[4] = {0.25f, 0.5f, 0.75f, 0};
    psplat_view view = make_view(index);
    psplat_result result =
        psplat_host_begin(a->host, CANVAS_SIZE, CANVAS_SIZE, 1, clear, &a->error);
    if (!result) result = psplat_draw(a->renderer, &view, &a->item, 1, &a->error);
    if (!result) result = psplat_host_read_float(a->host, a->pixels, &a->error);
    return result;
}

static void thread_renderer_compare(thread_renderer *a, int index) {
    const float *expected = a->common->expected[a->api][index];
    if (thread_renderer_draw(a, index) ||
        memcmp(a->pixels, expected, 4 * PIXELS * sizeof *expected) != 0)
        ++a->different;
}

static void expect_flawless(const thread_renderer *a) {
    if (a->error.code) fail_msg("%s", a->error.text);
    assert_int_equal(a->different, 0);
}

/* ---- in turns ------------------------------------------------------------------------------- */

/* Two contexts of each API take turns; each is made current only by drawing in it. */
static void test_turns(void **state) {
    thread_renderer renderers[4];
    for (int i = 0; i < 4; ++i) {
        renderers[i] = (thread_renderer){.common = *state, .api = (psplat_api)(i % 2)};
        canvas_check(thread_renderer_open(&renderers[i]), &renderers[i].error);
    }
    for (int turn = 0; turn < 4 * VIEWS; ++turn)
        thread_renderer_compare(&renderers[turn % 4], turn * 5 % VIEWS);
    for (int i = 0; i < 4; ++i) expect_flawless(&renderers[i]);
    /* One is destroyed, the others stay. */
    thread_renderer_close(&renderers[1]);
    for (int i = 0; i < 4; ++i)
        if (i != 1) thread_renderer_compare(&renderers[i], i);
    for (int i = 0; i < 4; ++i) {
        if (i == 1) continue;
        expect_flawless(&renderers[i]);
        thread_renderer_close(&renderers[i]);
    }
}

/* Two renderers in one context do not influence each other. */
static void test_one_context(void **state) {
    thread_renderer first = {.common = *state, .api = PSPLAT_API_GL}, second;
    canvas_check(thread_renderer_open(&first), &first.error);
    second = first;
    psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = first.host};
    canvas_check(psplat_renderer_create(&desc, &second.renderer, &second.error), &second.error);
    canvas_check(
        psplat_model_create(second.renderer, second.asset, &second.item.model, &second.error),
        &second.error);
    for (int turn = 0; turn < 2 * VIEWS; ++turn)
        thread_renderer_compare(turn % 2 ? &first : &second, turn * 5 % VIEWS);
    psplat_model_destroy(second.renderer, second.item.model);
    psplat_renderer_destroy(second.renderer);
    thread_renderer_compare(&first, 0);
    expect_flawless(&first);
    expect_flawless(&second);
    thread_renderer_close(&first);
}

/* ---- at once -------------------------------------------------------------------------------- */

static void *draw_all(void *argument) {
    thread_renderer *a = argument;
    if (thread_renderer_open(a)) return NULL;
    for (int turn = 0; turn < 3 * VIEWS; ++turn) thread_renderer_compare(a, turn % VIEWS);
    thread_renderer_close(a);
    return NULL;
}

static void test_threads(void **state) {
    enum { THREADS = 4 };
    thread_renderer renderers[THREADS];
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; ++i) {
        renderers[i] = (thread_renderer){.common = *state, .api = (psplat_api)(i % 2)};
        assert_int_equal(pthread_create(&threads[i], NULL, draw_all, &renderers[i]), 0);
    }
    for (int i = 0; i < THREADS; ++i) pthread_join(threads[i], NULL);
    for (int i = 0; i < THREADS; ++i) expect_flawless(&renderers[i]);
}

/* Opens assets until it is told to stop; the last asset is kept for the thread that draws. */
typedef struct opener {
    const common *common;
    psplat_asset *asset;
    psplat_error error;
} opener;

static void *open_all(void *argument) {
    opener *o = argument;
    for (int i = 0; i < 30 && !o->error.code; ++i) {
        psplat_asset_destroy(o->asset);
        psplat_asset_open_memory(o->common->glb, o->common->size, NULL, &o->asset, &o->error);
    }
    return NULL;
}

/* Workers open assets while this thread draws; afterwards this thread draws those assets. */
static void test_workers(void **state) {
    enum { WORKERS = 2 };
    opener openers[WORKERS];
    pthread_t threads[WORKERS];
    thread_renderer a = {.common = *state, .api = PSPLAT_API_GL};
    canvas_check(thread_renderer_open(&a), &a.error);
    for (int i = 0; i < WORKERS; ++i) {
        openers[i] = (opener){.common = *state};
        assert_int_equal(pthread_create(&threads[i], NULL, open_all, &openers[i]), 0);
    }
    for (int turn = 0; turn < 2 * VIEWS; ++turn) thread_renderer_compare(&a, turn % VIEWS);
    for (int i = 0; i < WORKERS; ++i) {
        pthread_join(threads[i], NULL);
        if (openers[i].error.code) fail_msg("%s", openers[i].error.text);
        psplat_model_destroy(a.renderer, a.item.model);
        canvas_check(psplat_model_create(a.renderer, openers[i].asset, &a.item.model, &a.error),
                     &a.error);
        psplat_asset_destroy(openers[i].asset);
        thread_renderer_compare(&a, i);
    }
    expect_flawless(&a);
    thread_renderer_close(&a);
}

/* ---- fixtures ------------------------------------------------------------------------------- */

static int setup(void **state) {
    common *c = calloc(1, sizeof *c);
    assert_non_null(c);
    scene s = scene_ellipses(300, 3, 11);
    c->glb = scene_glb(&s, &c->size);
    scene_free(&s);
    for (int api = 0; api < 2; ++api) {
        thread_renderer a = {.common = c, .api = (psplat_api)api};
        canvas_check(thread_renderer_open(&a), &a.error);
        for (int i = 0; i < VIEWS; ++i) {
            canvas_check(thread_renderer_draw(&a, i), &a.error);
            c->expected[api][i] = a.pixels;
            a.pixels = malloc(4 * PIXELS * sizeof *a.pixels);
        }
        thread_renderer_close(&a);
    }
    *state = c;
    return 0;
}

static int teardown(void **state) {
    common *c = *state;
    for (int api = 0; api < 2; ++api)
        for (int i = 0; i < VIEWS; ++i) free(c->expected[api][i]);
    free(c->glb);
    free(c);
    return 0;
}

int test_contexts_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_turns),
        cmocka_unit_test(test_one_context),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_workers),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
