/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image.c - room for the pixels of an image.
 */
#include "material/image.h"

#include <stdlib.h>

psplat_result psplat_image_allocate(psplat_image *image, size_t width, size_t height,
                                    psplat_error *error) {
    *image = (psplat_image){0};
    if (width == 0 || height == 0 || width > PSPLAT_MAX_IMAGE_PIXELS / height)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "an image of %zu x %zu pixels; 1 to %u of them are read", width, height,
                           PSPLAT_MAX_IMAGE_PIXELS);
    image->pixels = malloc(width * height * 4);
    if (!image->pixels)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu x %zu pixels",
                           width, height);
    image->width = (uint32_t)width;
    image->height = (uint32_t)height;
    return PSPLAT_OK;
}

void psplat_image_free(psplat_image *image) {
    if (!image) return;
    free(image->pixels);
    free(image->problem);
    free(image->bytes);
    free(image->name);
    *image = (psplat_image){0};
}
