/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * png_writer.c - pixels to PNG through libpng's simplified interface, in memory.
 */
#include "picture/png_writer.h"

#include <png.h>
#include <stdlib.h>

psplat_result psplat_png_encode(const uint8_t *pixels, int width, int height, int channels,
                                uint8_t **data, size_t *size, psplat_error *error) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB};
    png_alloc_size_t written = PNG_IMAGE_PNG_SIZE_MAX(image);
    uint8_t *png = malloc(written);
    if (!png)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0,
                           "no memory to encode a picture of %d x %d", width, height);
    if (!png_image_write_to_memory(&image, png, &written, 0, pixels, 0, NULL)) {
        free(png);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "the picture cannot be encoded: %s",
                           image.message);
    }
    *data = png;
    *size = written;
    return PSPLAT_OK;
}
