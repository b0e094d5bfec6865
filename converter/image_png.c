/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_png.c - PNG to pixels through libpng, in memory. libpng reports errors by longjmp; it stays
 * in this file, and what must survive it lives in one struct.
 */
#include "texture.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

typedef struct decoder {
    png_structp png;
    png_infop info;
    const uint8_t *data;
    size_t size, at;
    psplat_image *image;
    uint8_t **rows;
    psplat_result result;
    psplat_error *error;
} decoder;

static void on_error(png_structp png, png_const_charp message) {
    decoder *d = png_get_error_ptr(png);
    if (!d->result)
        d->result = psplat_fail(d->error, PSPLAT_ERROR_FORMAT, d->at, "PNG: %s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message;
}

static void on_read(png_structp png, png_bytep bytes, size_t size) {
    decoder *d = png_get_io_ptr(png);
    if (size > d->size - d->at) png_error(png, "the data end too early");
    memcpy(bytes, d->data + d->at, size);
    d->at += size;
}

/* Eight bits of RGBA, whatever the file has. */
static void ask_for_rgba(decoder *d) {
    png_set_scale_16(d->png);
    png_set_expand(d->png);
    png_set_gray_to_rgb(d->png);
    png_set_add_alpha(d->png, 0xff, PNG_FILLER_AFTER);
    png_set_interlace_handling(d->png);
    png_read_update_info(d->png, d->info);
}

static void decode(decoder *d) {
    png_set_read_fn(d->png, d, on_read);
    png_set_user_limits(d->png, PSPLAT_MAX_IMAGE_PIXELS, PSPLAT_MAX_IMAGE_PIXELS);
    png_set_chunk_malloc_max(d->png, 1u << 24);
    png_read_info(d->png, d->info);
    size_t width = png_get_image_width(d->png, d->info);
    size_t height = png_get_image_height(d->png, d->info);
    d->result = psplat_image_allocate(d->image, width, height, d->error);
    if (d->result) return;
    ask_for_rgba(d);
    if (png_get_rowbytes(d->png, d->info) != width * 4) png_error(d->png, "not RGBA");
    d->rows = malloc(height * sizeof *d->rows);
    if (!d->rows) {
        d->result = psplat_fail(d->error, PSPLAT_ERROR_MEMORY, 0, "PNG: out of memory");
        return;
    }
    for (size_t y = 0; y < height; ++y) d->rows[y] = d->image->pixels + y * width * 4;
    png_read_image(d->png, d->rows);
}

psplat_result psplat_image_decode_png(const void *data, size_t size, psplat_image *image,
                                      psplat_error *error) {
    decoder d = {.data = data, .size = size, .image = image, .error = error};
    d.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &d, on_error, on_warning);
    d.info = d.png ? png_create_info_struct(d.png) : NULL;
    if (!d.info)
        d.result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "PNG: out of memory");
    else if (setjmp(png_jmpbuf(d.png)) == 0)
        decode(&d);
    png_destroy_read_struct(&d.png, &d.info, NULL);
    free(d.rows);
    if (d.result) psplat_image_free(image);
    return d.result;
}
