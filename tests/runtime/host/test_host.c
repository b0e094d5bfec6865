/* SPDX-License-Identifier: MIT
 *
 * test_host.c - tests the headless host: two hosts in one process, reading back what was cleared,
 * what it refuses, and a renderer that is made and destroyed many times.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "scene_asset.h"

static psplat_host *open_host(psplat_api api) {
    psplat_error error = {0};
    psplat_host *host = NULL;
    canvas_check(psplat_host_create(api, 1, &host, &error), &error);
    return host;
}

static void test_names(void **state) {
    (void)state;
    psplat_host *gl = open_host(PSPLAT_API_GL), *es = open_host(PSPLAT_API_GLES);
    psplat_error error = {0};
    canvas_check(psplat_host_make_current(gl, &error), &error);
    assert_non_null(strstr(psplat_host_renderer(gl), "llvmpipe"));
    assert_null(strstr(psplat_host_version(gl), "ES"));
    canvas_check(psplat_host_make_current(es, &error), &error);
    assert_non_null(strstr(psplat_host_version(es), "OpenGL ES"));
    psplat_host_destroy(gl);
    assert_non_null(psplat_host_renderer(es));
    psplat_host_destroy(es);
    psplat_host_destroy(NULL);
}

/* A host that may use a GPU works as well, whatever the machine has. */
static void test_any_device(void **state) {
    (void)state;
    psplat_error error = {0};
    psplat_host *host = NULL;
    canvas_check(psplat_host_create(PSPLAT_API_GL, 0, &host, &error), &error);
    psplat_host_destroy(host);
}

/* Two hosts are used in turn: each keeps its own framebuffer while sizes and formats change. */
static void test_two_hosts(void **state) {
    (void)state;
    psplat_host *hosts[2] = {open_host(PSPLAT_API_GL), open_host(PSPLAT_API_GLES)};
    psplat_error error = {0};
    for (int round = 0; round < 6; ++round) {
        psplat_host *host = hosts[round % 2];
        int width = 3 + round, height = 9 - round, count = width * height;
        const float rgba[4] = {0.2f, 0.4f, 0.6f, 1.0f};
        uint8_t *bytes = malloc((size_t)count * 4);
        float *depth = malloc((size_t)count * sizeof *depth);
        assert_true(bytes && depth);
        canvas_check(psplat_host_begin(host, width, height, 0, rgba, &error), &error);
        canvas_check(psplat_host_read_rgba8(host, bytes, &error), &error);
        canvas_check(psplat_host_read_depth(host, depth, &error), &error);
        const uint8_t expected[4] = {51, 102, 153, 255};
        for (int i = 0; i < count; ++i) {
            assert_memory_equal(bytes + 4 * i, expected, 4);
            assert_true(depth[i] == 1.0f);
        }
        free(bytes);
        free(depth);
    }
    psplat_host_destroy(hosts[0]);
    psplat_host_destroy(hosts[1]);
}

static void test_float(void **state) {
    (void)state;
    const float rgba[4] = {1e-6f, 123456.0f, -3.0f, 0.5f};
    for (int api = 0; api < 2; ++api) {
        psplat_host *host = open_host((psplat_api)api);
        psplat_error error = {0};
        float pixels[2 * 2 * 4];
        canvas_check(psplat_host_begin(host, 2, 2, 1, rgba, &error), &error);
        canvas_check(psplat_host_read_float(host, pixels, &error), &error);
        for (int i = 0; i < 4; ++i) assert_memory_equal(pixels + 4 * i, rgba, sizeof rgba);
        psplat_host_destroy(host);
    }
}

static void test_refusals(void **state) {
    (void)state;
    psplat_host *host = NULL;
    psplat_error error = {0};
    float pixel[4], black[4] = {0};
    uint8_t bytes[4];
    assert_int_equal(psplat_host_create((psplat_api)7, 1, &host, &error), PSPLAT_ERROR_ARGUMENT);
    assert_null(host);
    host = open_host(PSPLAT_API_GL);
    assert_int_equal(psplat_host_read_float(host, pixel, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_host_begin(host, 0, 1, 1, black, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_host_begin(host, 1 << 24, 1, 1, black, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_host_begin(host, 1, 1, 1, NULL, &error), PSPLAT_ERROR_ARGUMENT);
    canvas_check(psplat_host_begin(host, 1, 1, 1, black, &error), &error);
    assert_int_equal(psplat_host_read_rgba8(host, bytes, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_host_read_float(host, NULL, &error), PSPLAT_ERROR_ARGUMENT);
    psplat_host_destroy(host);
}

/* Makes 200 renderers with models and draws a frame with each; the sanitizers' leak checker reports
 * what remains. */
static void test_many_renderers(void **state) {
    (void)state;
    canvas *c = canvas_create(PSPLAT_API_GL);
    scene s = scene_cube(0.5f);
    psplat_asset *asset = scene_open(&s);
    psplat_view view = camera_view(8, 8);
    for (int i = 0; i < 200; ++i) {
        psplat_error error = {0};
        psplat_renderer_destroy(c->renderer);
        psplat_renderer_desc desc = {.get_proc = psplat_host_get_proc, .user = c->host};
        canvas_check(psplat_renderer_create(&desc, &c->renderer, &error), &error);
        psplat_item item = {.model = canvas_model(c, asset)};
        view.mode = (psplat_mode)(i % PSPLAT_MODE_COUNT);
        if (i % 50 == 0) canvas_draw(c, &view, &item, 1);
        psplat_model_destroy(c->renderer, item.model);
    }
    psplat_asset_destroy(asset);
    scene_free(&s);
    canvas_destroy(c);
}

static void test_many_hosts(void **state) {
    (void)state;
    for (int i = 0; i < 20; ++i) psplat_host_destroy(open_host((psplat_api)(i % 2)));
}

int test_host_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names),      cmocka_unit_test(test_any_device),
        cmocka_unit_test(test_two_hosts),  cmocka_unit_test(test_float),
        cmocka_unit_test(test_refusals),   cmocka_unit_test(test_many_renderers),
        cmocka_unit_test(test_many_hosts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
