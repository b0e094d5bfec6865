/* SPDX-License-Identifier: MIT
 *
 * test_agreement_textures.c - tests that the renderer draws textured splats (spec 3.11) as the
 * reference rasteriser does: flat and curved, near and far, mirrored, masked, with normal maps, in
 * all modes. test_textures.c has pictures that are known in closed form.
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
#include <string.h>

enum { WIDTH = 160, HEIGHT = 120, IMAGES = 3, SIZE = 32, COUNT = 150 };

typedef struct images {
    uint8_t rgba[IMAGES][SIZE * SIZE * 4];
    psplat_pixels pixels[IMAGES];
} images;

/* Images that repeat and have waves some texels long, so that a part of a texel does not matter
 * much: colours with alphas of 0.1 to 0.9, normals that lean by up to 20 degrees, and numbers that
 * are never small, since highlights of smooth materials would magnify each rounded bit. */
static void make_images(images *out) {
    for (int image = 0; image < IMAGES; ++image) {
        for (int i = 0; i < SIZE * SIZE; ++i)
            for (int k = 0; k < 4; ++k) {
                double x = i % SIZE * 2 * CAMERA_PI / SIZE, y = i / SIZE * 2 * CAMERA_PI / SIZE;
                double wave = sin((1 + (image + k) % 2) * x + k) * cos((1 + k % 2) * y + image);
                static const double middle[IMAGES] = {0.5, 0.5, 0.75},
                                    most[IMAGES] = {0.4, 0.12, 0.25};
                double value = image == 1 && k == 2 ? 0.95 : middle[image] + most[image] * wave;
                out->rgba[image][4 * i + k] = (uint8_t)lrint(255 * value);
            }
        out->pixels[image] =
            (psplat_pixels){.rgba = out->rgba[image], .width = SIZE, .height = SIZE};
    }
}

/* Gives every splat coordinates of about `tiles` images over a radius of 0.3, every other one
 * mirrored. */
static void add_texcoords(scene *s, double tiles, int is_bent) {
    uint32_t random = 77;
    s->texcoords = calloc(s->count, sizeof *s->texcoords);
    assert_non_null(s->texcoords);
    for (size_t i = 0; i < s->count; ++i) {
        psplat_texcoord *t = &s->texcoords[i];
        double angle = 6.28 * (double)scene_random(&random), side = i % 2 ? 1 : -1;
        double u = tiles * (double)s->splats[i].radius[0] / 0.3;
        double v = tiles * (double)s->splats[i].radius[1] / 0.3 * side;
        for (int k = 0; k < 2; ++k) t->at[k] = scene_random(&random) * 5;
        t->along_u[0] = (float)(u * cos(angle));
        t->along_u[1] = (float)(u * sin(angle));
        t->along_v[0] = (float)(-v * sin(angle));
        t->along_v[1] = (float)(v * cos(angle));
        for (int k = 0; k < 2 && is_bent; ++k) {
            t->along_uu[k] = (scene_random(&random) - 0.5f) * (float)u * 0.5f;
            t->along_uv[k] = (scene_random(&random) - 0.5f) * (float)v * 0.5f;
            t->along_vv[k] = (scene_random(&random) - 0.5f) * (float)v * 0.5f;
        }
    }
}

static void use_image(scene *s, psplat_texture_slot slot, uint32_t image, int wrap) {
    s->material.textures[slot] =
        (psplat_texture){.image = image,
                         .wrap = {(psplat_wrap)(wrap % 3), (psplat_wrap)(wrap / 3)},
                         .strength = 0.75f};
}

static void use_all(scene *s, const images *from) {
    s->images = from->pixels;
    s->image_count = IMAGES;
    use_image(s, PSPLAT_TEXTURE_BASE_COLOR, 1, 0);
    use_image(s, PSPLAT_TEXTURE_METALLIC_ROUGHNESS, 3, 2);
    use_image(s, PSPLAT_TEXTURE_NORMAL, 2, 0);
    use_image(s, PSPLAT_TEXTURE_OCCLUSION, 3, 8);
    use_image(s, PSPLAT_TEXTURE_EMISSIVE, 1, 3);
    s->material.metallic = 0.5f;
    s->material.roughness = 0.9f;
    for (int k = 0; k < 3; ++k) s->material.emissive[k] = 0.25f;
}

/* Ellipses with coordinates and all textures. */
static scene ellipses(const images *from, double tiles, int is_curved, int is_bent) {
    scene s = scene_ellipses(COUNT, 2, 7);
    add_texcoords(&s, tiles, is_bent);
    use_all(&s, from);
    if (is_curved) scene_curve(&s);
    return s;
}

static psplat_view view_of(double distance) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    double scale = distance / sqrt(14);
    camera_look(&view, (double[]){scale, 2 * scale, 3 * scale}, (double[]){0, 0, 0});
    camera_perspective(&view, 120, 0.3, 3 * distance);
    for (int i = 0; i < 3; ++i) view.ambient[i] = 0.5f;
    return view;
}

/* Expects agreement up to what GLs may do. They filter in steps of 8 bits, take sRGB's transfer
 * function for a polynomial, and may find one level of detail for four pixels, from the larger of
 * two coordinates. Highlights magnify what that does to normals and roughness. */
static void check(gpu *g, const char *name, const scene *s, const double transform[16],
                  const psplat_view *view, size_t least) {
    static const agreement_ties ties = {2e-4, 2e-6, 0.015};
    psplat_asset *asset = scene_open(s);
    agreement a = agreement_measure(g, asset, transform, view, 1, &ties);
    print_message("%-30s covered %6zu skipped %4zu color %.1e\n", name, a.covered, a.skipped,
                  a.color);
    assert_true(a.covered > least && a.skipped * 5 < a.covered);
    assert_int_equal(a.mismatches, 0);
    assert_true(a.color <= (view->shading == PSPLAT_SHADING_LIT ? 0.06 : 0.02));
    psplat_asset_destroy(asset);
}

static void check_modes(gpu *g, const scene *s, double distance, size_t least) {
    psplat_view view = view_of(distance);
    check(g, " phong", s, NULL, &view, least);
    view.shading = PSPLAT_SHADING_UNLIT;
    check(g, " unlit", s, NULL, &view, least);
    view.shading = PSPLAT_SHADING_NORMAL;
    check(g, " normals", s, NULL, &view, least);
    view.shading = PSPLAT_SHADING_LIT;
    view.mode = PSPLAT_MODE_GAUSSIAN;
    check(g, " gaussian", s, NULL, &view, least);
    view.mode = PSPLAT_MODE_FLAT;
    check(g, " flat", s, NULL, &view, least);
    view.mode = PSPLAT_MODE_PHONG;
    view.no_filter = 0;
    check(g, " with the filter", s, NULL, &view, least);
}

static void test_kinds(void **state) {
    images *from = calloc(1, sizeof *from);
    assert_non_null(from);
    make_images(from);
    for (int kind = 0; kind < 4; ++kind) {
        scene s = ellipses(from, 0.5, kind & 1, kind & 2);
        print_message("%s, %s\n", kind & 1 ? "curved" : "flat", kind & 2 ? "bent" : "linear");
        check_modes(*state, &s, sqrt(14), 1000);
        scene_free(&s);
    }
    free(from);
}

/* Each texture alone: the targets and programs of a frame depend on the others. */
static void test_slots(void **state) {
    images *from = calloc(1, sizeof *from);
    assert_non_null(from);
    make_images(from);
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        scene s = ellipses(from, 0.5, slot % 2, 0);
        for (int other = 0; other < PSPLAT_TEXTURE_SLOTS; ++other)
            if (other != slot) s.material.textures[other].image = 0;
        print_message("texture %d\n", slot);
        check_modes(*state, &s, sqrt(14), 1000);
        scene_free(&s);
    }
    free(from);
}

/* Texels from 20 pixels wide to a tenth of a pixel, seen in perspective and not. */
static void test_sizes(void **state) {
    static const double tiles[] = {0.02, 0.2, 2, 8};
    images *from = calloc(1, sizeof *from);
    assert_non_null(from);
    make_images(from);
    for (size_t i = 0; i < 2 * sizeof tiles / sizeof *tiles; ++i) {
        scene s = ellipses(from, tiles[i / 2], i % 2, i / 2 % 2);
        psplat_view view = view_of(sqrt(14));
        print_message("%g tiles, %s\n", tiles[i / 2], i % 2 ? "curved" : "flat");
        check(*state, " perspective", &s, NULL, &view, 1000);
        camera_parallel(&view, 1.2, 0.3, 12);
        check(*state, " parallel", &s, NULL, &view, 1000);
        scene_free(&s);
    }
    free(from);
}

/* Scaled unequally, and mirrored, so that normals and handedness change sides; from both sides. */
static void test_transforms(void **state) {
    static const double transforms[3][16] = {
        {0.8, 0.1, 0, 0, -0.2, 0.5, 0.1, 0, 0, 0.3, 1.1, 0, 0.1, 0, -0.1, 1},
        {-0.8, 0.1, 0, 0, 0.2, 0.9, 0.1, 0, 0, 0.3, 1.1, 0, 0, 0.1, 0, 1},
        {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
    images *from = calloc(1, sizeof *from);
    assert_non_null(from);
    make_images(from);
    for (size_t i = 0; i < 6; ++i) {
        scene s = ellipses(from, 0.5, i % 2, 1);
        psplat_view view = view_of(sqrt(14));
        s.material.double_sided = 1;
        print_message("transform %zu, %s\n", i / 2, i % 2 ? "curved" : "flat");
        check(*state, " lit", &s, transforms[i / 2], &view, 1000);
        view.shading = PSPLAT_SHADING_NORMAL;
        check(*state, " normals", &s, transforms[i / 2], &view, 1000);
        scene_free(&s);
    }
    free(from);
}

/* Transforms of the textures themselves: turned, scaled, moved, mirrored. */
static void test_texture_transforms(void **state) {
    static const float rows[3][6] = {{0.6f, 0.8f, 0.25f, -0.8f, 0.6f, 0.5f},
                                     {-1.5f, 0, 0.5f, 0, 0.75f, 0.125f},
                                     {0, 1, 0, -1, 0, 0}};
    images *from = calloc(1, sizeof *from);
    assert_non_null(from);
    make_images(from);
    for (size_t i = 0; i < 6; ++i) {
        scene s = ellipses(from, 0.5, i % 2, 0);
        psplat_view view = view_of(sqrt(14));
        for (size_t slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
            memcpy(s.material.textures[slot].transform, rows[(i / 2 + slot) % 3], sizeof rows[0]);
        check(*state, "transformed textures", &s, NULL, &view, 1000);
        scene_free(&s);
    }
    free(from);
}

/* Pixels whose alpha is close to the cutoff may differ, so that alphas here jump: squares of a
 * texture that is not interpolated, which are there or not. Squares' borders are not compared. */
static void test_masks(void **state) {
    enum { BOARD = 4 };
    uint8_t rgba[BOARD * BOARD * 4];
    for (int i = 0; i < BOARD * BOARD; ++i) {
        const uint8_t texel[4] = {200, (uint8_t)(16 * i), 40, (i / BOARD + i) % 2 ? 255 : 0};
        memcpy(rgba + 4 * i, texel, 4);
    }
    const psplat_pixels image = {.rgba = rgba, .width = BOARD, .height = BOARD};
    static const agreement_ties ties = {2e-4, 2e-6, 0.015};
    for (int kind = 0; kind < 4; ++kind) {
        scene s = scene_ellipses(COUNT, 2, 7);
        add_texcoords(&s, 0.2, 0);
        s.images = &image;
        s.image_count = 1;
        use_image(&s, PSPLAT_TEXTURE_BASE_COLOR, 1, 0);
        s.material.textures[0].nearest = 1;
        s.material.alpha_cutoff = 0.5f;
        if (kind & 1) scene_curve(&s);
        psplat_view view = view_of(sqrt(14));
        if (kind & 2) view.mode = PSPLAT_MODE_FLAT;
        psplat_asset *asset = scene_open(&s);
        agreement a = agreement_measure(*state, asset, NULL, &view, 1, &ties);
        s.material.alpha_cutoff = 0;
        psplat_asset *whole = scene_open(&s);
        agreement b = agreement_measure(*state, whole, NULL, &view, 1, &ties);
        print_message("masked: covered %zu of %zu, mismatches %zu, color %.1e\n", a.covered,
                      b.covered, a.mismatches, a.color);
        assert_true(a.covered > 300 && a.covered + 100 < b.covered);
        /* Along the borders of squares a pixel may fall on either side. */
        assert_true(a.mismatches * 50 < a.covered);
        psplat_asset_destroy(asset);
        psplat_asset_destroy(whole);
        scene_free(&s);
    }
}

int test_agreement_textures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kinds),
        cmocka_unit_test(test_slots),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_transforms),
        cmocka_unit_test(test_texture_transforms),
        cmocka_unit_test(test_masks),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, gpu_setup_gles, gpu_teardown);
}
