/* SPDX-License-Identifier: MIT
 *
 * test_tile_pictures.c - tests tiles with GL: what they take there, and that a picture of tiles is
 * that of the same models as items.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <stdlib.h>
#include <cmocka.h>

#include "tiles_fixture.h"
#include "gl_canvas.h"

/* ---- a tileset of spheres ----------------------------------------------------------------------
 */

/* The root is a sphere of few splats; its two children are smaller ones side by side, placed by
 * their transforms, the second stretched. */
static const char spheres[] =
    "{\"asset\":{\"version\":\"1.1\"},\"geometricError\":1,\"root\":{\"refine\":\"REPLACE\","
    "\"geometricError\":0.2,\"boundingVolume\":{\"sphere\":[0,0,0,2]},"
    "\"content\":{\"uri\":\"coarse.glb\"},\"children\":["
    "{\"geometricError\":0.01,\"boundingVolume\":{\"sphere\":[0,0,0,1.2]},"
    "\"transform\":[1,0,0,0, 0,1,0,0, 0,0,1,0, -0.6,0,0,1],\"content\":{\"uri\":\"fine.glb\"}},"
    "{\"geometricError\":0.01,\"boundingVolume\":{\"sphere\":[0,0,0,1.2]},"
    "\"transform\":[0.5,0,0,0, 0,0.5,0,0, 0,0,1,0, 0.9,0.2,-0.3,1],"
    "\"contents\":[{\"uri\":\"fine.glb\"},{\"uri\":\"cube.glb\"}]}]}}";

typedef struct stage {
    canvas *canvas;
    world w;
    uint8_t *glbs[3];
    size_t sizes[3];
} stage;

static const char *const names[3] = {"coarse.glb", "fine.glb", "cube.glb"};

static int set_up(void **state) {
    stage *s = calloc(1, sizeof *s);
    assert_non_null(s);
    s->canvas = canvas_create(PSPLAT_API_GL);
    scene scenes[3] = {scene_sphere(100, 1), scene_sphere(3000, 0.8f), scene_cube(0.5f)};
    for (int i = 0; i < 3; ++i) {
        scenes[i].material.base_color[i] = 0.3f;
        s->glbs[i] = scene_glb(&scenes[i], &s->sizes[i]);
        scene_free(&scenes[i]);
    }
    text_put(world_add_file(&s->w, "tileset.json"), "%s", spheres);
    *state = s;
    return 0;
}

static int tear_down(void **state) {
    stage *s = *state;
    world_free(&s->w);
    for (int i = 0; i < 3; ++i) free(s->glbs[i]);
    canvas_destroy(s->canvas);
    free(s);
    return 0;
}

static psplat_tiles *open_spheres(stage *s, size_t max_bytes) {
    psplat_error error = {0};
    psplat_tiles *tiles = NULL;
    const psplat_tiles_desc desc = {
        .source = {.read = world_read, .user = &s->w}, .max_bytes = max_bytes, .fade_seconds = 1};
    canvas_check(psplat_tiles_open(&desc, "dir/tileset.json", &tiles, &error), &error);
    return tiles;
}

static size_t supply_all(const stage *s, psplat_tiles *tiles) {
    psplat_tile_request requests[8];
    size_t count = psplat_tiles_wanted(tiles, requests, 8);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            if (strcmp(requests[i].path, names[k])) continue;
            psplat_error error = {0};
            canvas_check(
                psplat_tiles_supply(tiles, requests[i].tile, s->glbs[k], s->sizes[k], &error),
                &error);
        }
    return count;
}

static psplat_view look(void) {
    psplat_view view = {.width = CANVAS_SIZE,
                        .height = CANVAS_SIZE,
                        .light_count = 1,
                        .lights = {{.color = {3, 3, 3}, .direction = {-1, -2, -3}}},
                        .ambient = {0.1f, 0.1f, 0.1f}};
    view_perspective(&view, 0.5, 0.1, 100);
    view_look_at(&view, (double[]){1, 2, 5}, (double[]){0, 0, 0});
    return view;
}

static void settle(stage *s, psplat_tiles *tiles, const psplat_tiles_view *v) {
    psplat_error error = {0};
    for (int i = 0; i < 5; ++i) {
        canvas_check(psplat_tiles_select(tiles, v, &error), &error);
        supply_all(s, tiles);
        canvas_check(psplat_tiles_upload(tiles, s->canvas->renderer, SIZE_MAX, &error), &error);
    }
}

/* ---- tests -------------------------------------------------------------------------------------
 */

/* The bytes that are taken before a model is made are those that it has then. */
static void test_bytes(void **state) {
    stage *s = *state;
    for (int kind = 0; kind < 6; ++kind) {
        scene scene = kind < 3 ? scene_sphere(700, 1) : scene_ellipses(900, 4, 5);
        scene.has_color = kind % 3 > 0;
        if (kind == 2) scene_curve(&scene);
        psplat_asset *full = scene_open(&scene);
        size_t size = 0;
        uint8_t *glb = scene_glb(&scene, &size);
        psplat_asset *asset = NULL;
        const psplat_asset_desc desc = {.only_draws = 1};
        assert_int_equal(psplat_asset_open_memory(glb, size, &desc, &asset, NULL), PSPLAT_OK);
        psplat_model *model = canvas_model(s->canvas, asset);
        assert_int_equal(psplat_tile_model_bytes(asset), psplat_model_describe(model).bytes);
        assert_int_equal(psplat_tile_model_bytes(full), psplat_model_describe(model).bytes);
        psplat_model_destroy(s->canvas->renderer, model);
        psplat_asset_destroy(asset);
        psplat_asset_destroy(full);
        free(glb);
        scene_free(&scene);
    }
}

/* All levels of detail of a file are uploaded, and counted. */
static void test_bytes_of_levels(void **state) {
    stage *s = *state;
    psplat_asset *asset = NULL;
    assert_int_equal(psplat_asset_open(PSPLAT_SOURCE_DIR "/schema/levels.gltf", NULL, &asset, NULL),
                     PSPLAT_OK);
    assert_true(psplat_asset_level_count(asset) > 1);
    psplat_model *model = canvas_model(s->canvas, asset);
    assert_int_equal(psplat_tile_model_bytes(asset), psplat_model_describe(model).bytes);
    psplat_model_destroy(s->canvas->renderer, model);
    psplat_asset_destroy(asset);
}

/* From far away the root is drawn, from nearby its children, just as these files as items. */
static void test_pictures(void **state) {
    stage *s = *state;
    psplat_tiles *tiles = open_spheres(s, 0);
    psplat_view view = look();
    psplat_tiles_view v = {.view = &view, .pixels = 100};
    size_t count = 0;
    settle(s, tiles, &v);
    const psplat_item *items = psplat_tiles_items(tiles, &count);
    assert_int_equal(count, 1);
    canvas_draw(s->canvas, &view, items, count);
    int coarse = canvas_covered(s->canvas);
    assert_true(coarse > 500);
    v.pixels = 1;
    settle(s, tiles, &v);
    v.seconds = 10; /* whatever fades is done */
    canvas_check(psplat_tiles_select(tiles, &v, NULL), NULL);
    items = psplat_tiles_items(tiles, &count);
    assert_int_equal(count, 3);
    canvas_draw(s->canvas, &view, items, count);
    float *picture = malloc(sizeof s->canvas->color);
    assert_non_null(picture);
    memcpy(picture, s->canvas->color, sizeof s->canvas->color);
    /* The same files, placed with y up. */
    psplat_asset *assets[2];
    psplat_item own[3] = {0};
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(
            psplat_asset_open_memory(s->glbs[i + 1], s->sizes[i + 1], NULL, &assets[i], NULL),
            PSPLAT_OK);
        own[i + 1].model = canvas_model(s->canvas, assets[i]);
    }
    own[0].model = own[1].model;
    const double first[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -0.6, 0, 0, 1};
    const double second[16] = {0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.5, 0, 0.9, -0.3, -0.2, 1};
    memcpy(own[0].transform, first, sizeof first);
    for (int i = 1; i < 3; ++i) memcpy(own[i].transform, second, sizeof second);
    canvas_draw(s->canvas, &view, own, 3);
    assert_memory_equal(picture, s->canvas->color, sizeof s->canvas->color);
    assert_int_not_equal(canvas_covered(s->canvas), coarse);
    free(picture);
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(s->canvas->renderer, own[i + 1].model);
        psplat_asset_destroy(assets[i]);
    }
    psplat_tiles_destroy(tiles, s->canvas->renderer);
    assert_int_equal(psplat_renderer_memory(s->canvas->renderer).models, 0);
}

/* While tiles fade no pixel of either is missing, and in the end the picture is that of the new
 * ones. */
static void test_fading_pictures(void **state) {
    stage *s = *state;
    psplat_tiles *tiles = open_spheres(s, 0);
    psplat_view view = look();
    psplat_tiles_view v = {.view = &view, .pixels = 1, .seconds = 5};
    int faded = 0;
    settle(s, tiles, &v);
    v.seconds = 10; /* the root has faded out */
    canvas_check(psplat_tiles_select(tiles, &v, NULL), NULL);
    v.pixels = 100;
    for (int i = 0; i <= 12; ++i) {
        v.seconds = 10 + 0.1 * i;
        size_t count = 0;
        canvas_check(psplat_tiles_select(tiles, &v, NULL), NULL);
        const psplat_item *items = psplat_tiles_items(tiles, &count);
        assert_int_equal(count, i == 0 ? 3 : i < 10 ? 4 : 1);
        for (size_t k = 0; k < count; ++k) faded += items[k].fade > 0;
        canvas_draw(s->canvas, &view, items, count);
        assert_true(canvas_covered(s->canvas) > 500);
    }
    assert_int_equal(faded, 9 * 4);
    size_t count = 0;
    psplat_tiles_items(tiles, &count);
    assert_int_equal(count, 1);
    psplat_tiles_destroy(tiles, s->canvas->renderer);
}

/* With room for the root alone the root is drawn, and GL has no more than that. */
static void test_little_room(void **state) {
    stage *s = *state;
    const size_t max_bytes = 200000;
    psplat_tiles *tiles = open_spheres(s, max_bytes);
    psplat_view view = look();
    const psplat_tiles_view v = {.view = &view, .pixels = 1};
    for (int i = 0; i < 40; ++i) {
        psplat_tile_request requests[8];
        psplat_error error = {0};
        canvas_check(psplat_tiles_select(tiles, &v, &error), &error);
        size_t count = psplat_tiles_wanted(tiles, requests, 8);
        for (size_t k = 0; k < count; ++k) {
            int which = !strcmp(requests[k].path, names[0]) ? 0 : 1;
            psplat_tiles_supply(tiles, requests[k].tile, s->glbs[which], s->sizes[which], NULL);
        }
        canvas_check(psplat_tiles_upload(tiles, s->canvas->renderer, SIZE_MAX, &error), &error);
        assert_true(psplat_renderer_memory(s->canvas->renderer).models <= max_bytes);
    }
    psplat_tiles_state state_now = psplat_tiles_describe(tiles);
    assert_int_equal(state_now.drawn, 1);
    assert_int_equal(state_now.over_budget + state_now.missing, 1);
    assert_int_equal(state_now.bytes, psplat_renderer_memory(s->canvas->renderer).models);
    psplat_tiles_destroy(tiles, s->canvas->renderer);
}

int test_tile_pictures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bytes),       cmocka_unit_test(test_bytes_of_levels),
        cmocka_unit_test(test_pictures),    cmocka_unit_test(test_fading_pictures),
        cmocka_unit_test(test_little_room),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
