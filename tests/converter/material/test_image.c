/* SPDX-License-Identifier: MIT
 *
 * test_image.c - tests of reading PNG and JPEG images: every kind comes out as RGBA bytes as
 * stored, and a broken one fails with its cause. The images are encoded by libpng and libjpeg in
 * the test, so that every pixel is known.
 */
#include "picture_bytes.h"
#include "material/image.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 5, HEIGHT = 3 };

static psplat_image decode(uint8_t *data, size_t size) {
    psplat_image image;
    psplat_error error;
    if (psplat_image_decode(data, size, &image, &error)) fail_msg("%s", error.text);
    free(data);
    return image;
}

static void test_png_rgba(void **state) {
    (void)state;
    uint8_t pixels[HEIGHT][WIDTH][4];
    for (size_t i = 0; i < sizeof pixels; ++i) (&pixels[0][0][0])[i] = (uint8_t)(i * 37);
    size_t size;
    uint8_t *data = png_of(pixels, WIDTH, HEIGHT, PNG_FORMAT_RGBA, NULL, &size);
    psplat_image image = decode(data, size);
    assert_int_equal(image.width, WIDTH);
    assert_int_equal(image.height, HEIGHT);
    assert_memory_equal(image.pixels, pixels, sizeof pixels);
    psplat_image_free(&image);
    assert_null(image.pixels);
}

static void test_png_other_channels(void **state) {
    (void)state;
    static const uint8_t grey[4] = {0, 90, 200, 255};
    static const uint8_t pair[2][2] = {{10, 20}, {30, 40}}; /* grey and alpha */
    static const uint8_t rgb[2][3] = {{1, 2, 3}, {250, 251, 252}};
    size_t size;
    uint8_t *data = png_of(grey, 4, 1, PNG_FORMAT_GRAY, NULL, &size);
    psplat_image image = decode(data, size);
    for (size_t i = 0; i < 4; ++i) {
        const uint8_t expected[4] = {grey[i], grey[i], grey[i], 255};
        assert_memory_equal(image.pixels + 4 * i, expected, 4);
    }
    psplat_image_free(&image);
    data = png_of(pair, 2, 1, PNG_FORMAT_GA, NULL, &size);
    image = decode(data, size);
    assert_memory_equal(image.pixels, "\x0a\x0a\x0a\x14\x1e\x1e\x1e\x28", 8);
    psplat_image_free(&image);
    data = png_of(rgb, 1, 2, PNG_FORMAT_RGB, NULL, &size);
    image = decode(data, size);
    assert_memory_equal(image.pixels, "\x01\x02\x03\xff\xfa\xfb\xfc\xff", 8);
    psplat_image_free(&image);
}

static void test_png_palette(void **state) {
    (void)state;
    static const uint8_t pixels[3] = {7, 0, 255};
    uint8_t map[256][4];
    for (size_t i = 0; i < 256; ++i) {
        const uint8_t entry[4] = {(uint8_t)i, (uint8_t)(255 - i), 3, (uint8_t)(i / 2)};
        memcpy(map[i], entry, 4);
    }
    size_t size;
    uint8_t *data = png_of(pixels, 3, 1, PNG_FORMAT_RGBA_COLORMAP, map, &size);
    psplat_image image = decode(data, size);
    for (size_t i = 0; i < 3; ++i) assert_memory_equal(image.pixels + 4 * i, map[pixels[i]], 4);
    psplat_image_free(&image);
}

static void test_png_sixteen_bits(void **state) {
    (void)state;
    /* libpng takes these values as linear and says so in the file; the reader must ignore that. */
    static const uint16_t grey[3] = {0, 0x8080, 0xffff};
    size_t size;
    uint8_t *data = png_of(grey, 3, 1, PNG_FORMAT_LINEAR_Y, NULL, &size);
    psplat_image image = decode(data, size);
    assert_memory_equal(image.pixels, "\x00\x00\x00\xff\x80\x80\x80\xff\xff\xff\xff\xff", 12);
    psplat_image_free(&image);
}

/* A 16-bit interlaced image needs a path of its own, because libpng's simplified interface would
 * change its values. */
static void test_png_sixteen_bits_interlaced(void **state) {
    (void)state;
    static const uint8_t header[] = "\0\0\0\1\0\0\0\1\x10\0\0\0\1\x1d\xe9\x77\x80";
    static const uint16_t grey = 0x8080;
    size_t size;
    uint8_t *data = png_of(&grey, 1, 1, PNG_FORMAT_LINEAR_Y, NULL, &size);
    memcpy(data + 16, header, sizeof header - 1);
    psplat_image image;
    psplat_error error;
    assert_int_equal(psplat_image_decode(data, size, &image, &error), PSPLAT_ERROR_UNSUPPORTED);
    assert_null(image.pixels);
    free(data);
}

/* Returns the same picture with another chunk in place of sRGB, which libpng puts after the header.
 */
static uint8_t *with_chunk(uint8_t *png, size_t *size, const void *chunk, size_t chunk_size) {
    enum { BEFORE = 8 + 25, SRGB = 13 };
    uint8_t *data = malloc(*size + chunk_size);
    assert_non_null(data);
    assert_memory_equal(png + BEFORE + 4, "sRGB", 4);
    memcpy(data, png, BEFORE);
    memcpy(data + BEFORE, chunk, chunk_size);
    memcpy(data + BEFORE + chunk_size, png + BEFORE + SRGB, *size - BEFORE - SRGB);
    *size += chunk_size - SRGB;
    free(png);
    return data;
}

static void test_png_colour_chunks_do_not_matter(void **state) {
    (void)state;
    static const uint8_t gamma_1[] = "\0\0\0\4gAMA\0\1\x86\xa0\x31\xe8\x96\x5f";
    static const uint8_t pixel[4] = {10, 90, 200, 128};
    size_t size;
    uint8_t *data = png_of(pixel, 1, 1, PNG_FORMAT_RGBA, NULL, &size);
    data = with_chunk(data, &size, gamma_1, 16);
    psplat_image image = decode(data, size);
    assert_memory_equal(image.pixels, pixel, 4);
    psplat_image_free(&image);
}

/* An unknown chunk that is marked as critical is refused. */
static void test_png_unknown_critical_chunk(void **state) {
    (void)state;
    static const uint8_t unknown[] = "\0\0\0\0ABCD\xdb\x17\x20\xa5", pixel[3] = {0};
    size_t size;
    uint8_t *data = png_of(pixel, 1, 1, PNG_FORMAT_RGB, NULL, &size);
    data = with_chunk(data, &size, unknown, 12);
    psplat_image image;
    psplat_error error = {0};
    assert_int_equal(psplat_image_decode(data, size, &image, &error), PSPLAT_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "ABCD: unhandled critical chunk"));
    free(data);
}

static void test_jpeg(void **state) {
    (void)state;
    uint8_t rgb[32][32][3], grey[32][32];
    for (size_t y = 0; y < 32; ++y)
        for (size_t x = 0; x < 32; ++x) {
            const uint8_t pixel[3] = {(uint8_t)(8 * x), (uint8_t)(8 * y), 100};
            memcpy(rgb[y][x], pixel, 3);
            grey[y][x] = (uint8_t)(4 * (x + y));
        }
    for (int progressive = 0; progressive < 2; ++progressive) {
        size_t size;
        uint8_t *data = jpeg_of(&rgb[0][0][0], 32, 32, 3, progressive, &size);
        psplat_image image = decode(data, size);
        for (size_t i = 0; i < 32 * 32; ++i) {
            /* At quality 100 a smooth picture changes by little, because colours are stored at half
             * the resolution. */
            for (size_t k = 0; k < 3; ++k)
                assert_in_range(image.pixels[4 * i + k] + 16 - (&rgb[0][0][0])[3 * i + k], 6, 26);
            assert_int_equal(image.pixels[4 * i + 3], 255);
        }
        psplat_image_free(&image);
        data = jpeg_of(&grey[0][0], 32, 32, 1, progressive, &size);
        image = decode(data, size);
        for (size_t i = 0; i < 32 * 32; ++i)
            for (size_t k = 0; k < 3; ++k)
                assert_in_range(image.pixels[4 * i + k] + 16 - (&grey[0][0])[i], 13, 19);
        psplat_image_free(&image);
    }
}

/* Asserts that the file is refused wherever it is cut off, and that nothing is left behind. */
static void refuse_beginnings(const uint8_t *data, size_t size, size_t least) {
    for (size_t cut = least; cut < size; ++cut) {
        psplat_image image;
        psplat_error error = {0};
        /* A copy of exact size lets sanitizers see reads beyond its end. */
        uint8_t *part = malloc(cut);
        assert_non_null(part);
        memcpy(part, data, cut);
        psplat_result result = psplat_image_decode(part, cut, &image, &error);
        free(part);
        if (result != PSPLAT_ERROR_FORMAT) fail_msg("%zu bytes of %zu: %d", cut, size, result);
        assert_null(image.pixels);
        assert_true(error.text[0] != 0);
    }
}

static void test_truncated(void **state) {
    (void)state;
    uint8_t pixels[16][16][3];
    for (size_t i = 0; i < sizeof pixels; ++i) (&pixels[0][0][0])[i] = (uint8_t)(i * i);
    size_t size;
    uint8_t *data = png_of(pixels, 16, 16, PNG_FORMAT_RGB, NULL, &size);
    refuse_beginnings(data, size - 20, 8); /* The trailer behind the pixels may be missing. */
    free(data);
    data = jpeg_of(&pixels[0][0][0], 16, 16, 3, 0, &size);
    refuse_beginnings(data, size - 2, 3);
    free(data);
}

/* Bytes are changed one by one in a fixed pattern: the result is an image or an error, and no other
 * harm. */
static void test_corrupted(void **state) {
    (void)state;
    uint8_t pixels[8][8][3] = {{{0}}};
    uint64_t random = 1;
    for (int kind = 0; kind < 2; ++kind) {
        size_t size;
        uint8_t *data = kind ? jpeg_of(&pixels[0][0][0], 8, 8, 3, 1, &size)
                             : png_of(pixels, 8, 8, PNG_FORMAT_RGB, NULL, &size);
        for (size_t i = 8; i < size; ++i) {
            psplat_image image;
            uint8_t before = data[i];
            random = random * 6364136223846793005u + 1442695040888963407u;
            data[i] = (uint8_t)(random >> 56);
            psplat_result result = psplat_image_decode(data, size, &image, NULL);
            assert_true((result == PSPLAT_OK) == (image.pixels != NULL));
            psplat_image_free(&image);
            data[i] = before;
        }
        free(data);
    }
}

static void test_too_large(void **state) {
    (void)state;
    uint8_t pixel[3] = {0};
    psplat_image image;
    psplat_error error;
    size_t size;
    uint8_t *data = jpeg_of(pixel, 1, 1, 3, 0, &size);
    /* The frame header consists of its marker, two bytes of length, one of precision, then height
     * and width. */
    for (size_t i = 0; i + 9 < size; ++i)
        if (data[i] == 0xff && data[i + 1] == 0xc0) memcpy(data + i + 5, "\xff\xdc\xff\xdc", 4);
    assert_int_equal(psplat_image_decode(data, size, &image, &error), PSPLAT_ERROR_RANGE);
    assert_null(image.pixels);
    free(data);
    static const uint8_t header[] =
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\xff\xdc\0\0\xff\xdc\x8\6\0\0\0"
        "\x93\x57\x16\x1b\0\0\0\0IDAT\x35\xaf\x06\x1e";
    assert_int_equal(psplat_image_decode(header, sizeof header - 1, &image, &error),
                     PSPLAT_ERROR_RANGE);
    assert_null(image.pixels);
    assert_int_equal(psplat_image_allocate(&image, 1u << 13, (1u << 13) + 1, &error),
                     PSPLAT_ERROR_RANGE);
    assert_int_equal(psplat_image_allocate(&image, 0, 5, &error), PSPLAT_ERROR_RANGE);
    assert_int_equal(psplat_image_allocate(&image, SIZE_MAX, SIZE_MAX, &error), PSPLAT_ERROR_RANGE);
}

static void test_unknown(void **state) {
    (void)state;
    psplat_image image;
    psplat_error error;
    assert_int_equal(psplat_image_decode("RIFF....WEBPVP8 ", 16, &image, &error),
                     PSPLAT_ERROR_UNSUPPORTED);
    assert_int_equal(psplat_image_decode("", 0, &image, &error), PSPLAT_ERROR_UNSUPPORTED);
}

/* An image that is read keeps its bytes beside the pixels; one that cannot be keeps nothing. */
static void test_bytes_are_kept(void **state) {
    (void)state;
    static const uint8_t pixels[2][2][3] = {{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}};
    psplat_image image;
    size_t size;
    uint8_t *data = png_of(pixels, 2, 2, PNG_FORMAT_RGB, NULL, &size);
    assert_int_equal(psplat_image_read(data, size, &image, NULL), PSPLAT_OK);
    assert_int_equal(image.size, size);
    assert_memory_equal(image.bytes, data, size);
    assert_string_equal(image.mime_type, "image/png");
    assert_int_equal(image.pixels[12], 10);
    psplat_image_free(&image);
    assert_int_equal(psplat_image_read(data, size / 2, &image, NULL), PSPLAT_ERROR_FORMAT);
    assert_null(image.bytes);
    free(data);
    data = jpeg_of(&pixels[0][0][0], 2, 2, 3, 0, &size);
    assert_int_equal(psplat_image_read(data, size, &image, NULL), PSPLAT_OK);
    assert_string_equal(image.mime_type, "image/jpeg");
    psplat_image_free(&image);
    free(data);
}

/* Chunks that glTF ignores are left out of the bytes that are kept; all others stay. */
static void test_colour_chunks_are_dropped(void **state) {
    (void)state;
    static const uint8_t gamma_1[] = "\0\0\0\4gAMA\0\1\x86\xa0\x31\xe8\x96\x5f";
    static const uint8_t pixel[4] = {10, 90, 200, 128};
    enum { BEFORE = 8 + 25, GAMMA = 16 };
    psplat_image image;
    size_t size;
    uint8_t *data = png_of(pixel, 1, 1, PNG_FORMAT_RGBA, NULL, &size);
    data = with_chunk(data, &size, gamma_1, GAMMA);
    assert_int_equal(psplat_image_read(data, size, &image, NULL), PSPLAT_OK);
    assert_int_equal(image.size, size - GAMMA);
    assert_memory_equal(image.bytes, data, BEFORE);
    assert_memory_equal(image.bytes + BEFORE, data + BEFORE + GAMMA, size - BEFORE - GAMMA);
    psplat_image again = decode(data, size);
    assert_memory_equal(image.pixels, again.pixels, 4);
    psplat_image_free(&again);
    psplat_image_free(&image);
}

int test_image_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bytes_are_kept),
        cmocka_unit_test(test_colour_chunks_are_dropped),
        cmocka_unit_test(test_png_rgba),
        cmocka_unit_test(test_png_other_channels),
        cmocka_unit_test(test_png_palette),
        cmocka_unit_test(test_png_sixteen_bits),
        cmocka_unit_test(test_png_sixteen_bits_interlaced),
        cmocka_unit_test(test_png_colour_chunks_do_not_matter),
        cmocka_unit_test(test_png_unknown_critical_chunk),
        cmocka_unit_test(test_jpeg),
        cmocka_unit_test(test_truncated),
        cmocka_unit_test(test_corrupted),
        cmocka_unit_test(test_too_large),
        cmocka_unit_test(test_unknown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
