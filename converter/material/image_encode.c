/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_encode.c - pixels to PNG through libpng's simplified interface, and to JPEG through
 * libjpeg(-turbo), in memory. The latter reports errors by a function that must not return:
 * longjmp, which stays in this file.
 */
#include "material/image.h"
#include "material/shrink_images.h"

#include <setjmp.h>
#include <stdio.h> /* jpeglib.h needs it */
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <png.h>

/* The quality of JPEG: that of most files, at which a second compression is hardly seen. */
enum { QUALITY = 90 };

static int is_opaque(const psplat_image *image) {
    for (size_t i = 0; i < (size_t)image->width * image->height; ++i)
        if (image->pixels[4 * i + 3] != 255) return 0;
    return 1;
}

/* Returns the pixels without alpha, malloc'ed, or NULL. */
static uint8_t *opaque_pixels(const psplat_image *image) {
    size_t count = (size_t)image->width * image->height;
    uint8_t *pixels = malloc(3 * count);
    for (size_t i = 0; i < count && pixels; ++i) memcpy(pixels + 3 * i, image->pixels + 4 * i, 3);
    return pixels;
}

/* Encodes 3 or 4 components. Returns NULL where that fails. */
static uint8_t *encode_png(const psplat_image *image, const uint8_t *pixels, int components,
                           size_t *size) {
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = image->width,
                     .height = image->height,
                     .format = components == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB};
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(png);
    uint8_t *data = malloc(bytes);
    if (data && png_image_write_to_memory(&png, data, &bytes, 0, pixels, 0, NULL)) {
        *size = bytes;
        return data;
    }
    free(data);
    return NULL;
}

typedef struct encoder {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr handler;
    jmp_buf escape;
    unsigned char *data;
    unsigned long size;
} encoder;

static void on_error(j_common_ptr jpeg) {
    encoder *e = jpeg->client_data;
    longjmp(e->escape, 1);
}

static void compress(encoder *e, const psplat_image *image, uint8_t *pixels) {
    jpeg_create_compress(&e->jpeg);
    jpeg_mem_dest(&e->jpeg, &e->data, &e->size);
    e->jpeg.image_width = image->width;
    e->jpeg.image_height = image->height;
    e->jpeg.input_components = 3;
    e->jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&e->jpeg);
    jpeg_set_quality(&e->jpeg, QUALITY, TRUE);
    jpeg_start_compress(&e->jpeg, TRUE);
    while (e->jpeg.next_scanline < e->jpeg.image_height) {
        JSAMPROW row = pixels + 3 * (size_t)e->jpeg.next_scanline * image->width;
        jpeg_write_scanlines(&e->jpeg, &row, 1);
    }
    jpeg_finish_compress(&e->jpeg);
}

/* Encodes 3 components. Returns NULL where that fails. */
static uint8_t *encode_jpeg(const psplat_image *image, uint8_t *pixels, size_t *size) {
    encoder *e = calloc(1, sizeof *e);
    if (!e) return NULL;
    e->jpeg.err = jpeg_std_error(&e->handler);
    e->jpeg.client_data = e;
    e->handler.error_exit = on_error;
    if (setjmp(e->escape) == 0) {
        compress(e, image, pixels);
    } else {
        free(e->data);
        e->data = NULL;
    }
    uint8_t *data = e->data;
    *size = e->size;
    jpeg_destroy_compress(&e->jpeg);
    free(e);
    return data;
}

psplat_result psplat_image_encode(psplat_image *image, psplat_error *error) {
    int is_jpeg = !strcmp(image->mime_type, "image/jpeg"),
        has_alpha = !is_jpeg && !is_opaque(image);
    uint8_t *pixels = has_alpha ? NULL : opaque_pixels(image), *data = NULL;
    size_t size = 0;
    if (is_jpeg && pixels)
        data = encode_jpeg(image, pixels, &size);
    else if (has_alpha || pixels)
        data = encode_png(image, has_alpha ? image->pixels : pixels, has_alpha ? 4 : 3, &size);
    free(pixels);
    if (!data)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "an image of %u x %u cannot be encoded",
                           (unsigned)image->width, (unsigned)image->height);
    free(image->bytes);
    image->bytes = data;
    image->size = size;
    return PSPLAT_OK;
}
