/* SPDX-License-Identifier: MIT
 *
 * test_reference_lights.c - tests lights and shadows of the reference rasteriser (spec 5.6, eq.
 * (8)) against hand-computed falloffs: a light that gives irradiance E at a point lights it as a
 * directional light of E from the same direction does.
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

#define COLOR_STEP 2e-6 /* lights and colours are floats; colours here are at most 10 */

/* One pixel sees the middle of a large disc at z = 0, along -z from z = 5 in a parallel view. */
static psplat_view pixel_view(void) {
    psplat_view view = camera_view(1, 1);
    camera_look(&view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_parallel(&view, 0.001, 1, 10);
    return view;
}

static psplat_light directional(double x, double y, double z, double illuminance) {
    psplat_light light = {.type = PSPLAT_LIGHT_DIRECTIONAL};
    const double to_light[3] = {x, y, z};
    for (int i = 0; i < 3; ++i) {
        light.direction[i] = (float)-to_light[i];
        light.color[i] = (float)illuminance * (float[]){1, 0.5f, 0.25f}[i];
    }
    return light;
}

static psplat_light positional(psplat_light_type type, double x, double y, double z,
                               double intensity) {
    psplat_light light = directional(x, y, z, intensity); /* shines at the origin */
    light.type = type;
    light.position[0] = x, light.position[1] = y, light.position[2] = z;
    return light;
}

static void color_under(const scene *s, const psplat_view *view, double color[3]) {
    picture p = picture_of(s, NULL, view);
    assert_int_equal(p.image.color[3], 1);
    for (int i = 0; i < 3; ++i) color[i] = (double)p.image.color[i];
    picture_free(&p);
}

/* Expects the same colour under the lights of both views. */
static void check_alike(const scene *s, const psplat_view *a, const psplat_view *b) {
    double color[2][3];
    color_under(s, a, color[0]);
    color_under(s, b, color[1]);
    for (int i = 0; i < 3; ++i) assert_near(color[0][i], color[1][i], COLOR_STEP);
}

/* Compares a light with a directional one from (x, y, z) of the given illuminance. */
static void check_light(psplat_light light, double x, double y, double z, double illuminance) {
    scene s = scene_disc(10);
    psplat_view view = pixel_view(), expected = view;
    view.lights[0] = light;
    expected.lights[0] = directional(x, y, z, illuminance);
    check_alike(&s, &view, &expected);
    view.mode = expected.mode = PSPLAT_MODE_GAUSSIAN;
    check_alike(&s, &view, &expected);
    view.mode = expected.mode = PSPLAT_MODE_FLAT;
    check_alike(&s, &view, &expected);
    scene_free(&s);
}

/* ---- falloff --------------------------------------------------------------------------------- */

static void test_point(void **state) {
    (void)state;
    check_light(positional(PSPLAT_LIGHT_POINT, 0, 0, 2, 8), 0, 0, 1, 2);
    check_light(positional(PSPLAT_LIGHT_POINT, 2, 1, 2, 9), 2, 1, 2, 1); /* the distance is 3 */
    psplat_light light = positional(PSPLAT_LIGHT_POINT, 0, 0, 2, 8);
    light.range = 4; /* 1 - (2/4)^4 = 15/16 */
    check_light(light, 0, 0, 1, 2 * 15.0 / 16);
    light.range = 2;
    check_light(light, 0, 0, 1, 0);
    light.range = 1.5f;
    check_light(light, 0, 0, 1, 0);
    light.range = 0;
    light.position[2] = -2; /* from behind */
    check_light(light, 0, 0, 1, 0);
}

static void test_spot(void **state) {
    (void)state;
    const double degree = CAMERA_PI / 180;
    psplat_light light = positional(PSPLAT_LIGHT_SPOT, 0, 0, 2, 8);
    check_light(light, 0, 0, 1, 2); /* on the axis */
    for (int angle = 0; angle < 90; angle += 6) {
        double inner = cos(20 * degree), outer = cos(40 * degree), at = cos(angle * degree);
        double s = fmin(fmax((at - outer) / (inner - outer), 0), 1);
        light.inner_angle = (float)(20 * degree);
        light.outer_angle = (float)(40 * degree);
        light.direction[0] = (float)(3 * sin(angle * degree)); /* of any length */
        light.direction[2] = (float)(-3 * cos(angle * degree));
        check_light(light, 0, 0, 1, 2 * s * s);
        light.inner_angle = light.outer_angle = 0; /* 45 degrees; full only on the axis */
        s = fmax((at - cos(45 * degree)) / (1 - cos(45 * degree)), 0);
        check_light(light, 0, 0, 1, 2 * s * s);
    }
}

/* Cones narrower than the specification's 0.001 nevertheless end softly. */
static void test_narrow_spot(void **state) {
    (void)state;
    psplat_light light = positional(PSPLAT_LIGHT_SPOT, 0, 0, 2, 8);
    light.inner_angle = 0.01f;
    light.outer_angle = 0.02f; /* the cosines differ by 0.00015 */
    double s = (1 - cos(0.02)) / 0.001;
    check_light(light, 0, 0, 1, 2 * s * s);
}

/* Lights add up; those beyond light_count do not shine. */
static void test_several(void **state) {
    (void)state;
    scene s = scene_disc(10);
    psplat_view view = pixel_view();
    double sum[3] = {0, 0, 0}, color[3];
    for (int k = 0; k < PSPLAT_MAX_LIGHTS; ++k) {
        psplat_view one = pixel_view();
        one.lights[0] =
            k % 2 ? directional(k, 1, 4, 0.5)
                  : positional(k % 4 ? PSPLAT_LIGHT_POINT : PSPLAT_LIGHT_SPOT, 1, k, 3, 4);
        view.lights[k] = one.lights[0];
        view.light_count = k + 1;
        color_under(&s, &one, color);
        for (int i = 0; i < 3; ++i) sum[i] += color[i];
        color_under(&s, &view, color);
        for (int i = 0; i < 3; ++i) assert_near(color[i], sum[i], COLOR_STEP);
    }
    view.light_count = 0;
    color_under(&s, &view, color);
    assert_near(color[0], 0, 0);
    scene_free(&s);
}

/* ---- where the pixel is ---------------------------------------------------------------------- */

/* Two discs a unit apart blend in a perspective view. In Phong mode the distance of the light
 * follows from the mean of their window depths; in Gaussian mode each disc has its own distance. */
static void test_position(void **state) {
    (void)state;
    scene s = scene_blank(2);
    s.depth_tolerance = 10;
    s.splats[1].center[2] = -1;
    for (int i = 0; i < 2; ++i) s.splats[i].radius[0] = s.splats[i].radius[1] = 100;
    psplat_view view = pixel_view();
    camera_perspective(&view, 1, 1, 10);
    view.lights[0] = positional(PSPLAT_LIGHT_POINT, 0, 0, 3, 5);
    psplat_view expected = view;
    /* Window depth is linear in 1 / distance: the mean of 5 and 6 is 2 / (1/5 + 1/6) = 60/11. */
    double distance = 3 - (5 - 60.0 / 11);
    expected.lights[0] = directional(0, 0, 1, 5 / (distance * distance));
    check_alike(&s, &view, &expected);
    view.mode = expected.mode = PSPLAT_MODE_GAUSSIAN;
    expected.lights[0] = directional(0, 0, 1, (5 / 9.0 + 5 / 16.0) / 2);
    check_alike(&s, &view, &expected);
    view.mode = expected.mode = PSPLAT_MODE_FLAT;
    expected.lights[0] = directional(0, 0, 1, 5 / 9.0);
    check_alike(&s, &view, &expected);
    scene_free(&s);
}

/* Lights are placed in the scene, whatever the view: seen from another place and turned, a pixel's
 * point has the distances of plain geometry. */
static void test_scene_space(void **state) {
    (void)state;
    scene s = scene_disc(10);
    psplat_view view = pixel_view();
    camera_look(&view, (double[]){3, 4, 5}, (double[]){1, 0.5, 0});
    camera_perspective(&view, 400, 1, 20);
    view.lights[0] = positional(PSPLAT_LIGHT_SPOT, 2, 0.5, 2, 10); /* sqrt(5) from (1, .5) */
    for (int i = 0; i < 3; ++i) view.lights[0].direction[i] = (float[]){-1, 0, -2}[i];
    psplat_view expected = view;
    expected.lights[0] = directional(1, 0, 2, 2);
    check_alike(&s, &view, &expected);
    scene_free(&s);
}

/* ---- shadows --------------------------------------------------------------------------------- */

#define SIZE 48

/* Returns a floor at z = 0 and a disc of radius 0.5 over it, at (0.3, -0.2, height). Only the
 * floor's splat is seen, from below the disc. */
static scene shadow_scene(double height) {
    scene s = scene_blank(2);
    s.material.double_sided = 1;
    s.depth_tolerance = 0.01f;
    s.splats[0].radius[0] = s.splats[0].radius[1] = 100;
    psplat_splat *disc = &s.splats[1];
    disc->center[0] = 0.3f, disc->center[1] = -0.2f, disc->center[2] = (float)height;
    disc->radius[0] = disc->radius[1] = 0.5f;
    return s;
}

static psplat_view shadow_view(psplat_light light, double height) {
    psplat_view view = camera_view(SIZE, SIZE);
    camera_look(&view, (double[]){0, 0, 5}, (double[]){0, 0, 0});
    camera_parallel(&view, 2, 5 - height * 0.5, 10); /* the near plane is under the disc */
    view.lights[0] = light;
    view.lights[0].casts_shadow = 1;
    return view;
}

/* Computes where the ray from pixel i's point to the light crosses the disc's plane, relative to
 * the disc's centre. */
static void crossing(const psplat_light *light, int i, double height, double out[2]) {
    double at[3] = {(i % SIZE + 0.5) / SIZE * 4 - 2, (i / SIZE + 0.5) / SIZE * 4 - 2, 0}, to[3];
    for (int k = 0; k < 3; ++k)
        to[k] = light->type == PSPLAT_LIGHT_DIRECTIONAL ? -(double)light->direction[k]
                                                        : light->position[k] - at[k];
    out[0] = at[0] + to[0] * height / to[2] - 0.3;
    out[1] = at[1] + to[1] * height / to[2] + 0.2;
}

/* clip keeps the part of the disc whose x is at least that of its centre. */
static size_t check_shadow(psplat_light light, double height, int clip) {
    scene s = shadow_scene(height);
    if (clip) s.splats[1].clip_count = 1, s.splats[1].clip[0][0] = 1;
    psplat_view view = shadow_view(light, height), bright = view;
    bright.lights[0].casts_shadow = 0;
    picture p = picture_of(&s, NULL, &view), q = picture_of(&s, NULL, &bright);
    size_t dark = 0;
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double at[2];
        crossing(&light, i, height, at);
        double r = hypot(at[0], at[1]);
        if (fabs(r - 0.5) < 1e-6 || fabs(at[0]) < 1e-6) continue;
        int is_dark = r < 0.5 && !(clip && at[0] < 0);
        assert_near((double)p.image.color[4 * i], is_dark ? 0 : (double)q.image.color[4 * i],
                    COLOR_STEP);
        dark += (size_t)is_dark;
    }
    picture_free(&p);
    picture_free(&q);
    scene_free(&s);
    return dark;
}

static void test_shadows(void **state) {
    (void)state;
    for (int clip = 0; clip < 2; ++clip) {
        size_t least = clip ? 40 : 80; /* a disc of 0.5 covers 113 pixels */
        assert_true(check_shadow(directional(0, 0, 1, 1), 1, clip) > least);
        assert_true(check_shadow(directional(0.7, 0.4, 1, 1), 1, clip) > least);
        psplat_light spot = positional(PSPLAT_LIGHT_SPOT, 0.5, -0.4, 3, 9);
        spot.outer_angle = 1.5f;
        assert_true(check_shadow(spot, 1, clip) > least);
    }
    /* A light under the disc is not shadowed by the disc, which lies behind it. */
    psplat_light low = positional(PSPLAT_LIGHT_SPOT, 0.5, -0.4, 0.8, 9);
    scene s = shadow_scene(1);
    psplat_view view = shadow_view(low, 1), bright = view;
    bright.lights[0].casts_shadow = 0;
    check_alike(&s, &view, &bright);
    scene_free(&s);
}

static double middle_light(const scene *s, const psplat_view *view) {
    picture p = picture_of(s, NULL, view);
    double value = (double)p.image.color[4 * (22 * SIZE + 27)]; /* under the disc */
    picture_free(&p);
    return value;
}

/* What lies nearer to the point than epsilon, divided by the cosine to the light, casts no
 * shadow. */
static void test_shadow_epsilon(void **state) {
    (void)state;
    const struct {
        double x, factor; /* factor: 1 / max(cos, 1/2) */
    } slants[] = {{0, 1}, {1, 1.41421356}, {2, 2}, {3, 2}};
    for (int k = 0; k < 4; ++k)
        for (int beyond = 0; beyond < 2; ++beyond) {
            /* Along a ray to the light, a gap h is h sqrt(1 + x x) long. */
            double length = sqrt(1 + slants[k].x * slants[k].x), epsilon = 0.05;
            double height = epsilon * slants[k].factor / length * (beyond ? 1.02 : 0.98);
            scene s = shadow_scene(height);
            s.depth_tolerance = (float)epsilon;
            psplat_view view = shadow_view(directional(slants[k].x, 0, 1, 1), height);
            assert_true((middle_light(&s, &view) == 0) == beyond);
            scene_free(&s);
        }
}

/* The first four of the lights that may cast shadows do; point lights do not. */
static void test_shadow_count(void **state) {
    (void)state;
    scene s = shadow_scene(1);
    psplat_view view = shadow_view(directional(0, 0, 1, 1), 1);
    for (int k = 1; k < PSPLAT_MAX_SHADOWS; ++k) view.lights[k] = view.lights[0];
    view.light_count = PSPLAT_MAX_SHADOWS;
    assert_near(middle_light(&s, &view), 0, 0);
    view.lights[view.light_count++] = view.lights[0];
    assert_true(middle_light(&s, &view) > 0);
    view.lights[4].casts_shadow = 0;
    assert_true(middle_light(&s, &view) > 0);
    view.lights[1].casts_shadow = 0;
    view.lights[4].casts_shadow = 1;
    view.lights[1].color[0] = 0;
    assert_near(middle_light(&s, &view), 0, 0);
    view.light_count = 1;
    view.lights[0] = positional(PSPLAT_LIGHT_POINT, 0.3, -0.2, 3, 9);
    view.lights[0].casts_shadow = 1;
    assert_true(middle_light(&s, &view) > 0);
    scene_free(&s);
}

int test_reference_lights_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_point),        cmocka_unit_test(test_spot),
        cmocka_unit_test(test_narrow_spot),  cmocka_unit_test(test_several),
        cmocka_unit_test(test_position),     cmocka_unit_test(test_scene_space),
        cmocka_unit_test(test_shadows),      cmocka_unit_test(test_shadow_epsilon),
        cmocka_unit_test(test_shadow_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
