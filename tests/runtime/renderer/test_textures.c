/* SPDX-License-Identifier: MIT
 *
 * test_textures.c - tests textures of materials on scenes whose pictures are known in closed form
 * (spec 3.11): what a texel is in which pixel, how far a pixel reaches on an image, what masks drop
 * and where normal maps lean. test_agreement_textures.c compares all of it with the reference.
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

enum { WIDTH = 96, HEIGHT = 96, IMAGE = 8 };

/* ---- scenes --------------------------------------------------------------------------------- */

/* A board of 8 x 8 squares, white and black, whose upper left one is red. */
static psplat_pixels board(uint8_t rgba[IMAGE * IMAGE * 4]) {
    for (int i = 0; i < IMAGE * IMAGE; ++i) {
        uint8_t value = (i / IMAGE + i) % 2 ? 255 : 0;
        const uint8_t texel[4] = {i ? value : 255, value, value, 255};
        memcpy(rgba + 4 * i, texel, 4);
    }
    return (psplat_pixels){.rgba = rgba, .width = IMAGE, .height = IMAGE};
}

/* A disc of radius 1 around the origin that shows the image once between -1/2 and 1/2. */
static scene disc(const psplat_pixels *images, size_t count) {
    scene s = scene_disc(1);
    s.texcoords = calloc(1, sizeof *s.texcoords);
    assert_non_null(s.texcoords);
    s.texcoords[0] = (psplat_texcoord){.at = {0.5f, 0.5f}, .along_u = {1, 0}, .along_v = {0, -1}};
    s.images = images;
    s.image_count = count;
    s.material.unlit = 1;
    s.material.textures[PSPLAT_TEXTURE_BASE_COLOR] =
        (psplat_texture){.image = 1, .nearest = 1, .strength = 1};
    return s;
}

/* Looks from +z; half the height of the view is 1. */
static psplat_view front(void) {
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, 0, 3}, (double[]){0, 0, 0});
    camera_parallel(&view, 1, 1, 5);
    return view;
}

static void draw(gpu *g, const scene *s, const psplat_view *view, float *color) {
    static const float clear[4] = {0};
    psplat_error error = {0};
    psplat_item item = {.model = NULL};
    psplat_asset *asset = scene_open(s);
    if (psplat_model_create(g->renderer, asset, &item.model, &error) ||
        psplat_host_begin(g->host, view->width, view->height, 1, clear, &error) ||
        psplat_draw(g->renderer, view, &item, 1, &error) ||
        psplat_host_read_float(g->host, color, &error))
        fail_msg("%s", error.text);
    psplat_model_destroy(g->renderer, item.model);
    psplat_asset_destroy(asset);
}

/* The scene point of the middle of a pixel in front(). */
static void point_of(int x, int y, double at[2]) {
    at[0] = (x + 0.5) / WIDTH * 2 - 1;
    at[1] = (y + 0.5) / HEIGHT * 2 - 1;
}

/* Compares a picture in front() with the board as it is at T(x, y), where texels are larger than
 * pixels. Pixels whose T is within a hundredth of a texel of another one are left out. */
static void expect_board(const float *color, const psplat_texture *use, const uint8_t *rgba,
                         const psplat_texcoord *t) {
    int seen = 0;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            double at[2];
            int texel[2], is_near = 0;
            point_of(x, y, at);
            if (hypot(at[0], at[1]) > 0.99) continue;
            for (int k = 0; k < 2; ++k) {
                double s = (double)t->at[k] + at[0] * (double)t->along_u[k] +
                           at[1] * (double)t->along_v[k];
                is_near |= fabs(s * IMAGE - round(s * IMAGE)) < 0.01;
                if (use->wrap[k] == PSPLAT_WRAP_REPEAT) s -= floor(s);
                if (use->wrap[k] == PSPLAT_WRAP_CLAMP) s = fmin(fmax(s, 0), 1 - 1e-9);
                if (use->wrap[k] == PSPLAT_WRAP_MIRROR) s = fabs(s - 2 * floor((s + 1) / 2));
                texel[k] = (int)fmin(s * IMAGE, IMAGE - 1);
            }
            if (is_near) continue;
            ++seen;
            const uint8_t *expected = rgba + 4 * (texel[1] * IMAGE + texel[0]);
            const float *found = color + 4 * (y * WIDTH + x);
            for (int k = 0; k < 3; ++k)
                if (fabs((double)found[k] - expected[k] / 255.0) > 1e-5)
                    fail_msg("pixel %d %d is %g %g %g, not texel %d %d", x, y, (double)found[0],
                             (double)found[1], (double)found[2], texel[0], texel[1]);
        }
    assert_true(seen > 5000);
}

/* ---- magnified ------------------------------------------------------------------------------ */

static void test_texels(void **state) {
    static float color[WIDTH * HEIGHT * 4];
    uint8_t rgba[IMAGE * IMAGE * 4];
    const psplat_pixels image = board(rgba);
    const psplat_view view = front();
    for (int wrap = 0; wrap < 9; ++wrap)
        for (int is_curved = 0; is_curved < 2; ++is_curved) {
            scene s = disc(&image, 1);
            psplat_texture *use = &s.material.textures[0];
            use->wrap[0] = (psplat_wrap)(wrap % 3);
            use->wrap[1] = (psplat_wrap)(wrap / 3);
            s.splats[0].gradient[0] = s.splats[0].gradient[1] = 0.5f;
            if (is_curved) scene_curve(&s); /* seen from far away (u, v) are x and y all the same */
            draw(*state, &s, &view, color);
            expect_board(color, use, rgba, s.texcoords);
            scene_free(&s);
        }
}

/* T is turned and sheared, by itself and by the texture's transform, which is composed by hand. */
static void test_transform(void **state) {
    static float color[WIDTH * HEIGHT * 4];
    uint8_t rgba[IMAGE * IMAGE * 4];
    const psplat_pixels image = board(rgba);
    const psplat_view view = front();
    scene s = disc(&image, 1);
    psplat_texture *use = &s.material.textures[0];
    s.texcoords[0] =
        (psplat_texcoord){.at = {3.25f, -2.5f}, .along_u = {0.75f, 0.5f}, .along_v = {0.25f, 1}};
    draw(*state, &s, &view, color);
    expect_board(color, use, rgba, s.texcoords);
    const float rows[6] = {0, 2, 0.375f, -0.5f, 0, 0.25f};
    memcpy(use->transform, rows, sizeof rows);
    draw(*state, &s, &view, color);
    psplat_texcoord moved = {{2 * -2.5f + 0.375f, -0.5f * 3.25f + 0.25f},
                             {2 * 0.5f, -0.5f * 0.75f},
                             {2, -0.5f * 0.25f},
                             {0, 0},
                             {0, 0},
                             {0, 0}};
    expect_board(color, use, rgba, &moved);
    scene_free(&s);
}

/* A field of the second order, found by hand at its points: s = 1/2 + u/4 + u^2/4 - u v/4 and
 * t = 1/2 - v/4 + v^2/4. */
static void test_second_order(void **state) {
    static float color[WIDTH * HEIGHT * 4];
    uint8_t rgba[4 * 64 * 4];
    for (int i = 0; i < 64; ++i) /* a ramp along s, of numbers that are not colours */
        for (int row = 0; row < 4; ++row)
            for (int k = 0; k < 4; ++k) rgba[4 * (64 * row + i) + k] = (uint8_t)(4 * i);
    const psplat_pixels image = {.rgba = rgba, .width = 64, .height = 4};
    const psplat_view view = front();
    for (int is_curved = 0; is_curved < 2; ++is_curved) {
        scene s = disc(&image, 1);
        s.texcoords[0] = (psplat_texcoord){.at = {0.5f, 0.5f},
                                           .along_u = {0.25f, 0},
                                           .along_v = {0, -0.25f},
                                           .along_uu = {0.25f, 0},
                                           .along_uv = {-0.25f, 0},
                                           .along_vv = {0, 0.25f}};
        s.material.textures[PSPLAT_TEXTURE_METALLIC_ROUGHNESS] =
            (psplat_texture){.image = 1, .wrap = {PSPLAT_WRAP_CLAMP, PSPLAT_WRAP_CLAMP}};
        s.material.textures[0].image = 0;
        /* Of a metal without light but the ambient one, (7) is the base colour times ambient; of
         * no metal it is the colour + 0.04. So metallic shows. */
        s.material.unlit = 0;
        s.material.metallic = 1;
        s.material.base_color[0] = s.material.base_color[1] = s.material.base_color[2] = 0.5f;
        s.splats[0].gradient[0] = s.splats[0].gradient[1] = 0.5f;
        if (is_curved) scene_curve(&s);
        psplat_view lit = view;
        lit.light_count = 0;
        for (int k = 0; k < 3; ++k) lit.ambient[k] = 1;
        draw(*state, &s, &lit, color);
        for (int y = 8; y < HEIGHT - 8; y += 4)
            for (int x = 8; x < WIDTH - 8; x += 4) {
                double at[2];
                point_of(x, y, at);
                if (hypot(at[0], at[1]) > 0.95) continue;
                double place = 0.5 + 0.25 * at[0] * (1 + at[0] - at[1]);
                double metallic = fmin(fmax(place * 64 - 0.5, 0), 63) * 4 / 255;
                double expected = 0.5 + 0.04 * (1 - metallic);
                /* Some GLs filter in steps of 8 bits, a fourth of a texel here. */
                double found = (double)color[4 * (y * WIDTH + x)];
                if (fabs(found - expected) > 0.04 / 255)
                    fail_msg("pixel %d %d is %.7f, not %.7f", x, y, found, expected);
            }
        scene_free(&s);
    }
}

/* Colours are decoded from sRGB, other numbers are not: an image that is used as both. */
static void test_color_spaces(void **state) {
    static float color[WIDTH * HEIGHT * 4];
    static const uint8_t grey[4] = {128, 128, 128, 255};
    const psplat_pixels image = {.rgba = grey, .width = 1, .height = 1};
    psplat_view view = front();
    scene s = disc(&image, 1);
    const float *middle = color + 4 * (HEIGHT / 2 * WIDTH + WIDTH / 2);
    draw(*state, &s, &view, color);
    double linear = pow((128 / 255.0 + 0.055) / 1.055, 2.4);
    /* GLs may decode with a polynomial; 1e-3 is a fourth of the distance to the next byte. */
    assert_true(fabs((double)middle[0] - linear) < 1e-3);
    /* Emission is a colour, and occlusion is not: ambient light on black that is no metal is
     * 0.04 times occlusion. */
    s.material.unlit = 0;
    for (int k = 0; k < 3; ++k) {
        s.material.base_color[k] = 0;
        s.material.emissive[k] = 0.5f;
        view.ambient[k] = 1;
    }
    view.light_count = 0;
    s.material.textures[0].image = 0;
    s.material.textures[PSPLAT_TEXTURE_EMISSIVE].image = 1;
    draw(*state, &s, &view, color);
    assert_true(fabs((double)middle[0] - 0.5 * linear - 0.04) < 1e-3);
    s.material.textures[PSPLAT_TEXTURE_OCCLUSION] = (psplat_texture){.image = 1, .strength = 0.5f};
    draw(*state, &s, &view, color);
    double occlusion = 1 + 0.5 * (128 / 255.0 - 1);
    assert_true(fabs((double)middle[0] - 0.5 * linear - 0.04 * occlusion) < 1e-3);
    scene_free(&s);
}

/* ---- minified ------------------------------------------------------------------------------- */

/* A board under a grazing view: near the eye its squares are seen as they are, far away they fade
 * to the mean of their colours and do not flicker. The curved splat is bent so little that its
 * picture has to be the same, although its roots differ from pixel to pixel. */
static void test_grazing(void **state) {
    static float color[2][WIDTH * HEIGHT * 4];
    uint8_t rgba[IMAGE * IMAGE * 4];
    const psplat_pixels image = board(rgba);
    rgba[0] = 0;
    psplat_view view = camera_view(WIDTH, HEIGHT);
    camera_look(&view, (double[]){0, -30, 3}, (double[]){0, 0, 0});
    camera_perspective(&view, 150, 1, 300);
    for (int is_curved = 0; is_curved < 2; ++is_curved) {
        scene s = disc(&image, 1);
        s.splats[0].radius[0] = s.splats[0].radius[1] = 100;
        s.texcoords[0] = (psplat_texcoord){.along_u = {50, 0}, .along_v = {0, -50}};
        s.material.textures[0].nearest = 0;
        s.splats[0].gradient[0] = s.splats[0].gradient[1] = is_curved ? 1e-4f : 0;
        if (is_curved) scene_curve(&s);
        s.depth_tolerance = 1e-4f;
        draw(*state, &s, &view, color[is_curved]);
        scene_free(&s);
    }
    double near = 0, far = 0, differ = 0;
    for (int x = 0; x < WIDTH; ++x) {
        /* Row 10 is 8 units away, where a square of 1/4 is 4.5 pixels wide and 1.6 high. Row 55 is
         * 60 units away, and a pixel shows two columns of 32 squares. */
        near += fabs((double)color[0][4 * (10 * WIDTH + x)] - 0.5) / WIDTH;
        far = fmax(far, fabs((double)color[0][4 * (55 * WIDTH + x)] - 0.5));
    }
    for (size_t i = 0; i < (size_t)WIDTH * 56 * 4; ++i)
        differ = fmax(differ, fabs((double)color[0][i] - (double)color[1][i]));
    print_message("contrast near %.4f, far %.4f; curved differs by %.4f\n", near, far, differ);
    assert_true(near > 0.2);
    assert_true(far < 0.01);
    assert_true(differ < 0.05);
}

/* A board of which the black squares are dropped hangs over a disc that shows white all over. Light
 * that comes straight from above leaves the shadow of the board: seen from above, holes show lit
 * places. From the side the shadow moves away from the holes, by a square. */
static void test_masked_shadow(void **state) {
    static float color[WIDTH * HEIGHT * 4];
    uint8_t rgba[IMAGE * IMAGE * 4];
    const psplat_pixels image = board(rgba);
    for (int i = 0; i < IMAGE * IMAGE; ++i) {
        rgba[4 * i + 3] = rgba[4 * i + 1];
        rgba[4 * i] = rgba[4 * i + 1] = rgba[4 * i + 2] = 255;
    }
    rgba[3] = 0;
    scene s = scene_blank(2);
    s.texcoords = calloc(2, sizeof *s.texcoords);
    assert_non_null(s.texcoords);
    s.texcoords[0] =
        (psplat_texcoord){.at = {0.5f, 0.5f}, .along_u = {0.5f, 0}, .along_v = {0, -0.5f}};
    s.texcoords[1] = (psplat_texcoord){.at = {1.5f / IMAGE, 0.5f / IMAGE}}; /* a white square */
    s.splats[1].center[2] = -1;
    s.splats[1].radius[0] = s.splats[1].radius[1] = 3;
    s.images = &image;
    s.image_count = 1;
    s.material.textures[0] = (psplat_texture){.image = 1, .nearest = 1};
    s.material.alpha_cutoff = 0.5f;
    psplat_view view = front();
    camera_parallel(&view, 0.5, 1, 5);
    view.shadow_size = 1024;
    view.lights[0].casts_shadow = 1;
    for (int is_slanted = 0; is_slanted < 2; ++is_slanted) {
        int holes = 0, wrong = 0;
        /* A square is 1/4 of the radius wide. */
        view.lights[0].direction[0] = is_slanted ? 0.25f : 0;
        draw(*state, &s, &view, color);
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x) {
                double at[2];
                point_of(x, y, at);
                double place[2] = {(0.5 + at[0] / 4) * IMAGE, (0.5 - at[1] / 4) * IMAGE};
                int is_near = 0;
                for (int k = 0; k < 2; ++k) is_near |= fabs(place[k] - round(place[k])) < 0.1;
                int is_hole = ((int)place[0] + (int)place[1]) % 2 == 0;
                if (is_near || !is_hole) continue;
                ++holes;
                wrong += (color[4 * (y * WIDTH + x)] > 0.1f) == is_slanted;
            }
        print_message("%d pixels of holes, %d of them wrong\n", holes, wrong);
        assert_true(holes > 2000);
        assert_int_equal(wrong, 0);
    }
    scene_free(&s);
}

int test_textures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_texels),       cmocka_unit_test(test_transform),
        cmocka_unit_test(test_second_order), cmocka_unit_test(test_color_spaces),
        cmocka_unit_test(test_grazing),      cmocka_unit_test(test_masked_shadow),
    };
    int failed = cmocka_run_group_tests_name("GL", tests, gpu_setup_gl, gpu_teardown);
    return failed + cmocka_run_group_tests_name("GLES", tests, gpu_setup_gles, gpu_teardown);
}
