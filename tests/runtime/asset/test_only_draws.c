/* SPDX-License-Identifier: MIT
 *
 * test_only_draws.c - tests assets that are opened only for drawing: they give the same pixels as
 * other assets and take less memory.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "reference_view.h"
#include "gl_canvas.h"
#include "packed.h"
#include "scene_asset.h"

#include <stdlib.h>

/* ---- an allocator that counts, and fails when told to --------------------------------------- */

typedef struct counter {
    size_t calls, fail_at; /* fail_at 0: no call fails */
    size_t bytes, peak;
} counter;

static void *resize_counted(void *user, void *memory, size_t old_size, size_t new_size) {
    counter *c = user;
    if (new_size > old_size && ++c->calls == c->fail_at) return NULL;
    c->bytes += new_size;
    c->bytes -= old_size;
    if (c->bytes > c->peak) c->peak = c->bytes;
    if (new_size) return realloc(memory, new_size);
    free(memory);
    return NULL;
}

static psplat_asset *open_as(const void *data, size_t size, int only_draws, counter *c) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    psplat_asset_desc desc = {.only_draws = only_draws};
    if (c) desc.allocator = (psplat_allocator){resize_counted, c};
    psplat_result result = psplat_asset_open_memory(data, size, &desc, &asset, &error);
    if (!c || !c->fail_at) canvas_check(result, &error);
    assert_int_equal(asset == NULL, result != PSPLAT_OK);
    return asset;
}

/* ---- the same pixels ------------------------------------------------------------------------ */

static psplat_view view_of(void) {
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 100, 0.3, 10);
    for (int i = 0; i < 3; ++i) view.ambient[i] = 0.2f;
    return view;
}

/* Opens data in both ways and draws it: every bit of the pictures must be equal, and so must the
 * models' sizes and bounds. */
static void check_bytes(canvas *c, const void *data, size_t size) {
    static float color[CANVAS_SIZE * CANVAS_SIZE * 4], depth[CANVAS_SIZE * CANVAS_SIZE];
    psplat_view view = view_of();
    psplat_model_info info = {0};
    for (int only_draws = 0; only_draws < 2; ++only_draws) {
        psplat_asset *asset = open_as(data, size, only_draws, NULL);
        const psplat_batch *batch = psplat_asset_batch(asset, 0);
        assert_int_equal(batch->splats == NULL, only_draws);
        psplat_item item = {.model = canvas_model(c, asset)};
        psplat_asset_destroy(asset);
        canvas_draw(c, &view, &item, 1);
        psplat_model_info here = psplat_model_describe(item.model);
        psplat_model_destroy(c->renderer, item.model);
        if (!only_draws) {
            assert_true(canvas_covered(c) > 500);
            memcpy(color, c->color, sizeof color);
            memcpy(depth, c->depth, sizeof depth);
            info = here;
        }
        assert_memory_equal(color, c->color, sizeof color);
        assert_memory_equal(depth, c->depth, sizeof depth);
        assert_memory_equal(&info, &here, sizeof info);
    }
}

static void check_scene(canvas *c, const scene *s) {
    size_t size = 0;
    uint8_t *data = scene_glb(s, &size);
    check_bytes(c, data, size);
    free(data);
}

/* Some rows of 512 splats and chunks of 256 are full and some are not. */
static void test_same_pixels(void **state) {
    (void)state;
    static const size_t counts[] = {1, 255, 256, 257, 511, 512, 513, 1300};
    canvas *c = canvas_create(PSPLAT_API_GL);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        scene s = counts[i] == 1 ? scene_disc(1) : scene_sphere(counts[i], 1);
        check_scene(c, &s);
        scene_free(&s);
    }
    scene s = scene_ellipses(2600, 4, 5); /* coloured; each number of lines takes more than a row */
    check_scene(c, &s);
    scene_free(&s);
    canvas_destroy(c);
}

static void test_finishes(void **state) {
    (void)state;
    enum { COUNT = 300 };
    static double position[3 * COUNT], normal[3 * COUNT], rotation[4 * COUNT], scale[2 * COUNT];
    static double varied[4][3 * COUNT];
    uint32_t random = 3;
    for (size_t i = 0; i < COUNT; ++i) {
        for (size_t k = 0; k < 3; ++k) {
            position[3 * i + k] = 2 * (double)scene_random(&random) - 1;
            for (size_t j = 0; j < 4; ++j) varied[j][3 * i + k] = (double)scene_random(&random);
        }
        position[2] = -1; /* the extent is 2 in each direction */
        normal[3 * i + 2] = rotation[4 * i + 3] = 1;
        scale[2 * i] = scale[2 * i + 1] = 0.2;
    }
    for (size_t k = 0; k < 3; ++k) {
        position[k] = -1;
        position[3 + k] = 1;
    }
    packed p = {.count = COUNT,
                .attributes = {{"POSITION", PACKED_FLOAT, 3, 0, position},
                               {"NORMAL", PACKED_FLOAT, 3, 0, normal},
                               {"ROTATION", PACKED_FLOAT, 4, 0, rotation},
                               {"SCALE", PACKED_FLOAT, 2, 0, scale},
                               {"EMISSIVE", PACKED_FLOAT, 3, 0, varied[0]},
                               {"OCCLUSION_ROUGHNESS_METALLIC", PACKED_FLOAT, 3, 0, varied[1]},
                               {"COLOR_U", PACKED_FLOAT, 3, 0, varied[2]},
                               {"COLOR_V", PACKED_FLOAT, 3, 0, varied[3]}},
                .extension = "\"version\":2,\"clipLines\":0,\"depthTolerance\":0.01,"
                             "\"positionExtent\":[2,2,2]",
                .material = "{\"emissiveFactor\":[1,1,1]}"};
    char *text = packed_text(&p);
    canvas *c = canvas_create(PSPLAT_API_GL);
    check_bytes(c, text, strlen(text));
    canvas_destroy(c);
    free(text);
}

/* ---- memory --------------------------------------------------------------------------------- */

/* A splat takes 48 bytes instead of 164, a chunk of 256 takes 32, and the rest is what every asset
 * has. */
static void test_memory(void **state) {
    (void)state;
    scene s = scene_sphere(20000, 1);
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    for (int only_draws = 0; only_draws < 2; ++only_draws) {
        counter c = {0};
        psplat_asset *asset = open_as(data, size, only_draws, &c);
        size_t each = only_draws ? 49 : 164;
        assert_in_range(c.bytes, 20000 * (each - 1), 20000 * each + 8192);
        psplat_asset_destroy(asset);
        assert_int_equal(c.bytes, 0);
    }
    free(data);
    scene_free(&s);
}

static void test_out_of_memory(void **state) {
    (void)state;
    scene s = scene_ellipses(20, 2, 1);
    size_t size = 0, failures = 0;
    uint8_t *data = scene_glb(&s, &size);
    for (;; ++failures) {
        counter c = {.fail_at = failures + 1};
        psplat_asset *asset = open_as(data, size, 1, &c);
        psplat_asset_destroy(asset);
        assert_int_equal(c.bytes, 0);
        if (asset) break;
    }
    /* Each of three primitives takes three or four blocks, the rest of the asset the others. */
    assert_true(failures > 20);
    free(data);
    scene_free(&s);
}

/* The reference rasteriser has no splats to draw. */
static void test_reference(void **state) {
    (void)state;
    scene s = scene_disc(1);
    size_t size = 0;
    uint8_t *data = scene_glb(&s, &size);
    psplat_asset *asset = open_as(data, size, 1, NULL);
    psplat_view view = view_of();
    psplat_reference_scene all = {.asset = asset};
    psplat_reference_image image = {0};
    assert_int_equal(psplat_reference_draw(&all, &view, &image, NULL), PSPLAT_ERROR_ARGUMENT);
    psplat_asset_destroy(asset);
    free(data);
    scene_free(&s);
}

int test_only_draws_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_pixels),   cmocka_unit_test(test_finishes),
        cmocka_unit_test(test_memory),        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
