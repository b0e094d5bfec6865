/* SPDX-License-Identifier: MIT
 *
 * test_read_animations.c - tests what is read of animations: every number, interpolation and
 * target, each accessor once, and one warning for what is dropped with its place and cause.
 */
#include "gltf_fixture.h"
#include "import/read_scene.h"
#include "scene/scene.h"

#include <math.h>
#include <string.h>

static psplat_scene scene_of(const char *text) {
    psplat_scene scene;
    psplat_error error = {0};
    write_bytes("a.gltf", text, strlen(text));
    psplat_result result = psplat_scene_read(fixture_path, NULL, &scene, &error);
    unlink(fixture_path);
    if (result) fail_msg("%s", error.text);
    return scene;
}

static const float times[2] = {0.5f, 2}, moves[6] = {1, 2, 3, 4, 5, 6};
static const int16_t turns[8] = {0, 0, 0, 32767, 0, 0, 23170, 23170};

/* Accessors 2, 3 and 4: times, vectors and rotations. */
static gltf animated(void) {
    gltf g = tetrahedron();
    add(&g, times, sizeof times, FLOAT, "SCALAR", 2, "");
    add(&g, moves, sizeof moves, FLOAT, "VEC3", 2, "");
    add(&g, turns, sizeof turns, SHORT, "VEC4", 2, ",\"normalized\":true");
    return g;
}

#define NODES                                                                                      \
    "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1,2]},{\"mesh\":0},"                   \
    "{\"name\":\"joint\"}],"

static void test_kept(void **state) {
    (void)state;
    static const float splines[18] = {9, 9, 9, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 9, 9, 9};
    gltf g = animated();
    add(&g, splines, sizeof splines, FLOAT, "VEC3", 6, "");
    psplat_scene scene = scene_of(finish(
        &g, NODES INDEXED
        ",\"animations\":[{\"name\":\"go\",\"extras\":[1],\"channels\":["
        "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"rotation\"}},"
        "{\"sampler\":2,\"target\":{\"node\":1,\"path\":\"scale\"}},"
        "{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"rotation\"}}],"
        "\"samplers\":[{\"input\":99,\"output\":99},{\"input\":2,\"output\":4},"
        "{\"input\":2,\"output\":3,\"interpolation\":\"STEP\"}]},{\"channels\":[{\"sampler\":0,"
        "\"target\":{\"node\":2,\"path\":\"translation\"}}],\"samplers\":[{\"input\":2,"
        "\"output\":5,\"interpolation\":\"CUBICSPLINE\"}]}]"));
    assert_int_equal(scene.warning_count, 0);
    assert_int_equal(scene.animation_count, 2);
    assert_int_equal(scene.track_count, 4); /* times are read once */
    const psplat_scene_animation *go = &scene.animations[0];
    assert_string_equal(go->name, "go");
    assert_string_equal(go->extras, "[1]");
    assert_int_equal(go->sampler_count, 2); /* the one that nothing uses is not looked at */
    assert_int_equal(go->channel_count, 3);
    assert_int_equal(go->channels[0].sampler, go->channels[2].sampler);
    assert_int_equal(go->channels[1].path, PSPLAT_SCENE_SCALE);
    assert_int_equal(go->channels[2].node, 0);
    const psplat_scene_sampler *turning = &go->samplers[go->channels[0].sampler];
    const psplat_scene_track *values = &scene.tracks[turning->values];
    assert_int_equal(turning->interpolation, PSPLAT_SCENE_LINEAR);
    assert_int_equal(values->count, 2);
    assert_int_equal(values->components, 4);
    assert_near((double)values->values[6], sqrt(0.5), 1e-7); /* made a unit quaternion */
    assert_near((double)scene.tracks[turning->times].values[0], 0.5, 0);
    assert_int_equal(go->samplers[go->channels[1].sampler].interpolation, PSPLAT_SCENE_STEP);
    const psplat_scene_sampler *spline = &scene.animations[1].samplers[0];
    assert_int_equal(spline->interpolation, PSPLAT_SCENE_CUBICSPLINE);
    assert_int_equal(scene.tracks[spline->values].count, 6);
    assert_memory_equal(scene.tracks[spline->values].values, splines, sizeof splines);
    assert_null(scene.animations[1].name);
    for (size_t i = 0; i < 3; ++i) assert_true(scene.nodes[i].is_animated);
    psplat_scene_free(&scene);
}

/* Quaternions get length 1, those of splines with their tangents, which go on to be per second. */
static void test_unit_quaternions(void **state) {
    (void)state;
    static const float long_ones[8] = {0, 0, 3, 4, 0, 0, 0, 1};
    static const float splines[24] = {0, 0, 0, 0, 0, 0, 1.2f, 1.6f, 4, 2, 0, 0,
                                      0, 0, 8, 0, 0, 0, 0,    1,    0, 0, 0, 0};
    gltf g = animated();
    add(&g, long_ones, sizeof long_ones, FLOAT, "VEC4", 2, "");
    add(&g, splines, sizeof splines, FLOAT, "VEC4", 6, "");
    psplat_scene scene = scene_of(
        finish(&g, NODES INDEXED
               ",\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":"
               "\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"rotation\"}}],"
               "\"samplers\":[{\"input\":2,\"output\":5},{\"input\":2,\"output\":6,"
               "\"interpolation\":\"CUBICSPLINE\"}]}]"));
    assert_int_equal(scene.warning_count, 0);
    const float *q = scene.tracks[1].values, *spline = scene.tracks[2].values;
    static const float expected[8] = {0, 0, 0.6f, 0.8f, 0, 0, 0, 1};
    for (int k = 0; k < 8; ++k) assert_near((double)q[k], (double)expected[k], 1e-7);
    for (int k = 0; k < 4; ++k) assert_near((double)spline[4 + k], (double)expected[k], 1e-7);
    assert_near((double)spline[8], 2, 1e-6); /* half of 4, as the value of 2 is halved */
    assert_near((double)spline[14], 8, 0);   /* the other key is of length 1 already */
    psplat_scene_free(&scene);
}

/* Weights of morph targets, joints that show nothing and animations that are empty are dropped,
 * with one warning for each kind; the rest of their animation stays. */
static void test_dropped_by_kind(void **state) {
    (void)state;
    gltf g = animated();
    psplat_scene scene =
        scene_of(finish(&g, NODES INDEXED
                        ",\"skins\":[{\"joints\":[2,0]}],\"animations\":[{\"channels\":["
                        "{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"translation\"}},"
                        "{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"weights\"}},"
                        "{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"weights\"}},"
                        "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}],"
                        "\"samplers\":[{\"input\":2,\"output\":3}]},{\"channels\":[{\"sampler\":0,"
                        "\"target\":{\"node\":1,\"path\":\"weights\"}}],\"samplers\":[{\"input\":2,"
                        "\"output\":2}]}]"));
    static const char *const expected[] = {
        "3 channels of animations are dropped: splats follow the translation, rotation and scale",
        "1 channels of animations are dropped: they move joints that show nothing",
        "1 animations are dropped: they move no nodes", "1 skins are dropped"};
    assert_int_equal(scene.warning_count, 4);
    for (size_t i = 0; i < 4; ++i)
        if (!strstr(scene.warnings[i], expected[i]))
            fail_msg("'%s' instead of '%s'", scene.warnings[i], expected[i]);
    assert_int_equal(scene.animation_count, 1);
    assert_int_equal(scene.animations[0].channel_count, 1);
    assert_int_equal(scene.animations[0].channels[0].node, 0); /* a joint with a mesh below */
    assert_true(scene.nodes[0].is_animated && !scene.nodes[2].is_animated);
    psplat_scene_free(&scene);
}

#define ONE(sampler, node, path)                                                                   \
    "\"animations\":[{\"name\":\"bad\",\"channels\":[{\"sampler\":" sampler                        \
    ",\"target\":{\"node\":" node ",\"path\":\"" path "\"}}],\"samplers\":[{\"input\":2,"          \
    "\"output\":3}]},{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],"  \
    "\"samplers\":[{\"input\":2,\"output\":3}]}]"

/* Asserts that the first animation is dropped for a cause and the second is kept, with the tracks
 * that it needs. */
static void check_dropped(gltf *g, const char *graph, const char *cause) {
    psplat_scene scene = scene_of(finish(g, graph));
    char expected[300];
    snprintf(expected, sizeof expected, "animation 0 'bad' is dropped: %s", cause);
    assert_int_equal(scene.warning_count, 1);
    assert_string_equal(scene.warnings[0], expected);
    assert_int_equal(scene.animation_count, 1);
    assert_int_equal(scene.track_count, 2);
    psplat_scene_free(&scene);
}

static void test_dropped_for_a_cause(void **state) {
    (void)state;
    gltf g = animated();
    check_dropped(&g, NODES INDEXED "," ONE("1", "1", "scale"),
                  "sampler 1 does not exist (1 in the file)");
    check_dropped(&g, NODES INDEXED "," ONE("0", "3", "scale"),
                  "node 3 does not exist (3 in the file)");
    check_dropped(&g, NODES INDEXED "," ONE("0", "1", "rotation"),
                  "sampler 0: accessor 3: rotations are not vectors of four floats or normalized "
                  "integers");
    check_dropped(&g,
                  "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1]},{\"mesh\":0,"
                  "\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]," INDEXED
                  "," ONE("0", "1", "scale"),
                  "node 1 has a matrix, which cannot be animated");
}

/* Asserts the same of other numbers: times, and then vectors or rotations for as many of them. */
static void check_numbers(const float *some_times, size_t count, const float *values,
                          int components, const char *sampler, const char *cause) {
    gltf g = animated();
    char graph[1024];
    add(&g, some_times, count * 4, FLOAT, "SCALAR", count, "");
    add(&g, values, count * 4 * (size_t)components, FLOAT, components == 3 ? "VEC3" : "VEC4", count,
        "");
    snprintf(graph, sizeof graph,
             NODES INDEXED ",\"animations\":[{\"name\":\"bad\",\"channels\":[{\"sampler\":0,"
                           "\"target\":{\"node\":1,\"path\":\"%s\"}}],\"samplers\":[%s]},"
                           "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
                           "\"scale\"}}],\"samplers\":[{\"input\":2,\"output\":3}]}]",
             components == 3 ? "translation" : "rotation", sampler);
    check_dropped(&g, graph, cause);
}

static void test_dropped_for_numbers(void **state) {
    (void)state;
    static const float good[3] = {0, 1, 2}, early[3] = {-1, 1, 2}, equal[3] = {0, 1, 1};
    const float endless[3] = {0, 1, INFINITY};
    static const float zeros[12] = {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1};
    const float wrong[9] = {0, 0, 0, 0, NAN, 0, 0, 0, 0};
    static const char plain[] = "{\"input\":5,\"output\":6}";
    check_numbers(early, 3, zeros, 3, plain, "sampler 0: accessor 5: the first time is negative");
    check_numbers(equal, 3, zeros, 3, plain,
                  "sampler 0: accessor 5: time 2 is not after the time before it");
    check_numbers(endless, 3, zeros, 3, plain, "sampler 0: accessor 5: element 2 is not finite");
    check_numbers(good, 3, wrong, 3, plain, "sampler 0: accessor 6: element 1 is not finite");
    check_numbers(good, 3, zeros, 4, plain, "sampler 0: accessor 6: rotation 1 is 0");
    check_numbers(good, 3, zeros, 3, "{\"input\":2,\"output\":6}",
                  "sampler 0: 3 values for 2 times");
    check_numbers(good, 3, zeros, 3, "{\"input\":5,\"output\":6,\"interpolation\":\"CUBICSPLINE\"}",
                  "sampler 0: 3 values for 3 times");
    check_numbers(good, 3, zeros, 3, "{\"input\":5,\"output\":6,\"interpolation\":\"CUBIC\"}",
                  "sampler 0: interpolation 'CUBIC' is none of LINEAR, STEP and CUBICSPLINE");
    check_numbers(good, 3, zeros, 3, "{\"input\":5,\"output\":77}",
                  "sampler 0: accessor 77 does not exist (7 in the file)");
    check_numbers(good, 3, zeros, 3, "{\"input\":6,\"output\":6}",
                  "sampler 0: accessor 6: times are not scalars of floats");
}

/* Two channels may not move the same. */
static void test_twice(void **state) {
    (void)state;
    gltf g = animated();
    check_dropped(&g,
                  NODES INDEXED
                  ",\"animations\":[{\"name\":\"bad\",\"channels\":[{\"sampler\":0,\"target\":{"
                  "\"node\":1,\"path\":\"scale\"}},{\"sampler\":0,\"target\":{\"node\":1,"
                  "\"path\":\"scale\"}}],\"samplers\":[{\"input\":2,\"output\":3}]},"
                  "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],"
                  "\"samplers\":[{\"input\":2,\"output\":3}]}]",
                  "two channels have the scale of node 1");
}

/* tinygltf leaves out channels without a sampler, a node or a path; a warning names the first of
 * each animation. The other channels stay. */
static void test_lost_channels(void **state) {
    (void)state;
    gltf g = animated();
    psplat_scene scene = scene_of(finish(
        &g, NODES INDEXED
        ",\"animations\":[{\"name\":\"go\",\"channels\":["
        "{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"scale\"}},"
        "{\"target\":{\"node\":0,\"path\":\"scale\"}},"
        "{\"sampler\":0,\"target\":{\"path\":\"scale\"}}],\"samplers\":["
        "{\"input\":2,\"output\":3}]},{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0}},"
        "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}],\"samplers\":["
        "{\"input\":2,\"output\":3}]},{\"channels\":[{\"sampler\":0,\"target\":{\"path\":"
        "\"scale\"}}],\"samplers\":[{\"input\":2,\"output\":3}]}]"));
    static const char *const expected[] = {
        "animation 0 'go': channel 1 is dropped: it has no sampler, and 1 more like it",
        "animation 1: channel 0 is dropped: its target has no path",
        "animation 2: channel 0 is dropped: its target is no node",
        "1 animations are dropped: they move no nodes"};
    assert_int_equal(scene.warning_count, 4);
    for (size_t i = 0; i < 4; ++i) assert_string_equal(scene.warnings[i], expected[i]);
    assert_int_equal(scene.animation_count, 2);
    assert_int_equal(scene.animations[0].channel_count, 1);
    assert_int_equal(scene.animations[1].channel_count, 1);
    psplat_scene_free(&scene);
}

int test_read_animations_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kept),
        cmocka_unit_test(test_unit_quaternions),
        cmocka_unit_test(test_dropped_by_kind),
        cmocka_unit_test(test_dropped_for_a_cause),
        cmocka_unit_test(test_dropped_for_numbers),
        cmocka_unit_test(test_twice),
        cmocka_unit_test(test_lost_channels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
