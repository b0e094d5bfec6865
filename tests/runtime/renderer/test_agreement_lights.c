/* SPDX-License-Identifier: MIT
 *
 * test_agreement_lights.c - tests that under point, spot and several lights and in the debug views
 * the renderer shows what the reference rasteriser shows (spec 5.6).
 */
#include "agreement.h"
#include "scene_asset.h"

#include <phongsplat/host.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#define WIDTH 120
#define HEIGHT 90

/* The ties are those of test_agreement.c; BOUND_FLOAT bounds colours. */
static const agreement_ties ordinary = {2e-4, 2e-6, 0.015};
#define BOUND_FLOAT 1e-4

static void assert_agrees(const char *name, const agreement *a, double bound, size_t least) {
    print_message("%-40s covered %5zu skipped %3zu color %.1e\n", name, a->covered, a->skipped,
                  a->color);
    assert_true(a->covered >= least && a->skipped * 10 < a->covered);
    assert_int_equal(a->mismatches, 0);
    assert_true(a->color <= bound);
}

static psplat_view view_of(int is_parallel) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    view.no_filter = 0;
    view.ambient[0] = 0.1f;
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 90, 0.3, 10);
    if (is_parallel) camera_parallel(&view, 1.5, 1, 8);
    return view;
}

static void check(gpu *g, const char *name, const psplat_reference_scene *scene, psplat_view view,
                  double bound) {
    for (int mode = PSPLAT_MODE_PHONG; mode <= PSPLAT_MODE_FLAT; ++mode) {
        char text[96];
        view.mode = (psplat_mode)mode;
        agreement a = agreement_measure_scene(g, scene, &view, 1, &ordinary);
        snprintf(text, sizeof text, "%s, mode %d", name, mode);
        assert_agrees(text, &a, bound, 1000);
    }
}

/* ---- lights ---------------------------------------------------------------------------------- */

/* Returns a light outside the scene, at 2 to 3 from its middle, on the eye's side, which gives an
 * irradiance of about 1 there. */
static psplat_light light_of(psplat_light_type type, uint32_t *random) {
    psplat_light light = {.type = type};
    double length = 0, distance = 2 + (double)scene_random(random);
    for (int i = 0; i < 3; ++i) {
        light.position[i] = (double)scene_random(random) - 0.2;
        length += light.position[i] * light.position[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; ++i) {
        light.position[i] *= distance / length;
        light.direction[i] = (float)-light.position[i] + 0.3f * scene_random(random);
        light.color[i] = scene_random(random) * (type ? 3 : 1);
    }
    light.range = scene_random(random) < 0.5f ? 4 : 0;
    light.outer_angle = type == PSPLAT_LIGHT_SPOT ? 0.2f + 0.5f * scene_random(random) : 0;
    light.inner_angle = 0.5f * light.outer_angle * scene_random(random);
    return light;
}

static void test_lights(void **state) {
    uint32_t random = 17;
    scene scenes[2] = {scene_sphere(400, 1), scene_ellipses(300, 4, 7)};
    for (int k = 0; k < 2; ++k) {
        scenes[k].material.metallic = 0.4f;
        scenes[k].material.roughness = k ? 0.6f : 0.3f; /* normals of slanted splats err more */
        psplat_asset *asset = scene_open(&scenes[k]);
        psplat_reference_scene scene = {.asset = asset};
        for (int type = PSPLAT_LIGHT_DIRECTIONAL; type <= PSPLAT_LIGHT_SPOT; ++type)
            for (int is_parallel = 0; is_parallel < 2; ++is_parallel) {
                char name[64];
                psplat_view view = view_of(is_parallel);
                view.light_count = 1 + type + 4 * is_parallel;
                for (int i = 0; i < view.light_count; ++i)
                    view.lights[i] = light_of((psplat_light_type)type, &random);
                snprintf(name, sizeof name, "%d lights of type %d", view.light_count, type);
                check(*state, name, &scene, view, BOUND_FLOAT);
            }
        psplat_asset_destroy(asset);
        scene_free(&scenes[k]);
    }
}

/* Eight lights of all kinds at once, in a scene a million units from the origin. */
static void test_eight_lights(void **state) {
    uint32_t random = 5;
    const double at[3] = {1e6, -2e6, 3e6};
    scene s = scene_sphere(400, 1);
    psplat_view view = view_of(0);
    for (int i = 0; i < 3; ++i) s.origin[i] = at[i];
    camera_look(&view, (double[]){at[0] + 1, at[1] + 2, at[2] + 3}, at);
    view.light_count = PSPLAT_MAX_LIGHTS;
    for (int i = 0; i < PSPLAT_MAX_LIGHTS; ++i) {
        view.lights[i] = light_of((psplat_light_type)(i % 3), &random);
        for (int k = 0; k < 3; ++k) view.lights[i].position[k] += at[k];
    }
    psplat_asset *asset = scene_open(&s);
    psplat_reference_scene scene = {.asset = asset};
    check(*state, "8 lights far from the origin", &scene, view, BOUND_FLOAT);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* ---- debug views ----------------------------------------------------------------------------- */

static void test_shadings(void **state) {
    const psplat_shading shadings[] = {PSPLAT_SHADING_UNLIT, PSPLAT_SHADING_NORMAL,
                                       PSPLAT_SHADING_DEPTH, PSPLAT_SHADING_OVERDRAW};
    const char *names[] = {"unlit", "normal", "depth", "overdraw"};
    scene scenes[2] = {scene_sphere(400, 1), scene_ellipses(300, 4, 7)};
    for (int k = 0; k < 8; ++k) {
        /* The weights of splats within 0.1 degrees of edge-on have three digits fewer. */
        double bound = k / 4 ? 10 * BOUND_FLOAT : BOUND_FLOAT;
        psplat_asset *asset = scene_open(&scenes[k / 4]);
        psplat_reference_scene scene = {.asset = asset};
        for (int linear = k % 4 == 3; linear < 2; ++linear) {
            psplat_view view = view_of(linear);
            view.shading = shadings[k % 4];
            view.linear_output = linear;
            check(*state, names[k % 4], &scene, view, bound);
        }
        psplat_asset_destroy(asset);
    }
    for (int k = 0; k < 2; ++k) scene_free(&scenes[k]);
}

int test_agreement_lights_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lights),
        cmocka_unit_test(test_eight_lights),
        cmocka_unit_test(test_shadings),
    };
    const struct CMUnitTest gles_tests[] = {
        cmocka_unit_test(test_eight_lights),
        cmocka_unit_test(test_shadings),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
