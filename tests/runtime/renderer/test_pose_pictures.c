/* SPDX-License-Identifier: MIT
 *
 * test_pose_pictures.c - tests that an animated asset at a time is drawn as an asset is whose nodes
 * stand in that pose: colours, depth and shadows, in one pose and in two at once.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "gl_canvas.h"
#include "moving.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static psplat_asset *open_text(char *text) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    canvas_check(psplat_asset_open_memory(text, strlen(text), NULL, &asset, &error), &error);
    free(text);
    return asset;
}

/* Two nodes, one below the other: the first turns about z by 60 degrees a second, the second moves
 * along x and grows. A third, which is at rest where the second is, stays there. */
#define STILL ",{\"mesh\":0}"

static psplat_asset *open_animated(void) {
    static const float times[] = {0, 2}, moves[] = {0, 0, 0, 2, 0, 0},
                       sizes[] = {1, 1, 1, 2, 0.5f, 1};
    static const float turns[] = {0, 0, 0, 1, 0, 0, 0.866025404f, 0.5f};
    moving m = {0};
    moving_floats(&m, times, 2, 1);
    moving_floats(&m, turns, 2, 4);
    moving_floats(&m, moves, 2, 3);
    moving_floats(&m, sizes, 2, 3);
    return open_text(
        moving_text(&m, PSPLAT_SOURCE_DIR, "{\"children\":[1,2]},{\"mesh\":0}" STILL,
                    "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}},"
                    "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"translation\"}},"
                    "{\"sampler\":2,\"target\":{\"node\":1,\"path\":\"scale\"}}],\"samplers\":["
                    "{\"input\":16,\"output\":17},{\"input\":16,\"output\":18},{\"input\":16,"
                    "\"output\":19}]}"));
}

/* Returns the asset as it stands after so many seconds of 0 ... 2. */
static psplat_asset *open_standing(double t) {
    const double half = t * 3.14159265358979323846 / 6;
    char nodes[400];
    moving m = {0};
    static const float one[] = {0};
    moving_floats(&m, one, 1, 1);
    snprintf(nodes, sizeof nodes,
             "{\"children\":[1,2],\"rotation\":[0,0,%.17g,%.17g]},"
             "{\"mesh\":0,\"translation\":[%.17g,0,0],\"scale\":[%.17g,%.17g,1]}" STILL,
             sin(half), cos(half), t, 1 + t / 2, 1 - t / 4);
    return open_text(moving_text(&m, PSPLAT_SOURCE_DIR, nodes, ""));
}

static psplat_view view_of(int has_shadows) {
    psplat_view view = {
        .view = {1, 0, 0, 0, 0, 0.8, 0.6, 0, 0, -0.6, 0.8, 0, -1, 0, -12, 1},
        .projection = {0.2, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, -0.1, 0, 0, 0, -1, 1},
        .width = CANVAS_SIZE,
        .height = CANVAS_SIZE,
        .culling = PSPLAT_CULL_NEVER,
        .ambient = {0.2f, 0.2f, 0.2f},
        .light_count = 1,
        .lights = {{.color = {2, 2, 2}, .direction = {-1, -0.5f, -1}, .casts_shadow = has_shadows}},
    };
    return view;
}

/* Asserts that pictures are equal but for rounding of the keys to floats: colours to a thousandth,
 * depth to a hundred-thousandth, except in pixels at edges, of which there are at most `few`. */
static void check_equal(const canvas *c, const canvas *expected, int few) {
    int differing = 0;
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i) {
        float most = 0;
        for (int k = 0; k < 4; ++k)
            most = fmaxf(most, fabsf(c->color[4 * i + k] - expected->color[4 * i + k]));
        differing += most > 1e-3f || fabsf(c->depth[i] - expected->depth[i]) > 1e-5f;
    }
    if (differing > few) fail_msg("%d pixels differ", differing);
    assert_true(canvas_covered(expected) > 200);
}

static int count_differing(const canvas *a, const canvas *b) {
    int count = 0;
    for (int i = 0; i < CANVAS_SIZE * CANVAS_SIZE; ++i)
        count += fabsf(a->color[4 * i] - b->color[4 * i]) > 0.02f;
    return count;
}

static void test_as_if_standing(void **state) {
    (void)state;
    canvas *c = canvas_create(PSPLAT_API_GL), *expected = calloc(1, sizeof *expected);
    assert_non_null(expected);
    psplat_asset *asset = open_animated();
    psplat_model *model = canvas_model(c, asset);
    psplat_pose *pose;
    psplat_error error = {0};
    canvas_check(psplat_pose_create(asset, &pose, &error), &error);
    for (int shadows = 0; shadows < 2; ++shadows)
        for (int i = 0; i <= 4; ++i) {
            const psplat_view view = view_of(shadows);
            psplat_asset *standing = open_standing(0.5 * i);
            psplat_model *other = canvas_model(c, standing);
            canvas_draw(c, &view, &(psplat_item){.model = other}, 1);
            *expected = *c;
            canvas_check(psplat_pose_set(pose, 0, 0.5 * i, &error), &error);
            canvas_draw(c, &view, &(psplat_item){.model = model, .pose = pose}, 1);
            check_equal(c, expected, 6);
            canvas_draw(c, &view, &(psplat_item){.model = model}, 1);
            assert_true(i == 0 || count_differing(c, expected) > 60); /* it has moved */
            psplat_model_destroy(c->renderer, other);
            psplat_asset_destroy(standing);
        }
    psplat_pose_destroy(pose);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    canvas_destroy(c);
    free(expected);
}

/* Everything moves far away, one part above the other: the shadow map follows the pose, and the
 * picture is that of the asset at rest seen from as far away. */
static void test_shadows_follow(void **state) {
    (void)state;
    static const float times[] = {0, 1}, far[] = {0, 0, 0, 64, 32, 0};
    canvas *c = canvas_create(PSPLAT_API_GL), *expected = calloc(1, sizeof *expected);
    assert_non_null(expected);
    moving m = {0};
    moving_floats(&m, times, 2, 1);
    moving_floats(&m, far, 2, 3);
    psplat_asset *asset = open_text(moving_text(
        &m, PSPLAT_SOURCE_DIR,
        "{\"children\":[1,2]},{\"mesh\":0},{\"mesh\":0,\"translation\":[0.3,0.15,0.3]}",
        "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}],"
        "\"samplers\":[{\"input\":16,\"output\":17}]}"));
    psplat_model *model = canvas_model(c, asset);
    psplat_pose *pose;
    psplat_error error = {0};
    psplat_view view = view_of(0);
    canvas_draw(c, &view, &(psplat_item){.model = model}, 1);
    *expected = *c;
    view.lights[0].casts_shadow = 1;
    canvas_draw(c, &view, &(psplat_item){.model = model}, 1);
    assert_true(count_differing(c, expected) > 20); /* there are shadows to be seen */
    *expected = *c;
    canvas_check(psplat_pose_create(asset, &pose, &error), &error);
    canvas_check(psplat_pose_set(pose, 0, 1, &error), &error);
    for (int row = 0; row < 3; ++row)
        view.view[12 + row] -= 64 * view.view[row] + 32 * view.view[4 + row];
    canvas_draw(c, &view, &(psplat_item){.model = model, .pose = pose}, 1);
    check_equal(c, expected, 6);
    psplat_pose_destroy(pose);
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    canvas_destroy(c);
    free(expected);
}

/* One model is drawn twice in one call, in two poses and at two places. */
static void test_two_poses(void **state) {
    (void)state;
    canvas *c = canvas_create(PSPLAT_API_GL), *expected = calloc(1, sizeof *expected);
    assert_non_null(expected);
    psplat_asset *asset = open_animated();
    psplat_model *model = canvas_model(c, asset);
    psplat_error error = {0};
    const psplat_view view = view_of(1);
    psplat_item items[2], standing[2];
    psplat_pose *poses[2];
    psplat_asset *assets[2];
    for (int i = 0; i < 2; ++i) {
        canvas_check(psplat_pose_create(asset, &poses[i], &error), &error);
        canvas_check(psplat_pose_set(poses[i], 0, 0.5 + i, &error), &error);
        items[i] = (psplat_item){.model = model, .pose = poses[i]};
        items[i].transform[0] = items[i].transform[5] = items[i].transform[10] = 0.7;
        items[i].transform[15] = 1;
        items[i].transform[12] = 3.0 * i - 2;
        standing[i] = items[i];
        assets[i] = open_standing(0.5 + i);
        standing[i].model = canvas_model(c, assets[i]);
        standing[i].pose = NULL;
    }
    canvas_draw(c, &view, standing, 2);
    *expected = *c;
    canvas_draw(c, &view, items, 2);
    check_equal(c, expected, 6);
    for (int i = 0; i < 2; ++i) {
        psplat_model_destroy(c->renderer, standing[i].model);
        psplat_asset_destroy(assets[i]);
        psplat_pose_destroy(poses[i]);
    }
    psplat_model_destroy(c->renderer, model);
    psplat_asset_destroy(asset);
    canvas_destroy(c);
    free(expected);
}

static void test_pose_of_another_asset(void **state) {
    (void)state;
    canvas *c = canvas_create(PSPLAT_API_GL);
    psplat_asset *asset = open_animated();
    scene disc = scene_disc(1);
    psplat_asset *other = scene_open(&disc);
    scene_free(&disc);
    psplat_model *model = canvas_model(c, asset), *small = canvas_model(c, other);
    psplat_error error = {0};
    psplat_pose *pose;
    const psplat_view view = view_of(0);
    canvas_check(psplat_pose_create(other, &pose, &error), &error);
    psplat_item item = {.model = model, .pose = pose};
    assert_int_equal(psplat_draw(c->renderer, &view, &item, 1, &error), PSPLAT_ERROR_ARGUMENT);
    assert_string_equal(error.text, "item 0 has a pose of another asset than its model");
    psplat_pose_destroy(pose);
    canvas_check(psplat_pose_create(asset, &pose, &error), &error);
    item = (psplat_item){.model = small, .pose = pose};
    assert_int_equal(psplat_draw(c->renderer, &view, &item, 1, &error), PSPLAT_ERROR_ARGUMENT);
    psplat_pose_destroy(pose);
    psplat_model_destroy(c->renderer, model);
    psplat_model_destroy(c->renderer, small);
    psplat_asset_destroy(asset);
    psplat_asset_destroy(other);
    canvas_destroy(c);
}

int test_pose_pictures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_as_if_standing),
        cmocka_unit_test(test_shadows_follow),
        cmocka_unit_test(test_two_poses),
        cmocka_unit_test(test_pose_of_another_asset),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
