/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * png.c - pixels to PNG through libpng, in memory. libpng reports errors by longjmp; it stays in
 * this file, and what must survive it lives in one struct.
 */
#include "picture.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

typedef struct encoder {
    png_structp png;
    png_infop info;
    uint8_t *data;
    size_t size, capacity;
    char message[128];
} encoder;

static void on_error(png_structp png, png_const_charp message) {
    encoder *e = png_get_error_ptr(png);
    strncpy(e->message, message, sizeof e->message - 1);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

static void on_write(png_structp png, png_bytep bytes, size_t count) {
    encoder *e = png_get_io_ptr(png);
    if (e->capacity - e->size < count) {
        size_t capacity = 2 * e->capacity + count + 4096;
        uint8_t *data = realloc(e->data, capacity);
        if (!data) png_error(png, "out of memory");
        e->data = data;
        e->capacity = capacity;
    }
    memcpy(e->data + e->size, bytes, count);
    e->size += count;
}

static void on_flush(png_structp png) {
    (void)png;
}

/* Returns 1 when all went well; e->data is freed by the caller either way. */
static int encode(encoder *e, const uint8_t *pixels, int width, int height, int channels) {
    if (setjmp(png_jmpbuf(e->png))) return 0;
    png_set_write_fn(e->png, e, on_write, on_flush);
    png_set_IHDR(e->png, e->info, (png_uint_32)width, (png_uint_32)height, 8,
                 channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(e->png, e->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(e->png, e->info);
    size_t stride = (size_t)width * (size_t)channels;
    for (int y = 0; y < height; ++y) png_write_row(e->png, pixels + (size_t)y * stride);
    png_write_end(e->png, NULL);
    return 1;
}

psplat_result psplat_png_encode(const uint8_t *pixels, int width, int height, int channels,
                                uint8_t **data, size_t *size, psplat_error *error) {
    encoder e = {.message = "out of memory"};
    int done = 0;
    e.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &e, on_error, on_warning);
    if (e.png) e.info = png_create_info_struct(e.png);
    if (e.info) done = encode(&e, pixels, width, height, channels);
    png_destroy_write_struct(&e.png, &e.info);
    if (!done) {
        free(e.data);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the picture cannot be encoded: %s",
                           e.message);
    }
    *data = e.data;
    *size = e.size;
    return PSPLAT_OK;
}
