/* SPDX-License-Identifier: MIT
 *
 * test_gl_api.c - tests the injected loader: every missing function is refused by name; contexts
 * that are too old or lack extensions are refused with a reason. Errors after loading are tested in
 * test_gl_failures.c.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "near.h"
#include "scene_asset.h"

/* ---- a null back end ----------------------------------------------------------------------- */

/* Stands for every function whose result does not matter. It is never called with arguments that
 * the called function would have to remove from the stack. */
static void null_function(void) {
}

static const char *null_version;

static const unsigned char *null_get_string(unsigned name) {
    return name == 0x1F02 ? (const unsigned char *)null_version : NULL;
}

static int null_major, null_minor;

static void null_get_integer(unsigned name, int *value) {
    *value = name == 0x821B   ? null_major
             : name == 0x821C ? null_minor
             : name == 0x0D33 ? 2048 /* GL_MAX_TEXTURE_SIZE */
                              : 0;
}

typedef struct null_loader {
    const char *missing;
    int calls;
    int fail_at; /* the call, counted from 0, that finds no function; -1: none */
} null_loader;

static void *address_of(void (*function)(void)) {
    void *address;
    memcpy(&address, &function, sizeof address);
    return address;
}

static void *null_get_proc(void *user, const char *name) {
    null_loader *loader = user;
    if (loader->calls++ == loader->fail_at) {
        loader->missing = name;
        return NULL;
    }
    if (strcmp(name, "glGetString") == 0) return address_of((void (*)(void))null_get_string);
    if (strcmp(name, "glGetIntegerv") == 0) return address_of((void (*)(void))null_get_integer);
    return address_of(null_function);
}

static psplat_result create_null(null_loader *loader, psplat_error *error) {
    psplat_renderer_desc desc = {.get_proc = null_get_proc, .user = loader};
    psplat_renderer *renderer = (psplat_renderer *)loader; /* must become NULL on failure */
    psplat_result result = psplat_renderer_create(&desc, &renderer, error);
    assert_true((result == PSPLAT_OK) == (renderer != NULL));
    if (result == PSPLAT_OK) psplat_renderer_destroy(renderer);
    return result;
}

static void set_version(const char *text, int major, int minor) {
    null_version = text;
    null_major = major;
    null_minor = minor;
}

static void test_missing_functions(void **state) {
    (void)state;
    set_version("3.3 null", 3, 3);
    null_loader all = {.fail_at = -1};
    assert_int_equal(create_null(&all, NULL), PSPLAT_OK);
    assert_true(all.calls > 50);
    for (int i = 0; i < all.calls; ++i) {
        psplat_error error = {0};
        null_loader loader = {.fail_at = i};
        assert_int_equal(create_null(&loader, &error), PSPLAT_ERROR_GRAPHICS);
        assert_int_equal(error.code, PSPLAT_ERROR_GRAPHICS);
        assert_non_null(strstr(error.text, loader.missing));
    }
}

static void test_versions(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int major, minor;
        psplat_result result;
        const char *word;
    } cases[] = {
        {NULL, 0, 0, PSPLAT_ERROR_GRAPHICS, "context"},
        {"3.2 old", 3, 2, PSPLAT_ERROR_GRAPHICS, "3.3"},
        {"2.1 older", 2, 1, PSPLAT_ERROR_GRAPHICS, "2.1 older"},
        {"4.6 new", 4, 6, PSPLAT_OK, ""},
        {"OpenGL ES 2.0 old", 2, 0, PSPLAT_ERROR_GRAPHICS, "ES 2.0"},
        {"OpenGL ES 3.0 bare", 3, 0, PSPLAT_ERROR_GRAPHICS, "GL_EXT_color_buffer_float"},
        {"OpenGL ES 3.2 new", 3, 2, PSPLAT_OK, ""},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_error error = {0};
        null_loader loader = {.fail_at = -1};
        set_version(cases[i].text, cases[i].major, cases[i].minor);
        assert_int_equal(create_null(&loader, &error), cases[i].result);
        assert_non_null(strstr(error.text, cases[i].word));
    }
}

static void test_arguments(void **state) {
    (void)state;
    psplat_renderer *renderer = NULL;
    psplat_renderer_desc none = {0};
    assert_int_equal(psplat_renderer_create(NULL, &renderer, NULL), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_renderer_create(&none, &renderer, NULL), PSPLAT_ERROR_ARGUMENT);
    psplat_renderer_destroy(NULL);
    psplat_model_destroy(NULL, NULL);
}

/* ---- a real context that pretends ------------------------------------------------------------ */

static const unsigned char *(*real_get_stringi)(unsigned name, unsigned index);

static const unsigned char *get_stringi_without_blending(unsigned name, unsigned index) {
    const unsigned char *extension = real_get_stringi(name, index);
    int hidden = extension && strcmp((const char *)extension, "GL_EXT_float_blend") == 0;
    return hidden ? (const unsigned char *)"GL_hidden" : extension;
}

static void *get_proc_without_blending(void *user, const char *name) {
    void *address = psplat_host_get_proc(user, name);
    if (strcmp(name, "glGetStringi") != 0) return address;
    memcpy(&real_get_stringi, &address, sizeof address);
    return address_of((void (*)(void))get_stringi_without_blending);
}

/* Compares pictures of a sphere whose sums have 32 and 16 bits: they are equal to half precision,
 * and the depth lies epsilon behind, which is twice the tolerance at grazing angles. */
static void compare_half(canvas *c, const psplat_renderer_desc *desc) {
    scene s = scene_sphere(200, 0.8f);
    psplat_asset *asset = scene_open(&s);
    const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_parallel(&view, 1.0, 1.0, 3.0);
    psplat_item item = {.model = canvas_model(c, asset)};
    canvas_draw(c, &view, &item, 1);
    canvas *half = calloc(1, sizeof *half);
    assert_non_null(half);
    *half = *c;
    psplat_error error = {0};
    canvas_check(psplat_renderer_create(desc, &half->renderer, &error), &error);
    psplat_item half_item = {.model = canvas_model(half, asset)};
    canvas_draw(half, &view, &half_item, 1);
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) {
        assert_true((c->color[4 * i + 3] > 0) == (half->color[4 * i + 3] > 0));
        if (c->color[4 * i + 3] == 0) continue;
        /* Half floats keep 11 bits of normals, which the light multiplies by up to about 2. */
        assert_near(c->color[4 * i], half->color[4 * i], 4e-3);
        assert_near(c->depth[i], half->depth[i], 2 * s.depth_tolerance); /* eq. (5) */
        assert_true(half->depth[i] > c->depth[i] - 1e-6f);
    }
    /* Four numbers, one number and depth: 16 + 4 + 4 bytes a pixel, and 8 + 2 + 4. */
    const size_t pixels = CANVAS_SIZE * CANVAS_SIZE;
    assert_int_equal(psplat_renderer_memory(c->renderer).targets, 24 * pixels);
    assert_int_equal(psplat_renderer_memory(half->renderer).targets, 14 * pixels);
    psplat_model_destroy(half->renderer, half_item.model);
    psplat_renderer_destroy(half->renderer);
    free(half);
    psplat_model_destroy(c->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* GLES without GL_EXT_float_blend draws into RGBA16F. */
static void test_half_targets(void **state) {
    (void)state;
    canvas *c = canvas_create(PSPLAT_API_GLES);
    compare_half(c,
                 &(psplat_renderer_desc){.get_proc = get_proc_without_blending, .user = c->host});
    canvas_destroy(c);
}

/* So does a context that can blend 32 bits, where the host wants it. */
static void test_wanted_half_targets(void **state) {
    (void)state;
    for (int api = PSPLAT_API_GL; api <= PSPLAT_API_GLES; ++api) {
        canvas *c = canvas_create((psplat_api)api);
        compare_half(c, &(psplat_renderer_desc){
                            .get_proc = psplat_host_get_proc, .user = c->host, .half_targets = 1});
        canvas_destroy(c);
    }
}

static void (*real_get_integer)(unsigned name, int *values);

static void get_integer_of_small_textures(unsigned name, int *values) {
    real_get_integer(name, values);
    if (name == 0x0D33) *values = 2048; /* GL_MAX_TEXTURE_SIZE */
}

static void *get_proc_of_small_textures(void *user, const char *name) {
    void *address = psplat_host_get_proc(user, name);
    if (strcmp(name, "glGetIntegerv") != 0) return address;
    memcpy(&real_get_integer, &address, sizeof address);
    return address_of((void (*)(void))get_integer_of_small_textures);
}

/* 2048 is the least size that GLES 3.0 guarantees; four shadow maps have to fit side by side. */
static void test_small_textures(void **state) {
    (void)state;
    canvas *c = canvas_create(PSPLAT_API_GLES);
    scene s = scene_sphere(200, 0.8f);
    psplat_asset *asset = scene_open(&s);
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){0, 0, 2}, (double[]){0, 0, 0});
    camera_parallel(&view, 1.0, 1.0, 3.0);
    view.lights[0].casts_shadow = 1;
    for (int i = 1; i < 4; ++i) view.lights[i] = view.lights[0];
    view.light_count = 4;
    psplat_renderer_desc desc = {.get_proc = get_proc_of_small_textures, .user = c->host};
    psplat_renderer *renderer = NULL;
    psplat_item item = {.model = NULL};
    psplat_error error = {0};
    canvas_check(psplat_renderer_create(&desc, &renderer, &error), &error);
    canvas_check(psplat_model_create(renderer, asset, &item.model, &error), &error);
    canvas_check(psplat_draw(renderer, &view, &item, 1, &error), &error);
    assert_int_equal(psplat_renderer_memory(renderer).shadows, 2048 * 512 * 4);
    view.shadow_size = 513;
    assert_int_equal(psplat_draw(renderer, &view, &item, 1, &error), PSPLAT_ERROR_ARGUMENT);
    psplat_model_destroy(renderer, item.model);
    psplat_renderer_destroy(renderer);
    psplat_asset_destroy(asset);
    scene_free(&s);
    canvas_destroy(c);
}

int test_gl_api_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_missing_functions),   cmocka_unit_test(test_versions),
        cmocka_unit_test(test_arguments),           cmocka_unit_test(test_half_targets),
        cmocka_unit_test(test_wanted_half_targets), cmocka_unit_test(test_small_textures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
