/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_png.c - PNG to pixels through libpng's simplified interface, in memory.
 *
 * That interface converts to sRGB what a file says is encoded in another way (gAMA, iCCP), but
 * textures are taken as stored, and it has no switch for that. So it is given only the chunks that
 * make the pixels. Those of 16 bits it then takes as linear, unless a flag says that they are sRGB.
 */
#include "material/image.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

/* Where a file says whether it is interlaced. libpng spoils the pixels of those of 16 bits, which
 * its format tells as linear, where 8 are asked for (its issue 853); before 1.6.51 it even wrote
 * past their end. */
enum { INTERLACE = 28 };

static size_t read_u32(const uint8_t *at) {
    return (size_t)at[0] << 24 | (size_t)at[1] << 16 | (size_t)at[2] << 8 | at[3];
}

/* Critical chunks, whose type begins with a capital letter, and transparency. */
static int makes_pixels(const uint8_t *type) {
    return !(type[0] & 0x20) || memcmp(type, "tRNS", 4) == 0;
}

/* Copies the signature and the chunks that make pixels to kept, which has room for all of data, and
 * returns their size. The last chunk may lack its end: libpng says so where it matters. */
static size_t keep_pixels(const uint8_t *data, size_t size, uint8_t *kept) {
    enum { SIGNATURE = 8, AROUND = 12 }; /* length, type and checksum of a chunk */
    size_t at = SIGNATURE, kept_size = SIGNATURE;
    memcpy(kept, data, SIGNATURE);
    while (size - at >= AROUND) {
        size_t length = read_u32(data + at), left = size - at - AROUND;
        size_t chunk = AROUND + (length < left ? length : left);
        if (makes_pixels(data + at + 4)) {
            memcpy(kept + kept_size, data + at, chunk);
            kept_size += chunk;
        }
        at += chunk;
    }
    return kept_size;
}

static psplat_result decode(png_image *png, const uint8_t *data, size_t size, psplat_image *image,
                            psplat_error *error) {
    if (!png_image_begin_read_from_memory(png, data, size))
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "PNG: %s", png->message);
    if (png->format & PNG_FORMAT_FLAG_LINEAR && data[INTERLACE])
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, INTERLACE,
                           "PNG: 16 bits a channel and interlaced is not read");
    psplat_result result = psplat_image_allocate(image, png->width, png->height, error);
    if (result) return result;
    png->format = PNG_FORMAT_RGBA;
    png->flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
    if (!png_image_finish_read(png, NULL, image->pixels, 0, NULL))
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "PNG: %s", png->message);
    return PSPLAT_OK;
}

psplat_result psplat_image_decode_png(const void *data, size_t size, psplat_image *image,
                                      psplat_error *error) {
    png_image png = {.version = PNG_IMAGE_VERSION};
    uint8_t *kept = malloc(size);
    if (!kept) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "PNG: out of memory");
    psplat_result result = decode(&png, kept, keep_pixels(data, size, kept), image, error);
    png_image_free(&png);
    free(kept);
    if (result) psplat_image_free(image);
    return result;
}
