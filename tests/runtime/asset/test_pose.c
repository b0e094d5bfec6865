/* SPDX-License-Identifier: MIT
 *
 * test_pose.c - tests that poses are what glTF 2.0 appendix C says: keys before, between and after
 * times, each interpolation, and nodes that are moved through others. Expected values are computed
 * here from angles and polynomials. Further tests are of what poses cost and of what they refuse.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include "ledger.h"
#include "moving.h"
#include "near.h"

#include <phongsplat/phongsplat.h>

#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static psplat_asset *open_text(char *text, const psplat_asset_desc *desc) {
    psplat_asset *asset = NULL;
    psplat_error error = {0};
    if (psplat_asset_open_memory(text, strlen(text), desc, &asset, &error))
        fail_msg("%s", error.text);
    free(text);
    return asset;
}

static psplat_pose *pose_of(const psplat_asset *asset) {
    psplat_pose *pose = NULL;
    psplat_error error = {0};
    if (psplat_pose_create(asset, &pose, &error)) fail_msg("%s", error.text);
    return pose;
}

/* Sets a pose and compares one batch's image of a point with where it should be. The tolerance is
 * the rounding of floats in the file, of numbers up to 10. */
static void check_point(psplat_pose *pose, size_t animation, double time, const double from[3],
                        double x, double y, double z) {
    const double expected[3] = {x, y, z};
    psplat_error error = {0};
    if (psplat_pose_set(pose, animation, time, &error)) fail_msg("%s", error.text);
    for (size_t batch = 0; batch < 3; ++batch) {
        const double *m = psplat_pose_matrix(pose, batch);
        assert_non_null(m);
        for (int row = 0; row < 3; ++row) {
            double at = m[12 + row];
            for (int k = 0; k < 3; ++k) at += m[4 * k + row] * from[k];
            if (fabs(at - expected[row]) > 2e-6)
                fail_msg("at %g s, row %d: %.9g instead of %.9g", time, row, at, expected[row]);
        }
    }
}

#define ONE(path, interpolation)                                                                   \
    "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"" path                        \
    "\"}}],\"samplers\":[{"                                                                        \
    "\"input\":16,\"output\":17,\"interpolation\":\"" interpolation "\"}]}"

/* Returns the pose of a document whose node 0 has one channel with these keys. */
static psplat_pose *one_channel(const float *times, size_t count, const float *values,
                                size_t value_count, int components, const char *animation,
                                psplat_asset **asset) {
    moving m = {0};
    moving_floats(&m, times, count, 1);
    moving_floats(&m, values, value_count, components);
    *asset = open_text(moving_text(&m, PSPLAT_SOURCE_DIR, "{\"mesh\":0}", animation), NULL);
    return pose_of(*asset);
}

static void close_pose(psplat_pose *pose, psplat_asset *asset) {
    psplat_pose_destroy(pose);
    psplat_asset_destroy(asset);
}

static const double origin[3] = {0, 0, 0}, ex[3] = {1, 0, 0};

static void test_linear(void **state) {
    (void)state;
    static const float times[] = {1, 2, 4}, at[] = {1, 2, 3, 5, 2, -1, 5, 4, 0};
    psplat_asset *asset;
    psplat_pose *pose = one_channel(times, 3, at, 3, 3, ONE("translation", "LINEAR"), &asset);
    check_point(pose, 0, -1e30, origin, 1, 2, 3); /* before the first key */
    check_point(pose, 0, 1, origin, 1, 2, 3);
    check_point(pose, 0, 1.25, origin, 2, 2, 2);
    check_point(pose, 0, 2, origin, 5, 2, -1);
    check_point(pose, 0, 3.5, origin, 5, 3.5, -0.25);
    check_point(pose, 0, 4, origin, 5, 4, 0);
    check_point(pose, 0, 1e30, origin, 5, 4, 0); /* after the last */
    psplat_pose_rest(pose);
    assert_near(psplat_pose_matrix(pose, 0)[12], 0, 0);
    close_pose(pose, asset);
}

static void test_step(void **state) {
    (void)state;
    static const float times[] = {0, 1, 4}, scales[] = {1, 2, 3, 0, 2, -1, 5, 4, 0.5f};
    psplat_asset *asset;
    psplat_pose *pose = one_channel(times, 3, scales, 3, 3, ONE("scale", "STEP"), &asset);
    static const double ones[3] = {1, 1, 1};
    check_point(pose, 0, 0.999, ones, 1, 2, 3);
    check_point(pose, 0, 1, ones, 0, 2, -1);
    check_point(pose, 0, 3.999, ones, 0, 2, -1);
    check_point(pose, 0, 4, ones, 5, 4, 0.5);
    close_pose(pose, asset);
}

/* Writes the quaternion of a turn about z. */
static void about_z(float q[4], double degrees, double sign) {
    q[0] = q[1] = 0;
    q[2] = (float)(sign * sin(degrees * pi / 360));
    q[3] = (float)(sign * cos(degrees * pi / 360));
}

/* The angle grows evenly, which it would not along a chord, and by the shorter way: the second
 * quaternion has the other sign, and the last turn is one of 120 degrees backwards. */
static void test_slerp(void **state) {
    (void)state;
    static const float times[] = {0, 1, 2, 3};
    float q[16];
    about_z(q, 0, 1);
    about_z(q + 4, 160, -1);
    about_z(q + 8, 160.0001, 1);
    about_z(q + 12, 400, 1);
    psplat_asset *asset;
    psplat_pose *pose = one_channel(times, 4, q, 4, 4, ONE("rotation", "LINEAR"), &asset);
    for (int i = 0; i <= 8; ++i) {
        double angle = 20 * i * pi / 180, back = (160 - 15 * i) * pi / 180;
        check_point(pose, 0, i / 8.0, ex, cos(angle), sin(angle), 0);
        check_point(pose, 0, 2 + i / 8.0, ex, cos(back), sin(back), 0);
    }
    check_point(pose, 0, 1.5, ex, cos(160 * pi / 180), sin(160 * pi / 180), 0);
    close_pose(pose, asset);
}

/* Tangents are per second: over a span of 2 they count twice. The values are those of the cubic
 * with these ends and slopes, x(s) = 3 s^2 - s^3 of s = t - 1, from x = 0 and slope 0 to x = 4 and
 * slope 0, and y(s) = s^3. */
static void test_spline(void **state) {
    (void)state;
    static const float times[] = {1, 3};
    static const float keys[] = {9, 9,  9, /**/ 0, 0, 0, /**/ 0, 0, 0,
                                 0, 12, 0, /**/ 4, 8, 0, /**/ 9, 9, 9};
    psplat_asset *asset;
    psplat_pose *pose =
        one_channel(times, 2, keys, 6, 3, ONE("translation", "CUBICSPLINE"), &asset);
    for (int i = 0; i <= 8; ++i) {
        double s = i / 4.0;
        check_point(pose, 0, 1 + s, origin, 3 * s * s - s * s * s, s * s * s, 0);
    }
    check_point(pose, 0, 0, origin, 0, 0, 0);
    check_point(pose, 0, 9, origin, 4, 8, 0);
    close_pose(pose, asset);
}

/* A spline of quaternions is normalised: with tangents of 0 its angle is that of the sum of the
 * ends. Where it leads through 0, the direction is that of the key before. */
static void test_spline_of_rotations(void **state) {
    (void)state;
    static const float times[] = {0, 1, 2};
    float keys[36] = {0};
    about_z(keys + 4, 0, 1);
    about_z(keys + 16, 120, 1);
    about_z(keys + 28, 120, -1);
    psplat_asset *asset;
    psplat_pose *pose = one_channel(times, 3, keys, 9, 4, ONE("rotation", "CUBICSPLINE"), &asset);
    check_point(pose, 0, 0.5, ex, 0.5, sqrt(0.75), 0); /* 60 degrees */
    double t = 0.25, part = 3 * t * t - 2 * t * t * t, sum[2];
    sum[0] = 1 - part + part * cos(pi / 3);
    sum[1] = part * sin(pi / 3);
    double angle = 2 * atan2(sum[1], sum[0]);
    check_point(pose, 0, 0.25, ex, cos(angle), sin(angle), 0);
    check_point(pose, 0, 1.5, ex, cos(2 * pi / 3), sin(2 * pi / 3), 0); /* at 0 */
    close_pose(pose, asset);
}

/* Rotations may be normalized integers of each type. */
static void test_integers(void **state) {
    (void)state;
    static const float times[] = {0};
    static const int8_t bytes[4] = {0, 0, 90, 90};
    static const uint8_t unsigned_bytes[4] = {0, 0, 180, 180};
    static const int16_t shorts[4] = {0, 0, 23170, 23170};
    static const uint16_t unsigned_shorts[4] = {0, 0, 46341, 46341};
    const struct {
        const void *data;
        size_t size;
        int type;
    } forms[] = {
        {bytes, 4, 5120}, {unsigned_bytes, 4, 5121}, {shorts, 8, 5122}, {unsigned_shorts, 8, 5123}};
    for (size_t i = 0; i < 4; ++i) {
        moving m = {0};
        moving_floats(&m, times, 1, 1);
        moving_add(&m, forms[i].data, forms[i].size, forms[i].type, 1, 4, ",\"normalized\":true");
        psplat_asset *asset = open_text(
            moving_text(&m, PSPLAT_SOURCE_DIR, "{\"mesh\":0}", ONE("rotation", "LINEAR")), NULL);
        psplat_pose *pose = pose_of(asset);
        check_point(pose, 0, 7, ex, 0, 1, 0); /* 90 degrees */
        close_pose(pose, asset);
    }
}

/* Node 0 is turned, node 1 below it is scaled and translated at rest and keeps what the animation
 * leaves alone, node 2 has the mesh and a matrix. The second animation moves only what it names,
 * whatever was evaluated before. Channels of weights, of extensions and of nodes that show nothing
 * are no harm. */
static void test_nodes(void **state) {
    (void)state;
    static const float times[] = {0, 2}, at[] = {1, 0, 0, 3, 0, 0};
    float q[8];
    about_z(q, 0, 1);
    about_z(q + 4, 90, 1);
    moving m = {0};
    int t = moving_floats(&m, times, 2, 1), turns = moving_floats(&m, q, 2, 4);
    int moves = moving_floats(&m, at, 2, 3);
    assert_int_equal(t + turns + moves, 16 + 17 + 18);
    static const char nodes[] =
        "{\"children\":[1]},{\"children\":[2],\"translation\":[0,5,0],\"scale\":[2,2,2]},"
        "{\"mesh\":0,\"matrix\":[0,1,0,0,-1,0,0,0,0,0,1,0,0,0,3,1]},{\"name\":\"bare\"}";
    static const char animations[] =
        "{\"name\":\"both\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
        "\"rotation\"}},"
        "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"translation\"}},"
        "{\"sampler\":3,\"target\":{\"node\":3,\"path\":\"translation\"}},"
        "{\"sampler\":2,\"target\":{\"node\":2,\"path\":\"weights\"}},"
        "{\"sampler\":1,\"target\":{\"path\":\"pointer\",\"extensions\":{}}}],"
        "\"samplers\":[{\"input\":16,\"output\":17},{\"input\":16,\"output\":18},"
        "{\"input\":16,\"output\":16},{\"input\":17,\"output\":16}]},"
        "{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}],"
        "\"samplers\":[{\"input\":16,\"output\":18}]},{\"channels\":[],\"samplers\":[]}";
    psplat_asset *asset = open_text(moving_text(&m, PSPLAT_SOURCE_DIR, nodes, animations), NULL);
    assert_int_equal(psplat_asset_animation_count(asset), 3);
    const psplat_animation *both = psplat_asset_get_animation(asset, 0);
    assert_string_equal(both->name, "both");
    assert_near(both->duration, 2, 0);
    assert_int_equal(both->channel_count, 2); /* Node 3 has no splats; its sampler is broken. */
    assert_string_equal(psplat_asset_get_animation(asset, 1)->name, "");
    assert_near(psplat_asset_get_animation(asset, 2)->duration, 0, 0);
    assert_null(psplat_asset_get_animation(asset, 3));
    psplat_pose *pose = pose_of(asset);
    /* At rest the matrix takes 1 0 0 to 0 1 3, the scale to 0 2 6, the translation to 0 7 6. */
    for (int i = 0; i < 16; ++i)
        assert_near(psplat_pose_matrix(pose, 0)[i], psplat_asset_batch(asset, 0)->model[i], 0);
    for (int round = 0; round < 2; ++round) {
        check_point(pose, 0, 0, ex, 1, 2, 6);
        check_point(pose, 0, 2, ex, -2, 3, 6);
        check_point(pose, 0, 1, ex, 0, sqrt(8), 6); /* (2, 2) turned by 45 degrees */
        check_point(pose, 1, 1, ex, 2, 7, 6);
        check_point(pose, 2, 1, ex, 0, 7, 6);
    }
    double low[3], high[3], rest_low[3], rest_high[3];
    check_point(pose, 1, 2, ex, 3, 7, 6);
    psplat_pose_bounds(pose, low, high);
    psplat_asset_bounds(asset, rest_low, rest_high);
    assert_near(low[0], rest_low[0] + 3, 1e-12);
    assert_near(high[0], rest_high[0] + 3, 1e-12);
    assert_near(high[1], rest_high[1], 1e-12);
    close_pose(pose, asset);
}

/* A pose takes memory once, from the asset's allocator, and gives back all of it. */
static void test_memory(void **state) {
    (void)state;
    static const float times[] = {0, 1}, at[] = {0, 0, 0, 1, 1, 1};
    moving m = {0};
    moving_floats(&m, times, 2, 1);
    moving_floats(&m, at, 2, 3);
    ledger l = {.fail_at = -1};
    const psplat_asset_desc desc = {.allocator = ledger_allocator(&l)};
    psplat_asset *asset = open_text(
        moving_text(&m, PSPLAT_SOURCE_DIR, "{\"mesh\":0}", ONE("translation", "LINEAR")), &desc);
    size_t before = l.bytes;
    psplat_pose *pose = NULL;
    int taken = 0;
    for (int i = 0; i < 4; ++i) { /* each of the four allocations fails once */
        l.fail_at = l.calls + i;
        assert_int_equal(psplat_pose_create(asset, &pose, NULL), PSPLAT_ERROR_MEMORY);
        assert_null(pose);
        assert_int_equal(l.bytes, before);
    }
    l.fail_at = -1;
    pose = pose_of(asset);
    taken = l.calls;
    for (int i = 0; i < 100; ++i) assert_int_equal(psplat_pose_set(pose, 0, 0.01 * i, NULL), 0);
    assert_int_equal(l.calls, taken);
    psplat_pose_destroy(pose);
    assert_int_equal(l.bytes, before);
    psplat_asset_destroy(asset);
    assert_int_equal(l.bytes, 0);
}

/* What a call cannot do it refuses, and the pose stands at rest where numbers overflow. */
static void test_arguments(void **state) {
    (void)state;
    static const float times[] = {0, 1},
                       huge[] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 0, 0};
    static const float large[] = {3e38f, 3e38f, 3e38f};
    psplat_error error = {0};
    psplat_asset *asset;
    psplat_pose *pose = one_channel(times, 2, huge, 6, 3, ONE("scale", "CUBICSPLINE"), &asset),
                *none;
    assert_int_equal(psplat_pose_set(pose, 1, 0, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_pose_set(pose, 0, NAN, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_pose_set(pose, 0, INFINITY, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_pose_set(NULL, 0, 0, &error), PSPLAT_ERROR_ARGUMENT);
    assert_int_equal(psplat_pose_create(NULL, &none, &error), PSPLAT_ERROR_ARGUMENT);
    assert_null(none);
    assert_null(psplat_pose_matrix(pose, 3));
    assert_null(psplat_pose_matrix(NULL, 0));
    assert_int_equal(psplat_asset_animation_count(NULL), 0);
    assert_null(psplat_asset_get_animation(NULL, 0));
    psplat_pose_rest(NULL);
    psplat_pose_destroy(NULL);
    check_point(pose, 0, 0, ex, 0, 0, 0); /* a scale of 0 is a pose */
    close_pose(pose, asset);

    /* Nine nested nodes of scale 3e38 leave the range of doubles, but not at rest. */
    moving m = {0};
    moving_floats(&m, times, 1, 1);
    moving_floats(&m, large, 1, 3);
    char nodes[1024] = "", channels[2048] = "";
    for (int i = 0; i < 9; ++i) {
        size_t used = strlen(nodes), said = strlen(channels);
        snprintf(nodes + used, sizeof nodes - used,
                 i < 8 ? "{\"children\":[%d]}," : "{\"mesh\":%d}", i < 8 ? i + 1 : 0);
        snprintf(channels + said, sizeof channels - said,
                 "%s{\"sampler\":0,\"target\":{\"node\":%d,\"path\":\"scale\"}}", i ? "," : "", i);
    }
    char animation[4096];
    snprintf(animation, sizeof animation,
             "{\"channels\":[%s],\"samplers\":[{\"input\":16,\"output\":17}]}", channels);
    asset = open_text(moving_text(&m, PSPLAT_SOURCE_DIR, nodes, animation), NULL);
    pose = pose_of(asset);
    assert_int_equal(psplat_pose_set(pose, 0, 0, &error), PSPLAT_ERROR_RANGE);
    assert_non_null(strstr(error.text, "animation 0 moves splats beyond what a double can hold"));
    assert_near(psplat_pose_matrix(pose, 0)[0], 1, 0);
    close_pose(pose, asset);
}

/* An asset without animations has one pose. */
static void test_at_rest(void **state) {
    (void)state;
    moving m = {0};
    static const float times[] = {0};
    moving_floats(&m, times, 1, 1);
    psplat_asset *asset = open_text(
        moving_text(&m, PSPLAT_SOURCE_DIR, "{\"mesh\":0,\"translation\":[1,2,3]}", ""), NULL);
    psplat_pose *pose = pose_of(asset);
    psplat_error error = {0};
    assert_near(psplat_pose_matrix(pose, 2)[14], 3, 0);
    assert_int_equal(psplat_pose_set(pose, 0, 0, &error), PSPLAT_ERROR_ARGUMENT);
    assert_string_equal(error.text, "there are 0 animations, not 0");
    close_pose(pose, asset);
}

int test_pose_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_linear),
        cmocka_unit_test(test_step),
        cmocka_unit_test(test_slerp),
        cmocka_unit_test(test_spline),
        cmocka_unit_test(test_spline_of_rotations),
        cmocka_unit_test(test_integers),
        cmocka_unit_test(test_nodes),
        cmocka_unit_test(test_memory),
        cmocka_unit_test(test_arguments),
        cmocka_unit_test(test_at_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
