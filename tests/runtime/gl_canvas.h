/* SPDX-License-Identifier: MIT
 *
 * gl_canvas.h - a headless context, a renderer and the pixels that it drew, which tests of the
 * renderer share. Without EGL a test fails and says so, because the renderer cannot be tested
 * without a context. Include this file after cmocka.h.
 */
#ifndef PHONGSPLAT_TEST_GL_CANVAS_H
#define PHONGSPLAT_TEST_GL_CANVAS_H

#include "scene_asset.h"

#include <phongsplat/host.h>
#include <phongsplat/phongsplat.h>

#include <stdlib.h>
#include <string.h>

enum { CANVAS_SIZE = 128 };

typedef struct canvas {
    psplat_host *host;
    psplat_renderer *renderer;
    float color[CANVAS_SIZE * CANVAS_SIZE * 4]; /* the background is 0 0 0 0 */
    float depth[CANVAS_SIZE * CANVAS_SIZE];
} canvas;

static inline void canvas_check(psplat_result result, const psplat_error *error) {
    if (result == PSPLAT_OK) return;
    print_error("%s: %s\n", psplat_result_text(result), error->text);
    fail();
}

static inline canvas *canvas_create(psplat_api api) {
    psplat_error error = {0};
    canvas *c = calloc(1, sizeof *c);
    assert_non_null(c);
    canvas_check(psplat_host_create(api, 1, &c->host, &error), &error);
    psplat_renderer_desc desc = {
        .get_proc = psplat_host_get_proc, .user = c->host, .images = scene_images()};
    canvas_check(psplat_renderer_create(&desc, &c->renderer, &error), &error);
    return c;
}

static inline void canvas_destroy(canvas *c) {
    psplat_renderer_destroy(c->renderer);
    psplat_host_destroy(c->host);
    free(c);
}

/* Group fixtures for cmocka: *state is a canvas. */
static inline int canvas_setup_gl(void **state) {
    *state = canvas_create(PSPLAT_API_GL);
    return 0;
}

static inline int canvas_setup_gles(void **state) {
    *state = canvas_create(PSPLAT_API_GLES);
    return 0;
}

static inline int canvas_teardown(void **state) {
    canvas_destroy(*state);
    return 0;
}

static inline psplat_model *canvas_model(canvas *c, const psplat_asset *asset) {
    psplat_error error = {0};
    psplat_model *model = NULL;
    canvas_check(psplat_model_create(c->renderer, asset, &model, &error), &error);
    return model;
}

static inline void canvas_begin(canvas *c) {
    psplat_error error = {0};
    const float zeros[4] = {0};
    canvas_check(psplat_host_begin(c->host, CANVAS_SIZE, CANVAS_SIZE, 1, zeros, &error), &error);
}

static inline void canvas_read(canvas *c) {
    psplat_error error = {0};
    canvas_check(psplat_host_read_float(c->host, c->color, &error), &error);
    canvas_check(psplat_host_read_depth(c->host, c->depth, &error), &error);
}

/* Clears, draws and reads back. */
static inline void canvas_draw(canvas *c, const psplat_view *view, const psplat_item *items,
                               size_t count) {
    psplat_error error = {0};
    canvas_begin(c);
    canvas_check(psplat_draw(c->renderer, view, items, count, &error), &error);
    canvas_read(c);
}

static inline const float *canvas_pixel(const canvas *c, int x, int y) {
    return c->color + 4 * (y * CANVAS_SIZE + x);
}

static inline int canvas_covered(const canvas *c) {
    int count = 0;
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) count += c->color[4 * i + 3] > 0.0f;
    return count;
}

#endif
