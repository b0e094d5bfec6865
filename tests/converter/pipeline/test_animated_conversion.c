/* SPDX-License-Identifier: MIT
 *
 * test_animated_conversion.c - tests that the splats of an animated scene are where its meshes are:
 * samples/models/clockwork.glb is converted, opened and posed, and what each batch has moved by
 * since rest is compared with angles and parabolas that clockwork.c says.
 */
#include "gltf_fixture.h"
#include "export/glb_writer.h"
#include "export/meshopt_codec.h"
#include "import/read_scene.h"
#include "pipeline/convert_scene.h"
#include "scene/scene.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static psplat_asset *convert_clockwork(const psplat_codec *codec) {
    psplat_scene scene;
    psplat_splats splats[4] = {{0}};
    psplat_error error = {0};
    const psplat_convert_desc desc = {
        .tolerance_percent = 5, .effort = 0, .precision = PSPLAT_USUAL_PRECISION};
    if (psplat_scene_read(PSPLAT_SOURCE_DIR "/samples/models/clockwork.glb", NULL, &scene, &error))
        fail_msg("%s", error.text);
    assert_int_equal(scene.mesh_count, 4);
    assert_int_equal(scene.warning_count, 0);
    psplat_scene_report report;
    if (psplat_scene_convert(&scene, &desc, splats, &report, &error)) fail_msg("%s", error.text);
    const psplat_write_desc write = {.codec = codec};
    uint8_t *data = NULL;
    size_t size = 0;
    if (psplat_scene_write(&scene, splats, &write, &data, &size, &error))
        fail_msg("%s", error.text);
    psplat_asset *asset = NULL;
    if (psplat_asset_open_memory(data, size, NULL, &asset, &error)) fail_msg("%s", error.text);
    psplat_scene_splats_free(&scene, splats);
    psplat_scene_report_free(&report);
    psplat_scene_free(&scene);
    free(data);
    return asset;
}

/* Where a point of a part goes, in place. */
static void turn(double p[3], int axis, double degrees, const double about[3]) {
    int a = (axis + 1) % 3, b = (axis + 2) % 3;
    double c = cos(degrees * pi / 180), s = sin(degrees * pi / 180);
    double x = p[a] - about[a], y = p[b] - about[b];
    p[a] = about[a] + c * x - s * y;
    p[b] = about[b] + s * x + c * y;
}

typedef enum part { STAND, PENDULUM, HAND, BALL } part;

static void tick(part moved, double t, double p[3]) {
    static const double pivot[3] = {-0.7, 1, 0}, hub[3] = {0.6, 0.7, 0};
    int i = (int)(t / 0.25);
    double f = t / 0.25 - i;
    double from = 25 * sin(pi * 0.25 * i), to = 25 * sin(pi * 0.25 * (i + 1));
    if (moved == PENDULUM) turn(p, 2, from + f * (to - from), pivot);
    if (moved == HAND) turn(p, 2, -45.0 * i, hub);
}

/* The parabola of a throw by 1.2 within half a second, and the squashing at its ends. */
static void bounce(part moved, double t, double p[3]) {
    double s = t < 0.5 ? t : 1 - t, squash = t < 0.125   ? t / 0.125
                                             : t > 0.875 ? (1 - t) / 0.125
                                                         : 1;
    double height = -1.25 + 1.2 * (1 - (1 - 2 * s) * (1 - 2 * s));
    if (moved != BALL) return;
    p[0] = 0.6 + (p[0] - 0.6) * (1.2 - 0.2 * squash);
    p[1] = height + (p[1] + 1.25) * (0.8 + 0.2 * squash);
    p[2] *= 1.2 - 0.2 * squash;
}

static void turn_all(part moved, double t, double p[3]) {
    static const double origin[3] = {0, 0, 0};
    (void)moved;
    turn(p, 1, 90 * t, origin);
}

/* Tells the part of a batch by its colour and place; see clockwork.c. */
static part part_of(const psplat_batch *batch) {
    float red = batch->material.base_color[0];
    if (red < 0.2f) return HAND;
    if (red < 0.5f) return STAND;
    if (red > 0.75f) return PENDULUM; /* its rod */
    return batch->model[12] < 0 ? PENDULUM : BALL;
}

static void place(const double m[16], const double p[3], double out[3]) {
    for (int row = 0; row < 3; ++row)
        out[row] = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row];
}

static void check_poses(const psplat_asset *asset, size_t animation,
                        void (*move)(part moved, double t, double p[3])) {
    const double duration = psplat_asset_get_animation(asset, animation)->duration;
    psplat_pose *pose;
    psplat_error error = {0};
    if (psplat_pose_create(asset, &pose, &error)) fail_msg("%s", error.text);
    for (int step = 0; step < 50; ++step) {
        double t = duration * (step + 0.3) / 50;
        if (psplat_pose_set(pose, animation, t, &error)) fail_msg("%s", error.text);
        for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i) {
            const psplat_batch *batch = psplat_asset_batch(asset, i);
            const double center[3] = {(double)batch->splats->center[0],
                                      (double)batch->splats->center[1],
                                      (double)batch->splats->center[2]};
            double expected[3], found[3];
            place(batch->model, center, expected);
            move(part_of(batch), t, expected);
            place(psplat_pose_matrix(pose, i), center, found);
            for (int k = 0; k < 3; ++k) /* keys are floats of up to 4 */
                if (fabs(found[k] - expected[k]) > 3e-6)
                    fail_msg("animation %zu at %g s: batch %zu: %.9g instead of %.9g", animation, t,
                             i, found[k], expected[k]);
        }
    }
    psplat_pose_destroy(pose);
}

static void check_file(const psplat_codec *codec) {
    psplat_asset *asset = convert_clockwork(codec);
    int parts[4] = {0};
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i)
        ++parts[part_of(psplat_asset_batch(asset, i))];
    for (int i = 0; i < 4; ++i) assert_true(parts[i] > 0);
    assert_int_equal(psplat_asset_animation_count(asset), 3);
    assert_string_equal(psplat_asset_get_animation(asset, 1)->name, "bounce");
    check_poses(asset, 0, tick);
    check_poses(asset, 1, bounce);
    check_poses(asset, 2, turn_all);
    psplat_asset_destroy(asset);
}

static void test_compressed(void **state) {
    (void)state;
    check_file(&psplat_meshopt_codec);
}

static void test_uncompressed(void **state) {
    (void)state;
    check_file(NULL);
}

int test_animated_conversion_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_compressed),
        cmocka_unit_test(test_uncompressed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
