/* SPDX-License-Identifier: MIT
 *
 * test_bounds.c - tests the sphere that the camera fits into the window, on a clipped cube, a disc
 * and a splat that clip lines cut away entirely. Expected radii are computed by geometry.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <viewer.h>

#include "scene_asset.h"

#include <math.h>
#include <string.h>

static sphere sphere_of(scene s) {
    psplat_asset *asset = scene_open(&s);
    sphere result = bounds_of(asset);
    psplat_asset_destroy(asset);
    scene_free(&s);
    return result;
}

/* The faces of the cube are splats that clip lines cut down: corners lie at sqrt 3, nothing beyond.
 * The tolerance 1e-3 is what the file's quantisation may move. */
static void test_clip_lines_count(void **state) {
    (void)state;
    sphere s = sphere_of(scene_cube(1));
    for (int i = 0; i < 3; ++i) assert_true(fabs(s.center[i]) < 1e-3);
    assert_true(fabs(s.radius - sqrt(3)) < 1e-3);
}

/* A twelve-sided polygon around a disc reaches 1 / cos 15 degrees. */
static void test_a_disc_is_inside(void **state) {
    (void)state;
    scene s = scene_disc(2);
    s.origin[0] = 1e7;
    sphere b = sphere_of(s);
    assert_true(fabs(b.center[0] - 1e7) < 1e-2);
    assert_true(b.radius >= 2 && b.radius < 2 * 1.036);
}

/* A clip line leaves nothing of the only splat: there is a sphere to look at nevertheless. */
static void test_what_is_cut_away_has_bounds(void **state) {
    (void)state;
    scene s = scene_disc(1);
    s.splats[0].clip_count = 1;
    s.splats[0].clip[0][0] = 1;
    s.splats[0].clip[0][2] = -3;
    sphere b = sphere_of(s);
    assert_true(isfinite(b.center[0]) && isfinite(b.radius));
}

/* Beyond a seam the disc goes on. */
static void test_seams_cut_nothing(void **state) {
    (void)state;
    for (uint32_t seams = 0; seams < 2; ++seams) {
        scene s = scene_disc(1);
        s.splats[0].clip_count = 1;
        s.splats[0].clip[0][0] = 1;
        s.seam_lines = seams;
        sphere b = sphere_of(s);
        if (seams)
            assert_true(fabs(b.center[0]) < 1e-3);
        else
            assert_true(b.center[0] > 0.4);
    }
}

/* A line that bulges in keeps x <= y^2 of a disc, and others keep -1/4 <= x and |y| <= 1/2: nothing
 * lies beyond x = 1/4, far within the points in which the first one meets the circle. */
static void test_bent_lines_count(void **state) {
    (void)state;
    static const float lines[4][3] = {{-1, 0, 0}, {1, 0, 0.25f}, {0, 1, 0.5f}, {0, -1, 0.5f}};
    scene s = scene_disc(1);
    s.splats[0].clip_count = 4;
    memcpy(s.splats[0].clip, lines, sizeof lines);
    s.splats[0].bend[0] = 2;
    sphere b = sphere_of(s);
    assert_true(fabs(b.center[0]) < 1e-6 && fabs(b.radius - sqrt(0.3125)) < 1e-6);
}

/* A disc that is bent to a dome ends at a depth of a half: the sphere that holds its rim and its
 * top has about the radius of its rim. A bent line that keeps half of it makes the sphere smaller.
 */
static void test_curved_splats_count(void **state) {
    (void)state;
    for (int cut = 0; cut < 2; ++cut) {
        scene s = scene_disc(2);
        s.splats[0].gradient[0] = s.splats[0].gradient[1] = 0.5f;
        s.splats[0].clip_count = (uint32_t)cut;
        s.splats[0].clip[0][0] = -1;
        s.splats[0].bend[0] = 0.4f; /* keeps x <= 0.4 y^2 / 4 */
        scene_curve(&s);
        sphere b = sphere_of(s);
        double farthest = 0;
        for (int i = 0; i < 100 * 100; ++i) {
            double x = i % 100 / 24.75 - 2, y = i / 100 / 24.75 - 2, z = -(x * x + y * y) / 8;
            const double d[3] = {x - b.center[0], y - b.center[1], z - b.center[2]};
            if (x * x + y * y > 4 || (cut && x > 0.1 * y * y)) continue;
            farthest = fmax(farthest, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
        }
        assert_true(b.center[2] < -0.2 && b.center[2] > -0.4);
        /* The outline of twelve sides reaches 3.6 % beyond the circle. */
        assert_true(b.radius >= farthest && b.radius < 1.05 * farthest);
    }
}

int test_bounds_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clip_lines_count),
        cmocka_unit_test(test_a_disc_is_inside),
        cmocka_unit_test(test_what_is_cut_away_has_bounds),
        cmocka_unit_test(test_seams_cut_nothing),
        cmocka_unit_test(test_bent_lines_count),
        cmocka_unit_test(test_curved_splats_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
