/* SPDX-License-Identifier: MIT
 *
 * test_reference.c - tests the reference rasteriser against closed forms: which pixels a single
 * splat covers, and its (u, v) and depth there. The camera of most tests is at z = 5 and looks
 * along -z, so that the ray of pixel (x, y) is (dx, dy, -1).
 */
#include "reference_view.h"
#include "scene_asset.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"

#define WIDTH 120
#define HEIGHT 90
#define FOCAL 100.0
#define DISTANCE 5.0
#define NEAR 0.5
#define FAR 20.0

/* The tolerance for some ten sums and products of numbers near 1 in double, 1e-15 each, with a
 * margin. */
#define ROUNDING 1e-12

static psplat_view front_view(void) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, 0, DISTANCE}, (double[]){0, 0, 0});
    camera_perspective(&view, FOCAL, NEAR, FAR);
    return view;
}

static double ray_x(int x) {
    return (x + 0.5 - WIDTH / 2.0) / FOCAL;
}

static double ray_y(int y) {
    return (y + 0.5 - HEIGHT / 2.0) / FOCAL;
}

/* Sets the axes and the normal that belongs to them. */
static void turn(psplat_splat *splat, const double u[3], const double v[3]) {
    scene_set_axes(splat, u, v);
    for (int i = 0; i < 3; ++i)
        splat->normal[i] =
            (float)(u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]);
}

/* Returns the window depth of a point s in front of the eye. */
static double depth_of(double s) {
    return 0.5 + 0.5 * ((FAR + NEAR) / (FAR - NEAR) - 2 * FAR * NEAR / ((FAR - NEAR) * s));
}

/* Asserts that pixel (x, y) shows the splat at (u, v), s in front of the eye, if that is inside the
 * ellipse. */
static void assert_pixel_near(const picture *p, int x, int y, double u, double v, double s,
                              double tolerance) {
    int at = y * p->width + x;
    int inside = u * u + v * v <= 1 && s >= NEAR && s <= FAR;
    assert_int_equal(p->image.count[at], inside);
    assert_int_equal(p->image.splat[at], inside ? 0 : -1);
    assert_near((double)p->image.color[4 * at + 3], inside, 0);
    if (inside) {
        assert_near(p->image.uv[2 * at], u, tolerance);
        assert_near(p->image.uv[2 * at + 1], v, tolerance);
    }
    assert_near(p->image.depth[at], inside ? depth_of(s) : 1, tolerance);
}

static void assert_pixel(const picture *p, int x, int y, double u, double v, double s) {
    assert_pixel_near(p, x, y, u, v, s, ROUNDING);
}

static void test_facing_disc(void **state) {
    (void)state;
    scene s = scene_disc(1.5f);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x)
            assert_pixel(&p, x, y, ray_x(x) * DISTANCE / 1.5, ray_y(y) * DISTANCE / 1.5, DISTANCE);
    /* The number of pixels of a convex shape differs from its area by at most its perimeter in
     * pixels. */
    double radius = 1.5 * FOCAL / DISTANCE;
    assert_near((double)picture_covered(&p), CAMERA_PI * radius * radius, 2 * CAMERA_PI * radius);
    picture_free(&p);
    scene_free(&s);
}

/* The disc is turned about x by an angle: its point (u, v cos, v sin) lies on the ray where s dy =
 * v cos and 5 - s = v sin. At 89.9 degrees it is a tenth of a degree from edge-on. */
static void test_tilted_disc(void **state) {
    (void)state;
    const double angles[] = {60, -35, 89.9};
    for (int i = 0; i < 3; ++i) {
        double angle = angles[i] * CAMERA_PI / 180;
        scene s = scene_disc(1);
        s.material.double_sided = 1;
        turn(&s.splats[0], (double[]){1, 0, 0}, (double[]){0, cos(angle), sin(angle)});
        /* The axes are stored in float, so that the expected values use them instead of the
         * angle. */
        double stored = 2 * atan2(s.splats[0].rotation[0], s.splats[0].rotation[3]);
        psplat_view view = front_view();
        picture p = picture_of(&s, NULL, &view);
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x) {
                double distance = DISTANCE / (1 + ray_y(y) * tan(stored));
                double v = ray_y(y) * distance / cos(stored);
                /* Close to edge-on, v magnifies rounding by 1 / cos = 573. */
                assert_pixel_near(&p, x, y, ray_x(x) * distance, v, distance,
                                  i == 2 ? 1e3 * ROUNDING : ROUNDING);
            }
        assert_true(i == 2 || picture_covered(&p) > 300);
        picture_free(&p);
        scene_free(&s);
    }
}

/* A splat seen exactly along its plane has no fragment, and no value is undefined. */
static void test_edge_on(void **state) {
    (void)state;
    scene s = scene_disc(1);
    s.material.double_sided = 1;
    turn(&s.splats[0], (double[]){0, 0, -1}, (double[]){1, 0, 0});
    psplat_view view = front_view();
    view.height = 91; /* the rays of the middle row lie in the plane */
    camera_perspective(&view, FOCAL, NEAR, FAR);
    picture p = picture_of(&s, NULL, &view);
    for (int i = 0; i < p.width * p.height; ++i) {
        assert_true(isfinite(p.image.color[4 * i]) && isfinite(p.image.depth[i]));
        assert_true(p.image.tie[i] >= 0 && p.image.tie[i] <= 1);
    }
    assert_true(picture_covered(&p) <= WIDTH);
    picture_free(&p);
    scene_free(&s);
}

static size_t count_clipped(uint32_t clip_count, const float clip[4][3]) {
    scene s = scene_disc(1.5f);
    s.splats[0].clip_count = clip_count;
    if (clip_count) memcpy(s.splats[0].clip, clip, clip_count * sizeof clip[0]);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    size_t count = picture_covered(&p);
    for (int i = 0; i < p.width * p.height; ++i)
        for (uint32_t k = 0; k < clip_count && p.image.count[i]; ++k)
            assert_true((double)clip[k][0] * p.image.uv[2 * i] +
                            (double)clip[k][1] * p.image.uv[2 * i + 1] + (double)clip[k][2] >=
                        0);
    picture_free(&p);
    scene_free(&s);
    return count;
}

static void test_clip_lines(void **state) {
    (void)state;
    size_t whole = count_clipped(0, NULL);
    assert_true(whole > 2000);
    /* The image is even in both directions, so that lines through the centre halve the pixels
     * exactly. */
    assert_int_equal(count_clipped(1, (const float[4][3]){{1, 0, 0}}) * 2, whole);
    assert_int_equal(count_clipped(2, (const float[4][3]){{1, 0, 0}, {0, -1, 0}}) * 4, whole);
    assert_int_equal(count_clipped(1, (const float[4][3]){{0, 1, 2}}), whole);
    assert_int_equal(count_clipped(1, (const float[4][3]){{0, 1, -2}}), 0);
    /* The length of a line's coefficients does not matter. */
    assert_int_equal(count_clipped(1, (const float[4][3]){{30, 40, 5}}),
                     count_clipped(1, (const float[4][3]){{0.6f, 0.8f, 0.1f}}));
    /* The square |u|, |v| <= 1/2 has a side of radius: its number of pixels is exact up to its
     * border. */
    double radius = 1.5 * FOCAL / DISTANCE;
    size_t square = count_clipped(
        4, (const float[4][3]){{1, 0, 0.5f}, {-1, 0, 0.5f}, {0, 1, 0.5f}, {0, -1, 0.5f}});
    assert_near((double)square, radius * radius, 4 * radius);
}

/* The floor lies 0.01 under the eye, with its centre under the eye: there are fragments from the
 * near plane to the rim. */
static void test_eye_inside(void **state) {
    (void)state;
    const double under = 0.01, radius = 10;
    scene s = scene_disc((float)radius);
    s.material.double_sided = 1;
    turn(&s.splats[0], (double[]){1, 0, 0}, (double[]){0, 0, -1});
    s.splats[0].center[2] = (float)DISTANCE;
    double transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -under, 0, 1};
    psplat_view view = front_view();
    picture p = picture_of(&s, transform, &view);
    size_t covered = 0;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            double distance = -under / ray_y(y);
            double u = ray_x(x) * distance / radius, v = distance / radius;
            assert_pixel(&p, x, y, u, v, distance);
            covered += p.image.count[y * WIDTH + x];
        }
    assert_true(covered >= WIDTH); /* rows dy = -0.005 and -0.015: s = 2 and 0.67 */
    picture_free(&p);
    scene_free(&s);
}

/* A wall passes the eye at x = 0.5 and goes on behind it: its centre lies behind the eye, its rim 3
 * in front of it. */
static void test_near_crossing(void **state) {
    (void)state;
    const double aside = 0.5, behind = 1;
    scene s = scene_disc(4);
    s.material.double_sided = 1;
    turn(&s.splats[0], (double[]){0, 0, -1}, (double[]){0, 1, 0});
    s.splats[0].center[0] = (float)aside;
    s.splats[0].center[2] = (float)(DISTANCE + behind);
    psplat_view view = front_view();
    picture p = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            double distance = aside / ray_x(x);
            double u = (distance + behind) / 4, v = ray_y(y) * distance / 4;
            assert_pixel(&p, x, y, u, v, distance);
        }
    assert_true(picture_covered(&p) > 1000);
    picture_free(&p);
    scene_free(&s);
}

/* Nothing is drawn before the near plane or behind the far plane. */
static void test_near_and_far(void **state) {
    (void)state;
    const double heights[] = {DISTANCE - NEAR - 1e-9, DISTANCE - NEAR + 1e-9, DISTANCE - FAR - 1e-9,
                              DISTANCE - FAR + 1e-9};
    const int seen[] = {1, 0, 0, 1};
    for (int i = 0; i < 4; ++i) {
        scene s = scene_disc(0.25f);
        double transform[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, heights[i], 1};
        psplat_view view = front_view();
        picture p = picture_of(&s, transform, &view);
        assert_int_equal(picture_covered(&p) > 0, seen[i]);
        /* The depth tie shows it: 1e-9 of distance is 2.05e-9 of window depth at the near plane. */
        assert_true(p.image.depth_tie[HEIGHT / 2 * WIDTH + WIDTH / 2] < 3e-9);
        picture_free(&p);
        scene_free(&s);
    }
}

static void test_parallel_view(void **state) {
    (void)state;
    const double half = 3, pixel = 2 * half / HEIGHT;
    scene s = scene_disc(2);
    s.splats[0].radius[1] = 1;
    psplat_view view = front_view();
    camera_parallel(&view, half, NEAR, FAR);
    picture p = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            int at = y * WIDTH + x;
            double u = (x + 0.5 - WIDTH / 2.0) * pixel / 2, v = (y + 0.5 - HEIGHT / 2.0) * pixel;
            assert_int_equal(p.image.count[at], u * u + v * v <= 1);
            if (!p.image.count[at]) continue;
            assert_near(p.image.uv[2 * at], u, ROUNDING);
            assert_near(p.image.uv[2 * at + 1], v, ROUNDING);
            assert_near(p.image.depth[at], (DISTANCE - NEAR) / (FAR - NEAR), ROUNDING);
        }
    picture_free(&p);
    scene_free(&s);
}

/* Any invertible projection is allowed: a perspective one that is off-centre, scaled as a whole and
 * with z sheared by x shows the same fragments as the plain one, moved by the off-centre pixels. */
static void test_unusual_projection(void **state) {
    (void)state;
    const int shift = 7;
    scene s = scene_disc(1.5f);
    psplat_view view = front_view();
    picture plain = picture_of(&s, NULL, &view);
    view.projection[8] = -2.0 * shift / WIDTH;
    view.projection[2] = 0.01;
    for (int i = 0; i < 16; ++i) view.projection[i] *= 3;
    picture moved = picture_of(&s, NULL, &view);
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = shift; x < WIDTH; ++x) {
            int from = y * WIDTH + x - shift, to = y * WIDTH + x;
            assert_int_equal(moved.image.count[to], plain.image.count[from]);
            assert_near(moved.image.uv[2 * to], plain.image.uv[2 * from], ROUNDING);
        }
    picture_free(&plain);
    picture_free(&moved);
    scene_free(&s);
}

/* A projection that exchanges x and y, whose matrix has zeros on its diagonal, transposes the
 * image. */
static void test_transposing_projection(void **state) {
    (void)state;
    scene s = scene_disc(1.5f);
    s.splats[0].radius[1] = 0.75f;
    psplat_view view = front_view();
    view.width = view.height = 80;
    camera_perspective(&view, FOCAL, NEAR, FAR);
    picture plain = picture_of(&s, NULL, &view);
    view.projection[1] = view.projection[0];
    view.projection[4] = view.projection[5];
    view.projection[0] = view.projection[5] = 0;
    picture transposed = picture_of(&s, NULL, &view);
    assert_true(picture_covered(&plain) > 1000);
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 80; ++x) {
            int from = y * 80 + x, to = x * 80 + y;
            assert_int_equal(transposed.image.count[to], plain.image.count[from]);
            assert_near(transposed.image.uv[2 * to], plain.image.uv[2 * from], ROUNDING);
        }
    picture_free(&plain);
    picture_free(&transposed);
    scene_free(&s);
}

/* The ties of a disc's pixels are their distances from its rim, in pixels or in (u, v). */
static void test_ties(void **state) {
    (void)state;
    const float radii[] = {1.5f, 0.02f}; /* 30 pixels and 0.4 pixels */
    for (int i = 0; i < 2; ++i) {
        scene s = scene_disc(radii[i]);
        psplat_view view = front_view();
        view.width = WIDTH + 1; /* so that a pixel's centre is in the middle */
        camera_perspective(&view, FOCAL, NEAR, FAR);
        picture p = picture_of(&s, NULL, &view);
        double pixels = (double)radii[i] * FOCAL / DISTANCE;
        for (int y = HEIGHT / 2 - 35; y < HEIGHT / 2 + 35; ++y)
            for (int x = WIDTH / 2 - 35; x <= WIDTH / 2 + 35; ++x) {
                double tie = p.image.tie[y * view.width + x];
                double r = hypot(x - WIDTH / 2.0, y + 0.5 - HEIGHT / 2.0) / pixels;
                double expected = fmin(fabs(1 - r), fabs(1 - r) * pixels);
                /* Pixels further than a pixel outside need not be looked at. */
                if (tie < 1 || r <= 1) assert_near(tie, expected, 1e-9);
                if (tie == 1) assert_true((r - 1) * pixels > 1);
            }
        picture_free(&p);
        scene_free(&s);
    }
}

static void test_bad_arguments(void **state) {
    (void)state;
    scene s = scene_disc(1);
    psplat_asset *asset = scene_open(&s);
    psplat_environment_desc empty = {NULL, 4};
    psplat_reference_scene given = {.asset = asset}, nothing = {0}, dark = {.asset = asset};
    dark.environment = &empty;
    psplat_reference_image image = {0};
    psplat_view good = front_view();
    psplat_error error;
    const struct {
        const psplat_reference_scene *scene;
        const psplat_view *view;
        psplat_reference_image *image;
    } missing[] = {{NULL, &good, &image},
                   {&nothing, &good, &image},
                   {&given, NULL, &image},
                   {&given, &good, NULL},
                   {&dark, &good, &image}};
    for (int i = 0; i < 5; ++i)
        assert_int_equal(psplat_reference_draw(missing[i].scene, missing[i].view, missing[i].image,
                                               i % 2 ? NULL : &error),
                         PSPLAT_ERROR_ARGUMENT);
    psplat_view bad[9];
    for (int i = 0; i < 9; ++i) bad[i] = good;
    bad[0].width = 0;
    bad[1].height = -3;
    bad[2].mode = PSPLAT_MODE_COUNT;
    memset(bad[3].projection, 0, sizeof bad[3].projection);
    bad[4].projection[5] = NAN;
    bad[5].shading = PSPLAT_SHADING_COUNT;
    bad[6].light_count = -1;
    bad[7].light_count = PSPLAT_MAX_LIGHTS + 1;
    bad[8].lights[0].type = (psplat_light_type)3;
    for (int i = 0; i < 9; ++i) {
        assert_int_equal(psplat_reference_draw(&given, &bad[i], &image, &error),
                         PSPLAT_ERROR_ARGUMENT);
        assert_int_equal(error.code, PSPLAT_ERROR_ARGUMENT);
        assert_true(strlen(error.text) > 10);
    }
    assert_int_equal(psplat_reference_draw(&given, &good, &image, NULL), PSPLAT_OK);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* Views are refused whose colours the renderer chooses itself. */
static void test_unsupported(void **state) {
    (void)state;
    scene s = scene_disc(1);
    psplat_asset *asset = scene_open(&s);
    psplat_reference_scene given = {.asset = asset};
    psplat_reference_image image = {0};
    for (int shading = 0; shading < PSPLAT_SHADING_COUNT; ++shading)
        for (int linear = 0; linear < 2; ++linear) {
            psplat_view view = front_view();
            view.shading = (psplat_shading)shading;
            view.linear_output = linear;
            int known = shading != PSPLAT_SHADING_TOON && shading != PSPLAT_SHADING_SPLATS &&
                        (shading != PSPLAT_SHADING_OVERDRAW || linear);
            assert_int_equal(psplat_reference_draw(&given, &view, &image, NULL),
                             known ? PSPLAT_OK : PSPLAT_ERROR_UNSUPPORTED);
        }
    psplat_asset_destroy(asset);
    scene_free(&s);
}

int test_reference_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_facing_disc),
        cmocka_unit_test(test_tilted_disc),
        cmocka_unit_test(test_edge_on),
        cmocka_unit_test(test_clip_lines),
        cmocka_unit_test(test_eye_inside),
        cmocka_unit_test(test_near_crossing),
        cmocka_unit_test(test_near_and_far),
        cmocka_unit_test(test_parallel_view),
        cmocka_unit_test(test_unusual_projection),
        cmocka_unit_test(test_transposing_projection),
        cmocka_unit_test(test_ties),
        cmocka_unit_test(test_bad_arguments),
        cmocka_unit_test(test_unsupported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
