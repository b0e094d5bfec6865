/* SPDX-License-Identifier: MIT
 *
 * test_agreement_seams.c - tests that the renderer draws seams (spec 3.6) as the reference
 * rasteriser does: straight and bent ones beside lines that cut, on textured splats, flat and
 * curved, with the filter and without, with a normal texture, in all modes, lit and in shadow.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "agreement.h"
#include "scene_asset.h"

#include <math.h>
#include <stdlib.h>

enum { WIDTH = 96, HEIGHT = 72, COUNT = 150, SIDE = 16 };

enum { CURVED = 1, TWO_SIDED = 2, BENT = 4, NORMAL_MAP = 8, UNTEXTURED = 16, ALL_SEAMS = 32 };

static uint8_t colors[SIDE * SIDE * 4], normals[SIDE * SIDE * 4];

/* Waves some texels long, so that a part of a texel does not matter much; normals lean by up to 20
 * degrees. */
static void make_images(psplat_pixels images[2]) {
    for (int i = 0; i < SIDE * SIDE; ++i) {
        double x = i % SIDE * 2 * CAMERA_PI / SIDE, y = i / SIDE * 2 * CAMERA_PI / SIDE;
        for (int k = 0; k < 3; ++k) {
            colors[4 * i + k] = (uint8_t)lrint(127 + 100 * sin(x + k) * cos(y + 2 * k));
            normals[4 * i + k] = k == 2 ? 242 : (uint8_t)lrint(127 + 30 * sin(k ? x : y));
        }
        colors[4 * i + 3] = normals[4 * i + 3] = 255;
    }
    images[0] = (psplat_pixels){.rgba = colors, .width = SIDE, .height = SIDE};
    images[1] = (psplat_pixels){.rgba = normals, .width = SIDE, .height = SIDE};
}

/* Returns ellipses with two lines, of which the last one is a seam, or both. Several lie within
 * epsilon of each other in most pixels. */
static scene ellipses(const psplat_pixels images[2], int kind) {
    scene s = scene_ellipses(COUNT, 2, 11);
    uint32_t random = 5;
    for (size_t i = 0; i < s.count; ++i)
        for (uint32_t k = 0; k < s.splats[i].clip_count; ++k) {
            s.splats[i].clip[k][2] = scene_random(&random) * 0.5f;
            if (kind & BENT) s.splats[i].bend[k] = 3 * scene_random(&random) - 1.5f;
        }
    s.seam_lines = kind & ALL_SEAMS ? 2 : 1;
    s.depth_tolerance = 0.3f;
    s.material.double_sided = kind & TWO_SIDED ? 1 : 0;
    s.material.roughness = 0.9f;
    if (kind & CURVED) scene_curve(&s);
    if (kind & UNTEXTURED) return s;
    s.texcoords = calloc(s.count, sizeof *s.texcoords);
    assert_non_null(s.texcoords);
    for (size_t i = 0; i < s.count; ++i)
        s.texcoords[i] = (psplat_texcoord){.at = {scene_random(&random), scene_random(&random)},
                                           .along_u = {0.2f, 0.05f},
                                           .along_v = {0.05f, i % 2 ? 0.2f : -0.2f}};
    s.images = images;
    s.image_count = 2;
    s.material.textures[PSPLAT_TEXTURE_BASE_COLOR] = (psplat_texture){.image = 1, .strength = 1};
    if (kind & NORMAL_MAP)
        s.material.textures[PSPLAT_TEXTURE_NORMAL] = (psplat_texture){.image = 2, .strength = 1};
    return s;
}

static psplat_view view_of(double pixels) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){1, 2, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, pixels / 2 * sqrt(14), 0.3, 8);
    for (int i = 0; i < 3; ++i) view.ambient[i] = 0.5f;
    return view;
}

/* The bounds are those of test_agreement_textures.c, whose reasons hold here: GLs filter textures
 * in steps of 8 bits, and highlights magnify what that does to normals. Without textures they are
 * those of test_agreement_filter.c. */
static void check(gpu *g, const char *name, const scene *s, const psplat_view *view, size_t least) {
    static const agreement_ties ties = {2e-4, 2e-6, 0.15};
    double bound = s->texcoords ? view->shading == PSPLAT_SHADING_LIT ? 0.06 : 0.02 : 1e-3;
    psplat_asset *asset = scene_open(s);
    agreement a = agreement_measure(g, asset, NULL, view, 1, &ties);
    print_message("%-22s covered %6zu skipped %4zu depth %.1e color %.1e\n", name, a.covered,
                  a.skipped, a.depth, a.color);
    assert_true(a.covered > least && a.skipped * 2 < a.covered);
    assert_int_equal(a.mismatches, 0);
    assert_true(a.color <= bound);
    assert_true(a.depth <= 2e-5); /* as for slanted splats in test_agreement_filter.c */
    psplat_asset_destroy(asset);
}

static void check_kind(gpu *g, const scene *s) {
    psplat_view view = view_of(90);
    check(g, " phong", s, &view, 1200);
    view.shading = PSPLAT_SHADING_UNLIT;
    check(g, " unlit", s, &view, 1200);
    view.shading = PSPLAT_SHADING_NORMAL;
    check(g, " normals", s, &view, 1200);
    view.shading = PSPLAT_SHADING_LIT;
    view.mode = PSPLAT_MODE_GAUSSIAN;
    check(g, " gaussian", s, &view, 1200);
    view.mode = PSPLAT_MODE_FLAT;
    check(g, " flat", s, &view, 1200);
    view.mode = PSPLAT_MODE_PHONG;
    view.no_filter = 0;
    check(g, " with the filter", s, &view, 1200);
    view = view_of(24);
    view.no_filter = 0;
    check(g, " smaller", s, &view, 100);
    view.shading = PSPLAT_SHADING_NORMAL;
    check(g, " smaller, normals", s, &view, 100);
}

static void test_kinds(void **state) {
    static const int kinds[] = {BENT,
                                CURVED | TWO_SIDED,
                                TWO_SIDED | ALL_SEAMS,
                                NORMAL_MAP,
                                CURVED | NORMAL_MAP | BENT,
                                UNTEXTURED,
                                UNTEXTURED | CURVED | BENT | ALL_SEAMS};
    psplat_pixels images[2];
    make_images(images);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        scene s = ellipses(images, kinds[i]);
        print_message("kind %d\n", kinds[i]);
        check_kind(*state, &s);
        scene_free(&s);
    }
}

/* With up to four lines, of which one, two or all are seams. */
static void test_counts(void **state) {
    for (uint32_t seams = 1; seams <= 4; seams *= 2)
        for (int is_curved = 0; is_curved < 2; ++is_curved) {
            scene s = scene_ellipses(COUNT, 4, 3);
            s.seam_lines = seams;
            /* Less than four times the heights of patches, which tangent ellipses would stand for.
             */
            s.depth_tolerance = 0.1f;
            if (is_curved) scene_curve(&s);
            psplat_view view = view_of(90);
            print_message("%u seams, %s\n", (unsigned)seams, is_curved ? "curved" : "flat");
            check(*state, " without the filter", &s, &view, 700);
            view.no_filter = 0;
            check(*state, " with the filter", &s, &view, 700);
            scene_free(&s);
        }
}

/* The shaders of GLES are the same except for their prelude, so that a part of the tests is enough
 * there. */
int test_agreement_seams_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kinds),
        cmocka_unit_test(test_counts),
    };
    const struct CMUnitTest gles_tests[] = {
        cmocka_unit_test(test_counts),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", gles_tests, gpu_setup_gles, gpu_teardown);
}
