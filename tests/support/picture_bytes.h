/* SPDX-License-Identifier: MIT
 *
 * picture_bytes.h - encodes images as PNG or JPEG for tests that read textures. It consists of a
 * header only, so that tests without textures need neither library.
 */
#ifndef PHONGSPLAT_TESTS_PICTURE_BYTES_H
#define PHONGSPLAT_TESTS_PICTURE_BYTES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <png.h>
#include <stdio.h>
#include <stdlib.h>

#include <jpeglib.h>

/* Encodes width x height pixels in a format of libpng's simplified interface (PNG_FORMAT_RGBA ...).
 * The caller frees what is returned. */
static inline uint8_t *png_of(const void *pixels, uint32_t width, uint32_t height, uint32_t format,
                              const void *colormap, size_t *size) {
    png_image image = {.version = PNG_IMAGE_VERSION, .width = width, .height = height};
    image.format = format;
    image.colormap_entries = colormap ? 256 : 0;
    png_alloc_size_t bytes = 0;
    assert_int_equal(png_image_write_to_memory(&image, NULL, &bytes, 0, pixels, 0, colormap), 1);
    uint8_t *data = malloc(bytes);
    assert_non_null(data);
    assert_int_equal(png_image_write_to_memory(&image, data, &bytes, 0, pixels, 0, colormap), 1);
    *size = bytes;
    return data;
}

/* Encodes width x height pixels of 1 (grey) or 3 (RGB) components. The caller frees what is
 * returned. */
static inline uint8_t *jpeg_of(const uint8_t *pixels, uint32_t width, uint32_t height,
                               int components, int progressive, size_t *size) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr handler;
    unsigned char *data = NULL;
    unsigned long bytes = 0;
    jpeg.err = jpeg_std_error(&handler);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &data, &bytes);
    jpeg.image_width = width;
    jpeg.image_height = height;
    jpeg.input_components = components;
    jpeg.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    if (progressive) jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    for (uint32_t y = 0; y < height; ++y) {
        JSAMPROW row = (JSAMPROW)(uintptr_t)(pixels + (size_t)y * width * (size_t)components);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    *size = bytes;
    return data;
}

#endif
