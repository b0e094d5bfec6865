/* SPDX-License-Identifier: MIT
 *
 * test_item_levels.c - tests that an item at a level is drawn as a file of that level alone, pixel
 * for pixel, and the level that is chosen for a view.
 *
 * The levels are spheres on a grid whose steps are powers of two, so that the products of matrices
 * are exact and nothing may differ.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "document.h"
#include "export/glb_writer.h"
#include "export/mesh_levels.h"
#include "gl_canvas.h"
#include "reference_view.h"
#include "scene/scene.h"
#include "scene_asset.h"
#include "splats/splats.h"

#include <stdlib.h>
#include <string.h>

enum { LEVELS = 3 };
static const size_t splat_counts[LEVELS] = {400, 120, 30};

typedef struct sphere {
    scene scene;
    psplat_run run;
    psplat_material material;
    psplat_splats splats;
} sphere;

static void make_sphere(sphere *s, int level) {
    s->scene = scene_sphere(splat_counts[level], 1);
    s->material = s->scene.material;
    s->run = (psplat_run){.count = s->scene.count, .depth_tolerance = s->scene.depth_tolerance};
    s->splats = (psplat_splats){.splats = s->scene.splats,
                                .count = s->scene.count,
                                .runs = &s->run,
                                .run_count = 1,
                                .materials = &s->material,
                                .material_count = 1,
                                .kernel = s->scene.kernel,
                                .origin = {level, 0, 0.5 * level}};
}

static psplat_asset *open_glb(const psplat_splats *splats, const psplat_mesh_levels *levels) {
    const psplat_write_desc desc = {.levels = levels};
    psplat_error error = {0};
    uint8_t *data = NULL;
    size_t size;
    psplat_asset *asset = NULL;
    canvas_check(psplat_glb_write(splats, "sphere", &desc, &data, &size, &error), &error);
    canvas_check(psplat_asset_open_memory(data, size, NULL, &asset, &error), &error);
    free(data);
    return asset;
}

/* Returns an asset of all levels, with errors that grow by four. */
static psplat_asset *open_levels(sphere spheres[LEVELS]) {
    psplat_mesh_level_splats list[LEVELS] = {{.distance = 0}};
    const psplat_mesh_levels levels = {list, LEVELS};
    for (int i = 0; i < LEVELS; ++i) {
        make_sphere(&spheres[i], i);
        if (i) list[i].splats = spheres[i].splats;
        list[i].distance = i ? 0.01 * pow(4, i) : 0.01;
        list[i].normal = 5;
        list[i].outline = i ? 0.01 * pow(4, i) : 0.01;
    }
    return open_glb(&spheres[0].splats, &levels);
}

static psplat_view look(void) {
    const double eye[3] = {0.75, 0.5, 5}, target[3] = {0.5, 0, 0};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_perspective(&view, CANVAS_SIZE, 1, 20);
    return view;
}

static int open_canvas(void **state) {
    *state = canvas_create(PSPLAT_API_GL);
    return 0;
}

static int close_canvas(void **state) {
    canvas_destroy(*state);
    return 0;
}

/* ---- drawing --------------------------------------------------------------------------------- */

static void expect_level_alone(canvas *c, const psplat_view *view, const psplat_model *leveled,
                               int level) {
    static canvas before;
    sphere alone;
    make_sphere(&alone, level);
    psplat_asset *asset = open_glb(&alone.splats, NULL);
    psplat_model *model = canvas_model(c, asset);
    const psplat_item one = {.model = model};
    const psplat_item item = {.model = (psplat_model *)leveled, .level = (uint32_t)level};
    canvas_draw(c, view, &one, 1);
    before = *c;
    assert_true(canvas_covered(c) > 1000);
    canvas_draw(c, view, &item, 1);
    assert_memory_equal(c->color, before.color, sizeof before.color);
    assert_memory_equal(c->depth, before.depth, sizeof before.depth);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    scene_free(&alone.scene);
}

/* In the modes and shadings that are drawn in ways of their own, with and without shadows. */
static void test_as_alone(void **state) {
    canvas *c = *state;
    sphere spheres[LEVELS];
    psplat_asset *asset = open_levels(spheres);
    psplat_model *model = canvas_model(c, asset);
    for (int level = 0; level < LEVELS; ++level) {
        psplat_view view = look();
        expect_level_alone(c, &view, model, level);
        view.lights[0].casts_shadow = 1;
        expect_level_alone(c, &view, model, level);
        view.mode = PSPLAT_MODE_PARAMETERS;
        expect_level_alone(c, &view, model, level);
        view.mode = PSPLAT_MODE_GAUSSIAN;
        expect_level_alone(c, &view, model, level);
    }
    const psplat_model_info info = psplat_model_describe(model);
    assert_int_equal(info.level_count, LEVELS);
    assert_int_equal(info.splat_count, splat_counts[0]);
    assert_int_equal(info.batch_count, 1);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    for (int i = 0; i < LEVELS; ++i) scene_free(&spheres[i].scene);
}

/* A level that there is not is the coarsest, also of a model without levels. */
static void test_beyond_coarsest(void **state) {
    canvas *c = *state;
    static canvas before;
    sphere spheres[LEVELS];
    psplat_asset *asset = open_levels(spheres), *plain = open_glb(&spheres[0].splats, NULL);
    const psplat_view view = look();
    psplat_asset *const assets[] = {asset, plain};
    for (int i = 0; i < 2; ++i) {
        psplat_model *model = canvas_model(c, assets[i]);
        psplat_item item = {.model = model, .level = i ? 0 : LEVELS - 1};
        canvas_draw(c, &view, &item, 1);
        before = *c;
        item.level = UINT32_MAX;
        canvas_draw(c, &view, &item, 1);
        assert_memory_equal(c->color, before.color, sizeof before.color);
        psplat_model_destroy(c->renderer, model);
    }
    psplat_asset_destroy(asset);
    psplat_asset_destroy(plain);
    for (int i = 0; i < LEVELS; ++i) scene_free(&spheres[i].scene);
}

/* Two levels of a model that fade into each other are drawn as two files would be. */
static void test_cross_fade(void **state) {
    canvas *c = *state;
    static canvas before;
    sphere spheres[LEVELS], alone[2];
    psplat_asset *asset = open_levels(spheres), *apart[2];
    psplat_model *model = canvas_model(c, asset), *models[2];
    for (int i = 0; i < 2; ++i) {
        make_sphere(&alone[i], i + 1);
        apart[i] = open_glb(&alone[i].splats, NULL);
        models[i] = canvas_model(c, apart[i]);
    }
    psplat_view view = look();
    for (int shadows = 0; shadows < 2; ++shadows)
        for (float fade = 0.25f; fade < 1; fade += 0.25f) {
            const psplat_item two[] = {{.model = models[0], .fade = fade},
                                       {.model = models[1], .fade = 1 - fade}};
            const psplat_item one[] = {{.model = model, .level = 1, .fade = fade},
                                       {.model = model, .level = 2, .fade = 1 - fade}};
            view.lights[0].casts_shadow = shadows;
            canvas_draw(c, &view, two, 2);
            before = *c;
            assert_true(canvas_covered(c) > 1000);
            canvas_draw(c, &view, one, 2);
            assert_memory_equal(c->color, before.color, sizeof before.color);
            assert_memory_equal(c->depth, before.depth, sizeof before.depth);
        }
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(c->renderer, models[i]);
        psplat_asset_destroy(apart[i]);
        scene_free(&alone[i].scene);
    }
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    for (int i = 0; i < LEVELS; ++i) scene_free(&spheres[i].scene);
}

/* Opens schema/levels.gltf, whose levels have scales and translations of their own, with an
 * animation of its node: a half turn about z, and a move by (1/2, 1/4, -1/2), from 0 to 1 second.
 */
static psplat_asset *open_moving_levels(void) {
    size_t size;
    char *text = document_read(PSPLAT_SOURCE_DIR "/schema/levels.gltf", &size);
    document_replace(
        &text, "\"nodes\": [\n",
        "\"animations\": [{\"channels\": ["
        "{\"sampler\": 0, \"target\": {\"node\": 0, \"path\": \"translation\"}},"
        "{\"sampler\": 1, \"target\": {\"node\": 0, \"path\": \"rotation\"}}],"
        "\"samplers\": [{\"input\": 12, \"output\": 13}, {\"input\": 12, \"output\": 14}]}],"
        "\"nodes\": [");
    document_replace(
        &text, "\n  ],\n  \"bufferViews\": [",
        ",{\"bufferView\": 3, \"byteOffset\": 0, \"componentType\": 5126, \"count\": 2,"
        "\"type\": \"SCALAR\", \"min\": [0], \"max\": [1]},"
        "{\"bufferView\": 3, \"byteOffset\": 8, \"componentType\": 5126, \"count\": 2,"
        "\"type\": \"VEC3\"},"
        "{\"bufferView\": 3, \"byteOffset\": 32, \"componentType\": 5126, \"count\": 2,"
        "\"type\": \"VEC4\"}],\"bufferViews\": [");
    document_replace(&text, "\n  ],\n  \"buffers\": [",
                     ",{\"buffer\": 1, \"byteLength\": 64}],\"buffers\": [");
    document_replace(&text, "\n    }\n  ]\n}",
                     "},{\"byteLength\": 64, \"uri\": \"data:application/octet-stream;base64,"
                     "AAAAAAAAgD8AAAAAAAAAAAAAAAAAAAA/AACAPgAAAL8AAAAAAAAAAAAAAAAAAIA/"
                     "AAAAAAAAAAAAAIA/AAAAAA==\"}]}");
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    canvas_check(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error), &error);
    free(text);
    return asset;
}

/* Returns how many pixels differ by more than the rounding of matrices does, but at edges. */
static int count_differing(const canvas *a, const canvas *b) {
    int count = 0;
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i)
        count += fabsf(a->color[4 * i] - b->color[4 * i]) > 1e-3f ||
                 fabsf(a->depth[i] - b->depth[i]) > 1e-5f;
    return count;
}

/* Every level of an item in a pose stands where a transform of the item would have put it. */
static void test_in_a_pose(void **state) {
    canvas *c = *state;
    static canvas at_rest, moved;
    psplat_asset *asset = open_moving_levels();
    psplat_model *model = canvas_model(c, asset);
    psplat_pose *pose;
    psplat_error error = {0};
    canvas_check(psplat_pose_create(asset, &pose, &error), &error);
    canvas_check(psplat_pose_set(pose, 0, 1, &error), &error);
    psplat_view view = look();
    view.culling = PSPLAT_CULL_NEVER;
    for (uint32_t level = 0; level < 3; ++level) {
        psplat_item item = {.model = model, .level = level};
        canvas_draw(c, &view, &item, 1);
        at_rest = *c;
        const double turned[16] = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0.5, 0.25, -0.5, 1};
        memcpy(item.transform, turned, sizeof turned);
        canvas_draw(c, &view, &item, 1);
        moved = *c;
        assert_true(canvas_covered(c) > 200);
        item = (psplat_item){.model = model, .level = level, .pose = pose};
        canvas_draw(c, &view, &item, 1);
        assert_in_range(count_differing(c, &moved), 0, 6);
        assert_true(count_differing(c, &at_rest) > 60);
    }
    psplat_pose_destroy(pose);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
}

/* ---- choosing -------------------------------------------------------------------------------- */

/* The box of the model is that of the finest sphere: its sides are a little more than 2. */
typedef struct chooser {
    canvas *canvas;
    sphere spheres[LEVELS];
    psplat_asset *asset;
    psplat_model *model;
} chooser;

static int open_chooser(void **state) {
    chooser *c = calloc(1, sizeof *c);
    c->canvas = canvas_create(PSPLAT_API_GL);
    c->asset = open_levels(c->spheres);
    c->model = canvas_model(c->canvas, c->asset);
    *state = c;
    return 0;
}

static int close_chooser(void **state) {
    chooser *c = *state;
    psplat_model_destroy(c->canvas->renderer, c->model);
    psplat_asset_destroy(c->asset);
    for (int i = 0; i < LEVELS; ++i) scene_free(&c->spheres[i].scene);
    canvas_destroy(c->canvas);
    free(c);
    return 0;
}

/* Returns a view along -z of the front of the model's box from so far; 1 unit there is focal /
 * distance pixels. */
static psplat_view from_afar(const chooser *c, double distance, double focal) {
    double min[3], max[3];
    psplat_asset_bounds(c->asset, min, max);
    const double eye[3] = {0, 0, max[2] + distance}, target[3] = {0, 0, max[2] + distance - 1};
    psplat_view view = camera_view(CANVAS_SIZE, CANVAS_SIZE);
    camera_look(&view, eye, target);
    camera_perspective(&view, focal, 0.01 * distance, 100 * distance);
    return view;
}

static uint32_t choose(const chooser *c, const psplat_view *view, double scale,
                       const psplat_level_choice *choice) {
    const double transform[16] = {scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1};
    return psplat_model_choose_level(c->model, view, scale == 1 ? NULL : transform, choice);
}

/* Errors of levels 1 and 2 are 0.04 and 0.16 scene units, of the outline, at 5 degrees: at 100
 * pixels a unit 4 and 16 pixels. The nearest point of the box counts. */
static void test_choice(void **state) {
    const chooser *c = *state;
    psplat_view view = from_afar(c, 10, 1000);
    assert_int_equal(choose(c, &view, 1, &(psplat_level_choice){.tau = 3.99}), 0);
    assert_int_equal(choose(c, &view, 1, &(psplat_level_choice){.tau = 4.01}), 1);
    assert_int_equal(choose(c, &view, 1, &(psplat_level_choice){.tau = 15.9}), 1);
    assert_int_equal(choose(c, &view, 1, &(psplat_level_choice){.tau = 16.1}), 2);
    /* The default is half a pixel. */
    view = from_afar(c, 10, 124);
    assert_int_equal(choose(c, &view, 1, NULL), 1);
    view = from_afar(c, 10, 126);
    assert_int_equal(choose(c, &view, 1, NULL), 0);
    const psplat_level far_off = {.distance = 2, .normal = 5, .outline = 0.25};
    assert_true(psplat_level_error(&far_off, 10) == 5);
    const psplat_level rough = {.distance = 2, .normal = 20, .outline = 0.25};
    assert_float_equal(psplat_level_error(&rough, 10), 20, 1e-12);
}

static void test_choice_orthographic(void **state) {
    const chooser *c = *state;
    for (double distance = 1; distance < 1e6; distance *= 100) {
        psplat_view view = from_afar(c, distance, 1);
        camera_parallel(&view, 0.5 * CANVAS_SIZE / 100, 0.01, 2e6); /* 100 pixels a unit */
        assert_int_equal(choose(c, &view, 1, &(psplat_level_choice){.tau = 3.99}), 0);
        assert_int_equal(choose(c, &view, 1, &(psplat_level_choice){.tau = 4.01}), 1);
    }
}

static void test_choice_at_extremes(void **state) {
    const chooser *c = *state;
    const psplat_level_choice large = {.tau = 1e9};
    psplat_view view = from_afar(c, -1, 100); /* the eye is inside the box */
    assert_int_equal(choose(c, &view, 1, &large), 0);
    const double eye[3] = {0, 0, 50}, away[3] = {0, 0, 51};
    camera_look(&view, eye, away); /* all is behind it */
    assert_int_equal(choose(c, &view, 1, NULL), LEVELS - 1);
    /* A thing a millionth as large from a millionth as far looks the same. */
    double min[3], max[3];
    psplat_asset_bounds(c->asset, min, max);
    for (double scale = 1e-6; scale < 1e7; scale *= 1e3) {
        const double near[3] = {0, 0, scale * (max[2] + 10)}, origin[3] = {0, 0, 0};
        view = from_afar(c, 10, 1000);
        camera_look(&view, near, origin);
        assert_int_equal(choose(c, &view, scale, &(psplat_level_choice){.tau = 3.99}), 0);
        assert_int_equal(choose(c, &view, scale, &(psplat_level_choice){.tau = 4.01}), 1);
    }
    view = from_afar(c, 10, 1000);
    assert_int_equal(choose(c, &view, 1e-6, NULL), LEVELS - 1);
    const double point[16] = {[15] = 1}; /* singular: nothing is drawn */
    assert_int_equal(psplat_model_choose_level(c->model, &view, point, NULL), LEVELS - 1);
    assert_int_equal(psplat_model_choose_level(NULL, &view, NULL, NULL), 0);
}

/* A stretch along one axis counts as much as along all; a turn and a mirror count nothing. */
static void test_choice_stretched(void **state) {
    const chooser *c = *state;
    psplat_view view = from_afar(c, 1e6, 1e7); /* 10 pixels a unit, wherever in the box */
    const double stretched[16] = {0, 10, 0, 0, -0.1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const psplat_level_choice fine = {.tau = 3.99}, coarse = {.tau = 4.01};
    assert_int_equal(psplat_model_choose_level(c->model, &view, stretched, &fine), 0);
    assert_int_equal(psplat_model_choose_level(c->model, &view, stretched, &coarse), 1);
    const double mirrored[16] = {-1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
    assert_int_equal(
        psplat_model_choose_level(c->model, &view, mirrored, &(psplat_level_choice){.tau = 0.39}),
        0);
    assert_int_equal(
        psplat_model_choose_level(c->model, &view, mirrored, &(psplat_level_choice){.tau = 0.41}),
        1);
}

/* With hysteresis a level stays until it errs by more than tau, and comes back below 90 % of it. */
static void test_hysteresis(void **state) {
    const chooser *c = *state;
    psplat_view view = from_afar(c, 10, 1000);
    psplat_level_choice choice = {.tau = 4.2, .hysteresis = 0.1, .current = 0};
    assert_int_equal(choose(c, &view, 1, &choice), 0);
    choice.current = 1;
    assert_int_equal(choose(c, &view, 1, &choice), 1);
    choice = (psplat_level_choice){.tau = 4.5, .hysteresis = 0.1, .current = 0};
    assert_int_equal(choose(c, &view, 1, &choice), 1);
    choice = (psplat_level_choice){.tau = 3.9, .hysteresis = 0.1, .current = 1};
    assert_int_equal(choose(c, &view, 1, &choice), 0);
    choice = (psplat_level_choice){.tau = 4.2, .current = 0};
    assert_int_equal(choose(c, &view, 1, &choice), 1);
}

int test_item_levels_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_as_alone, open_canvas, close_canvas),
        cmocka_unit_test_setup_teardown(test_beyond_coarsest, open_canvas, close_canvas),
        cmocka_unit_test_setup_teardown(test_cross_fade, open_canvas, close_canvas),
        cmocka_unit_test_setup_teardown(test_in_a_pose, open_canvas, close_canvas),
        cmocka_unit_test_setup_teardown(test_choice, open_chooser, close_chooser),
        cmocka_unit_test_setup_teardown(test_choice_orthographic, open_chooser, close_chooser),
        cmocka_unit_test_setup_teardown(test_choice_at_extremes, open_chooser, close_chooser),
        cmocka_unit_test_setup_teardown(test_choice_stretched, open_chooser, close_chooser),
        cmocka_unit_test_setup_teardown(test_hysteresis, open_chooser, close_chooser),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
