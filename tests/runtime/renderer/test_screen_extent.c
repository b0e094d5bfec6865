/* SPDX-License-Identifier: MIT
 *
 * test_screen_extent.c - tests screen extents of spheres: the rectangle holds the image of every
 * point of the sphere, and is tight for small spheres. Spheres and views are random; expected
 * places come from projecting points.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>

#include <cmocka.h>

#include "renderer/screen_extent.h"
#include "scene_asset.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 300, HEIGHT = 200 };

static uint32_t seed = 77u;

static double uniform(double low, double high) {
    return low + (high - low) * (double)scene_random(&seed);
}

/* Makes a perspective or parallel matrix after a shear: any 4 x 4 matrix that a view can be. */
static void random_clip(int is_perspective, double clip[16]) {
    memset(clip, 0, 16 * sizeof *clip);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) clip[4 * c + r] = (c == r) + uniform(-0.5, 0.5);
    for (int i = 0; i < 3; ++i) clip[12 + i] = uniform(-1, 1);
    clip[11] = is_perspective ? -1 : 0;
    clip[15] = is_perspective ? 0 : 1;
}

static void add(psplat_screen_extent *extent, const float center[3], float radius,
                const double clip[16]) {
    psplat_screen_extent more = psplat_screen_extent_of(center, radius, clip, WIDTH, HEIGHT);
    psplat_screen_extent_join(extent, &more);
}

static void test_holds(void **state) {
    (void)state;
    for (int round = 0; round < 20000; ++round) {
        double clip[16];
        psplat_screen_extent extent = {0, 0, 0, 0};
        const float center[3] = {(float)uniform(-3, 3), (float)uniform(-3, 3),
                                 (float)uniform(-6, 1)};
        float radius = (float)uniform(0.001, 2);
        random_clip(round & 1, clip);
        add(&extent, center, radius, clip);
        for (int k = 0; k < 20; ++k) {
            double d[3], length = 0, at[4];
            for (int i = 0; i < 3; ++i) d[i] = uniform(-1, 1);
            for (int i = 0; i < 3; ++i) length += d[i] * d[i];
            for (int row = 0; row < 4; ++row) {
                at[row] = clip[12 + row];
                for (int i = 0; i < 3; ++i)
                    at[row] += clip[4 * i + row] *
                               ((double)center[i] + d[i] * (double)radius / sqrt(length));
            }
            double x = (0.5 * at[0] / at[3] + 0.5) * WIDTH,
                   y = (0.5 * at[1] / at[3] + 0.5) * HEIGHT;
            if (!(at[3] > 0) || x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT) continue;
            assert_true(x >= extent.x0 && x < extent.x1 && y >= extent.y0 && y < extent.y1);
        }
        assert_true(extent.x0 >= 0 && extent.x1 <= WIDTH && extent.y0 >= 0 && extent.y1 <= HEIGHT);
    }
}

/* A small sphere far away has an extent of its image and a pixel around it, rounded to whole
 * pixels. */
static void test_tight(void **state) {
    (void)state;
    double clip[16] = {0};
    clip[0] = clip[5] = clip[10] = 1;
    clip[11] = -1;
    psplat_screen_extent extent = {0, 0, 0, 0};
    add(&extent, (const float[]){0, 0, -10}, 0.1f, clip);
    /* The radius is 0.01 of w: 1.5 pixels in x and 1 in y. */
    assert_int_equal(extent.x0, 147);
    assert_int_equal(extent.x1, 153);
    assert_int_equal(extent.y0, 97);
    assert_int_equal(extent.y1, 103);
    /* A sphere outside adds nothing; a second one inside adds its own extent. */
    psplat_screen_extent before = extent;
    add(&extent, (const float[]){30, 0, -10}, 0.1f, clip);
    assert_memory_equal(&before, &extent, sizeof extent);
    add(&extent, (const float[]){-5, -5, -10}, 0.1f, clip);
    assert_true(extent.x0 < 80 && extent.y0 < 55 && extent.x1 == 153 && extent.y1 == 103);
    /* A sphere around the eye takes the whole view. */
    add(&extent, (const float[]){0, 0, 0}, 1, clip);
    assert_int_equal(extent.x1 - extent.x0, WIDTH);
    assert_int_equal(extent.y1 - extent.y0, HEIGHT);
}

int test_screen_extent_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_holds),
        cmocka_unit_test(test_tight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
