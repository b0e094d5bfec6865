/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_decode.c - the bytes of an image file become pixels: its first bytes tell the format.
 */
#include "material/image.h"

#include <stdlib.h>
#include <string.h>

static int is_png(const void *data, size_t size) {
    return size >= 8 && memcmp(data, "\x89PNG\r\n\x1a\n", 8) == 0;
}

static int is_jpeg(const void *data, size_t size) {
    return size >= 3 && memcmp(data, "\xff\xd8\xff", 3) == 0;
}

psplat_result psplat_image_decode(const void *data, size_t size, psplat_image *image,
                                  psplat_error *error) {
    *image = (psplat_image){0};
    if (is_png(data, size)) return psplat_image_decode_png(data, size, image, error);
    if (is_jpeg(data, size)) return psplat_image_decode_jpeg(data, size, image, error);
    return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0, "the image is neither PNG nor JPEG");
}

/* Drops the chunks gAMA, cHRM, iCCP and pHYs of a valid PNG, in place. Returns its new size. */
static size_t drop_color_space(uint8_t *png, size_t size) {
    static const char *const dropped[] = {"gAMA", "cHRM", "iCCP", "pHYs"};
    enum { SIGNATURE = 8, FRAME = 12 /* length, type and checksum */ };
    size_t kept = SIGNATURE, at = SIGNATURE;
    while (size - at >= FRAME) {
        const uint8_t *b = png + at;
        size_t length = (size_t)b[0] << 24 | (size_t)b[1] << 16 | (size_t)b[2] << 8 | b[3];
        int is_dropped = 0;
        if (length > size - at - FRAME) break;
        for (size_t i = 0; i < sizeof dropped / sizeof *dropped; ++i)
            is_dropped |= !memcmp(b + 4, dropped[i], 4);
        if (!is_dropped) {
            memmove(png + kept, b, length + FRAME);
            kept += length + FRAME;
        }
        at += length + FRAME;
    }
    memmove(png + kept, png + at, size - at);
    return kept + (size - at);
}

psplat_result psplat_image_read(const void *data, size_t size, psplat_image *image,
                                psplat_error *error) {
    psplat_result result = psplat_image_decode(data, size, image, error);
    if (result) return result;
    image->bytes = malloc(size);
    if (!image->bytes) {
        psplat_image_free(image);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for an image of %zu bytes",
                           size);
    }
    memcpy(image->bytes, data, size);
    image->size = size;
    image->mime_type = "image/jpeg";
    if (!is_png(data, size)) return PSPLAT_OK;
    image->mime_type = "image/png";
    image->size = drop_color_space(image->bytes, size);
    return PSPLAT_OK;
}
