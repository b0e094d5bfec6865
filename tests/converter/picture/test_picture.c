/* SPDX-License-Identifier: MIT
 *
 * test_picture.c - tests of turning drawn pixels into a PNG: averaging, encoding and alpha.
 * Expected values follow from the sRGB curve by hand, and PNGs are read back by libpng.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <png.h>
#include <stdlib.h>
#include <string.h>
#include "picture/picture.h"
#include "picture/png_writer.h"

static void test_rows_are_turned_and_values_encoded(void **state) {
    (void)state;
    /* The bottom row is black and white; the top row is mid grey and out of range. */
    const float rgba[] = {0,          0,          0,          1, 1,  1, 1, 1,
                          0.2158605f, 0.2158605f, 0.2158605f, 1, -1, 7, 1, 1};
    const uint8_t expected[] = {128, 128, 128, 0, 255, 255, 0, 0, 0, 255, 255, 255};
    uint8_t pixels[12];
    psplat_picture_reduce(rgba, 2, 2, 1, 3, pixels);
    assert_memory_equal(pixels, expected, sizeof expected); /* 0.2158605 encodes as 128 */
}

static void test_average_is_linear(void **state) {
    (void)state;
    float rgba[9 * 4] = {0};
    uint8_t pixels[3];
    for (int i = 0; i < 9; ++i) rgba[i * 4] = i < 3 ? 1.0f : 0.0f;
    psplat_picture_reduce(rgba, 1, 1, 3, 3, pixels);
    assert_int_equal(pixels[0], 156); /* 255 * (1.055 * (1/3)^(1/2.4) - 0.055) = 155.7 */
    assert_int_equal(pixels[1], 0);
}

static void test_alpha_is_straight(void **state) {
    (void)state;
    /* A pixel a quarter of which is red, and the rest empty, keeps its red. */
    const float rgba[16] = {1, 0, 0, 1};
    const uint8_t expected[] = {255, 0, 0, 64};
    uint8_t pixels[4];
    psplat_picture_reduce(rgba, 1, 1, 2, 4, pixels);
    assert_memory_equal(pixels, expected, 4);
    const float nothing[4] = {0};
    psplat_picture_reduce(nothing, 1, 1, 1, 4, pixels);
    assert_memory_equal(pixels, ((uint8_t[4]){0}), 4);
}

static void assert_png_round_trip(int width, int height, int channels) {
    size_t count = (size_t)width * (size_t)height * (size_t)channels, size = 0;
    uint8_t *pixels = malloc(count), *decoded = malloc(count), *data = NULL;
    for (size_t i = 0; i < count; ++i) pixels[i] = (uint8_t)(i * 2654435761u >> 13);
    psplat_error error = {0};
    assert_int_equal(psplat_png_encode(pixels, width, height, channels, &data, &size, &error),
                     PSPLAT_OK);
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_memory(&image, data, size));
    assert_int_equal(image.width, width);
    assert_int_equal(image.height, height);
    assert_int_equal(image.format, channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB);
    assert_int_equal(image.flags & PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB, 0);
    assert_true(png_image_finish_read(&image, NULL, decoded, 0, NULL));
    assert_memory_equal(pixels, decoded, count);
    free(pixels);
    free(decoded);
    free(data);
}

static void test_png_round_trip(void **state) {
    (void)state;
    assert_png_round_trip(1, 1, 3);
    assert_png_round_trip(7, 300, 3);
    assert_png_round_trip(301, 2, 4);
}

static void test_png_refuses_what_it_cannot_hold(void **state) {
    (void)state;
    uint8_t pixel[4] = {0}, *data = NULL;
    size_t size = 0;
    psplat_error error = {0};
    assert_int_not_equal(psplat_png_encode(pixel, 0, 1, 4, &data, &size, &error), PSPLAT_OK);
    assert_null(data);
    assert_true(strlen(error.text) > 0);
}

int test_picture_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_are_turned_and_values_encoded),
        cmocka_unit_test(test_average_is_linear),
        cmocka_unit_test(test_alpha_is_straight),
        cmocka_unit_test(test_png_round_trip),
        cmocka_unit_test(test_png_refuses_what_it_cannot_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
