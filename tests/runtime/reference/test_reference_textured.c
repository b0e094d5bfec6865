/* SPDX-License-Identifier: MIT
 *
 * test_reference_textured.c - tests textures of the reference rasteriser (spec 3.11) against closed
 * forms: samplers, minification, the factors of materials, the modes and the filter.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

#include "textured_fixture.h"

/* ---- samplers ------------------------------------------------------------------------------- */

static double clamped(double x, double y) {
    (void)y;
    return fmin(fmax(2 * (2 * x) - 0.5, 0), 1);
}

/* Texels 0 1 0 1 ..., of which the first has its middle at 0. */
static double repeated(double x, double y) {
    double at = 2 * (2 * x) - 0.5;
    (void)y;
    return 1 - fabs(at - 2 * floor(at / 2) - 1);
}

/* Texels 0 1 1 0 0 1 1 0 ... */
static double mirrored(double x, double y) {
    double at = 2 * (2 * x) - 0.5, rest = at - 4 * floor(at / 4);
    (void)y;
    return rest < 1 ? rest : rest < 2 ? 1 : rest < 3 ? 3 - rest : 0;
}

static double squares(double x, double y) {
    (void)y;
    return fabs(fmod(floor(2 * (2 * x)), 2));
}

static void check_sampler(const char *sampler, double (*expected)(double x, double y)) {
    const psplat_pixels image = {.rgba = black_white, .width = 2, .height = 1};
    psplat_view view = front_view();
    plate p = disc();
    p.sampler = sampler;
    p.u[0] = 2;
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    /* Floats of (u, v), of which a picture holds 1e-16, and of the colour. */
    each(&drawn, expected, FLOAT_STEP);
    picture_free(&drawn);
}

static void test_wraps(void **state) {
    (void)state;
    check_sampler("\"wrapS\":33071", clamped);
    check_sampler("", repeated);
    check_sampler("\"wrapS\":33648", mirrored);
    check_sampler("\"magFilter\":9728", squares);
}

/* The upper left corner of an image is at (0, 0): the rows of the image go down, V goes down. */
static double rows_down(double x, double y) {
    (void)x;
    return y < 0.25 ? 0 : y > 0.75 ? 1 : 2 * (y - 0.25);
}

static void test_rows(void **state) {
    (void)state;
    const psplat_pixels image = {.rgba = black_white, .width = 1, .height = 2};
    psplat_view view = front_view();
    plate p = disc();
    p.sampler = "\"wrapT\":33071";
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    each(&drawn, rows_down, FLOAT_STEP);
    picture_free(&drawn);
}

/* T' = (0.5 + 3 y', ...) with the quarter turn that takes (1, 0) to (0, -1). */
static double moved(double x, double y) {
    (void)x;
    return fmin(fmax(2 * (0.25 + 1.5 * y) - 0.5, 0), 1);
}

static void test_transform(void **state) {
    (void)state;
    const psplat_pixels image = {.rgba = black_white, .width = 2, .height = 1};
    psplat_view view = front_view();
    plate p = disc();
    p.sampler = "\"wrapS\":33071";
    p.material = "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{"
                 "\"KHR_texture_transform\":{\"offset\":[0.25,7],\"rotation\":1.5707963267948966,"
                 "\"scale\":[2,1.5]}}}},\"extensions\":{\"KHR_materials_unlit\":{}}}";
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    each(&drawn, moved, 2 * FLOAT_STEP);
    picture_free(&drawn);
}

/* ---- minification --------------------------------------------------------------------------- */

static double half(double x, double y) {
    (void)x, (void)y;
    return 0.5;
}

static double three_quarters(double x, double y) {
    double s = 64 * x * 4 - 0.5;
    (void)y;
    /* Level 1/2 is halfway between the texels, of which every other is white, and their mean. */
    return 0.5 * (1 - fabs(s - 2 * floor(s / 2) - 1)) + 0.25;
}

/* A board of 8 x 8 squares: where a pixel spans two texels, it shows their mean in linear light. */
static void test_board(void **state) {
    (void)state;
    uint8_t board[8 * 8 * 4];
    for (int i = 0; i < 64; ++i) memset(board + 4 * i, (i / 8 + i) % 2 ? 255 : 0, 4);
    const psplat_pixels image = {.rgba = board, .width = 8, .height = 8};
    psplat_view view = front_view();
    for (double scale = 1; scale < 20; scale *= 3) {
        plate p = disc();
        p.u[0] = p.v[1] = scale * SIZE / 8;
        picture drawn = draw(&p, 1, &image, 1, NULL, &view);
        each(&drawn, half, FLOAT_STEP);
        picture_free(&drawn);
    }
}

/* Between two levels: a pixel spans the square root of two texels. The larger of both derivatives
 * counts. */
static void test_levels(void **state) {
    (void)state;
    uint8_t stripes[16];
    for (int i = 0; i < 4; ++i) memset(stripes + 4 * i, i % 2 ? 255 : 0, 4);
    const psplat_pixels image = {.rgba = stripes, .width = 4, .height = 1};
    psplat_view view = front_view();
    view.width = view.height = SIZE;
    plate p = disc();
    /* 4 texels times 64 over half of SIZE pixels are 16 texels a pixel; the view is enlarged. */
    p.u[0] = 64;
    camera_parallel(&view, sqrt(2) / 16, 10, 30);
    picture drawn = draw(&p, 1, &image, 1, NULL, &view);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        double x = middle(i % SIZE) * sqrt(2) / 16;
        assert_near((double)drawn.image.color[4 * i], three_quarters(x, 0), 4e-7);
    }
    picture_free(&drawn);
}

/* ---- materials ------------------------------------------------------------------------------ */

/* Constant textures multiply what the splat and the material say, as eq. (4d) says. */
static void test_finish(void **state) {
    (void)state;
    const psplat_pixels absent = {.rgba = NULL};
    static const uint8_t texels[4][4] = {
        {200, 100, 50, 255}, {9, 120, 220, 255}, {90, 7, 7, 255}, {30, 60, 240, 255}};
    psplat_pixels images[4];
    for (int i = 0; i < 4; ++i)
        images[i] = (psplat_pixels){.rgba = texels[i], .width = 1, .height = 1};
    psplat_view view = front_view();
    view.shading = PSPLAT_SHADING_LIT;
    for (int k = 0; k < 3; ++k) view.ambient[k] = 0.3f;
    plate p = disc();
    p.has_orm = p.has_emissive = p.has_colors = 1;
    double color[4] = {0.9, 0.8, 0.7, 1}, orm[3] = {0.5, 0.75, 0.625};
    memcpy(p.colors, color, sizeof color);
    memcpy(p.orm, orm, sizeof orm);
    for (int k = 0; k < 3; ++k) p.emissive[k] = 0.25;
    p.material =
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"metallicFactor\":0.8,"
        "\"metallicRoughnessTexture\":{\"index\":1}},"
        "\"occlusionTexture\":{\"index\":2,\"strength\":0.6},\"emissiveFactor\":[1,1,1],"
        "\"emissiveTexture\":{\"index\":3}}";
    picture textured = draw(&p, 1, images, 4, NULL, &view);
    picture bare = draw(&p, 1, &absent, 1, NULL, &view);
    for (int k = 0; k < 3; ++k) {
        p.colors[k] *= decoded(texels[0][k]);
        p.emissive[k] *= decoded(texels[3][k]);
    }
    p.orm[0] *= 1 + 0.6 * (90 / 255.0 - 1);
    p.orm[1] *= 120 / 255.0;
    p.orm[2] *= 220 / 255.0;
    picture expected = draw(&p, 1, &absent, 1, NULL, &view);
    double difference = 0;
    for (int i = 0; i < 4 * SIZE * SIZE; ++i) {
        /* The factors of the second asset are rounded to floats. */
        assert_near((double)textured.image.color[i], (double)expected.image.color[i], 4e-7);
        difference =
            fmax(difference, fabs((double)(bare.image.color[i] - expected.image.color[i])));
    }
    assert_true(difference > 0.1);
    picture_free(&textured);
    picture_free(&bare);
    picture_free(&expected);
}

/* ---- modes and the filter ------------------------------------------------------------------- */

/* The comparison modes show the texture of the whole splat: its mean where the splat spans the
 * image, and the texel at the centre where it spans little of it. */
static void test_modes(void **state) {
    (void)state;
    const psplat_pixels image = {.rgba = black_white, .width = 2, .height = 1};
    const psplat_mode modes[] = {PSPLAT_MODE_GAUSSIAN, PSPLAT_MODE_FLAT};
    const double slopes[] = {1, 0.5 * 1.4142135623730951, 0.1}, shown[] = {0.5, 0.75, 1};
    for (int m = 0; m < 2; ++m)
        for (int i = 0; i < 3; ++i) {
            psplat_view view = front_view();
            view.mode = modes[m];
            plate p = disc();
            p.at[0] = 0.75;
            p.u[0] = slopes[i], p.v[1] = 0;
            picture drawn = draw(&p, 1, &image, 1, NULL, &view);
            for (int k = 0; k < SIZE * SIZE; ++k)
                if (drawn.image.count[k])
                    assert_near((double)drawn.image.color[4 * k], shown[i], 4e-7);
            picture_free(&drawn);
        }
}

/* A splat of a tenth of a pixel is drawn as wide as a pixel, and so is its part of the image: two
 * of four texels, whose mean is black on the left, where all four together are grey. */
static void test_widened(void **state) {
    (void)state;
    uint8_t texels[16];
    for (int i = 0; i < 4; ++i) memset(texels + 4 * i, i < 2 ? 0 : 255, 4);
    const psplat_pixels image = {.rgba = texels, .width = 4, .height = 1};
    psplat_view view = front_view();
    view.no_filter = 0;
    plate p = disc();
    double pixel = 2.0 / SIZE, center = middle(SIZE / 2);
    p.extension = "\"version\":3,\"clipLines\":0,\"depthTolerance\":5,\"positionExtent\":"
                  "[0.03125,0.03125,1]";
    p.sampler = "\"wrapS\":33071";
    p.positions[0] = p.positions[1] = center;
    p.positions[5] = -1;
    p.radii[0] = p.radii[1] = pixel / 10, p.radii[2] = p.radii[3] = 100;
    p.at[0] = 0.25, p.u[0] = 0.5, p.v[1] = 0;
    p.at[2] = 0.875, p.u[2] = p.v[3] = 0;
    picture drawn = draw(&p, 2, &image, 1, NULL, &view);
    int at = SIZE / 2 * SIZE + SIZE / 2;
    assert_int_equal(drawn.image.count[at], 2);
    double behind = exp(-2 * 2 * center * center / 1e4), before = 0.01;
    assert_near((double)drawn.image.color[4 * at], behind / (behind + before), 1e-6);
    picture_free(&drawn);
}

/* ---- what is left out ----------------------------------------------------------------------- */

static void test_absent_images(void **state) {
    (void)state;
    const psplat_pixels none = {.width = 1, .height = 1, .texture = 7};
    psplat_view view = front_view();
    plate p = disc();
    picture drawn = draw(&p, 1, &none, 1, NULL, &view);
    assert_true(drawn.image.color[4 * (SIZE / 2 * SIZE + SIZE / 2)] == 1);
    picture_free(&drawn);
    psplat_asset *asset = open_plate(&p, 1);
    float color[4 * SIZE * SIZE];
    psplat_reference_image image = {.color = color};
    psplat_error error;
    const psplat_pixels empty = {.rgba = black_white};
    psplat_reference_scene scene = {.asset = asset, .images = &empty, .image_count = 1};
    assert_int_equal(psplat_reference_draw(&scene, &view, &image, &error), PSPLAT_ERROR_ARGUMENT);
    scene.images = NULL;
    assert_int_equal(psplat_reference_draw(&scene, &view, &image, &error), PSPLAT_ERROR_ARGUMENT);
    psplat_asset_destroy(asset);
}

int test_reference_textured_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wraps),         cmocka_unit_test(test_rows),
        cmocka_unit_test(test_transform),     cmocka_unit_test(test_board),
        cmocka_unit_test(test_levels),        cmocka_unit_test(test_finish),
        cmocka_unit_test(test_modes),         cmocka_unit_test(test_widened),
        cmocka_unit_test(test_absent_images),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
