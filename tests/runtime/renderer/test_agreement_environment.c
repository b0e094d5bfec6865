/* SPDX-License-Identifier: MIT
 *
 * test_agreement_environment.c - tests that under an environment the renderer, whose maps are
 * prefiltered, shows what the reference rasteriser integrates pixel by pixel (spec 5.6, eq. (9)),
 * on a sphere.
 */
#include "agreement.h"
#include "scene_asset.h"

#include <phongsplat/host.h>

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "extreme.h"

#define TEXELS 32

/* As in test_agreement.c. */
static const agreement_ties ordinary = {2e-4, 2e-6, 0.015};

/* Fills the cube with R between 0 and 1.1: constant, or a polynomial of degree 2 in the direction,
 * a different one in each channel and without symmetry. */
static void fill(float *texels, int is_constant) {
    for (int i = 0; i < 6 * TEXELS * TEXELS; ++i) {
        double s = (i % TEXELS + 0.5) / TEXELS * 2 - 1;
        double t = (i / TEXELS % TEXELS + 0.5) / TEXELS * 2 - 1;
        const double directions[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                         {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
        const double *l = directions[i / TEXELS / TEXELS];
        double length2 = 1 + s * s + t * t, length = sqrt(length2);
        texels[3 * i] = (float)(0.6 + 0.3 * l[0] / length + 0.2 * l[1] * l[2] / length2);
        texels[3 * i + 1] = (float)(0.5 + 0.4 * l[1] / length);
        texels[3 * i + 2] = (float)(0.4 + 0.5 * l[2] * l[2] / length2);
        for (int k = 0; k < 3 && is_constant; ++k) texels[3 * i + k] = 1;
    }
}

/* Draws a sphere from above, which has normals and reflections in most directions, many of them
 * grazing. */
static void check(gpu *g, float metallic, float roughness, int is_constant, double bound) {
    static float texels[6 * TEXELS * TEXELS * 3];
    const psplat_environment_desc cube = {texels, TEXELS};
    scene s = scene_sphere(200, 1);
    s.material.metallic = metallic;
    s.material.roughness = roughness;
    s.material.base_color[1] = 0.7f;
    fill(texels, is_constant);
    psplat_asset *asset = scene_open(&s);
    psplat_reference_scene scene = {.asset = asset, .environment = &cube};
    psplat_view view = camera_view(20, 15);
    view.light_count = view.no_filter = 0;
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 20, 0.3, 10);
    agreement a = agreement_measure_scene(g, &scene, &view, 1, &ordinary);
    print_message("metallic %g, roughness %.1f, %s: covered %zu skipped %zu color %.1e\n",
                  (double)metallic, (double)roughness, is_constant ? "constant" : "smooth",
                  a.covered, a.skipped, a.color);
    psplat_asset_destroy(asset);
    scene_free(&s);
    assert_true(a.covered > 100 && a.skipped * 10 < a.covered);
    assert_int_equal(a.mismatches, 0);
    assert_true(a.color <= bound);
}

/* Only a and b matter here. They come from a table of 32 by 32, which is coarse for a mirror at
 * half a degree from grazing. */
static void test_constant(void **state) {
    check(*state, 1, 0, 1, 2e-2);
    check(*state, 1, 0.3f, 1, 1e-2);
    check(*state, 1, 1, 1, 6e-3);
}

/* The renderer interpolates between 5 lobes, on cubes of 64 to 4 texels. */
static void test_smooth(void **state) {
    check(*state, 0, 0.4f, 0, 1e-2);
    check(*state, 1, 0.1f, 0, 2e-2);
    check(*state, 1, 0.8f, 0, 2e-2);
}

static void test_dielectric(void **state) {
    check(*state, 0, 0.4f, 0, 1e-2);
}

/* The greatest light that a float holds shines from behind a surface: none of it comes through. */
static void test_most_radiance(void **state) {
    gpu *g = *state;
    enum { SIZE = 8 };
    static float texels[6 * TEXELS * TEXELS * 3], rgba[SIZE * SIZE * 4];
    const psplat_environment_desc cube = {texels, TEXELS};
    psplat_environment *environment = NULL;
    psplat_error error;
    memset(texels, 0, sizeof texels);
    for (size_t i = 0; i < 3 * TEXELS * TEXELS; ++i)
        texels[5 * 3 * TEXELS * TEXELS + i] = FLT_MAX; /* the face -z */
    scene s = scene_disc(10);
    s.material.roughness = 1;
    s.material.double_sided = 1;
    psplat_asset *asset = scene_open(&s);
    psplat_item item = {.model = NULL};
    assert_int_equal(psplat_model_create(g->renderer, asset, &item.model, &error), 0);
    assert_int_equal(psplat_environment_create(g->renderer, &cube, &environment, &error), 0);
    for (int side = -1; side <= 1; side += 2) {
        psplat_view view = camera_view(SIZE, SIZE);
        view.light_count = 0;
        view.environment = environment;
        camera_look(&view, (double[]){0, 0, 3.0 * side}, (double[]){0, 0, 0});
        camera_perspective(&view, 20, 0.3, 10);
        assert_int_equal(psplat_host_begin(g->host, SIZE, SIZE, 1, (float[4]){0}, &error), 0);
        assert_int_equal(psplat_draw(g->renderer, &view, &item, 1, &error), 0);
        assert_int_equal(psplat_host_read_float(g->host, rgba, &error), 0);
        float most = 0;
        for (int i = 0; i < SIZE * SIZE; ++i)
            most = rgba[4 * i] <= most ? most : rgba[4 * i]; /* a NaN replaces every number */
        extreme_at_most(side > 0 ? "radiance 3.4e38 behind a surface" : "radiance 3.4e38 before it",
                        (double)most, "of white", side > 0 ? 0 : 65504);
        assert_true(side > 0 || most > 1000);
    }
    psplat_environment_destroy(g->renderer, environment);
    psplat_model_destroy(g->renderer, item.model);
    psplat_asset_destroy(asset);
    scene_free(&s);
}

/* A cube map without texels, or with radiance that is no light, is refused. */
static void test_refused(void **state) {
    const gpu *g = *state;
    float texels[18] = {0};
    const float wrong[] = {-1, NAN, INFINITY};
    psplat_environment *environment = NULL;
    psplat_environment_desc desc = {.radiance = texels, .size = 0};
    psplat_error error = {0};
    assert_int_equal(psplat_environment_create(g->renderer, &desc, &environment, &error),
                     PSPLAT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "0 texels"));
    desc.size = 1;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        texels[17] = wrong[i];
        assert_int_equal(psplat_environment_create(g->renderer, &desc, &environment, &error),
                         PSPLAT_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "radiance 17"));
    }
    desc.radiance = NULL;
    assert_int_equal(psplat_environment_create(g->renderer, &desc, &environment, NULL),
                     PSPLAT_ERROR_ARGUMENT);
    assert_null(environment);
}

int test_agreement_environment_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constant), cmocka_unit_test(test_smooth),
        cmocka_unit_test(test_most_radiance), cmocka_unit_test(test_refused)};
    const struct CMUnitTest gles_tests[] = {cmocka_unit_test(test_dielectric)};
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
