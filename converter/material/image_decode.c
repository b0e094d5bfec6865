/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image_decode.c - the bytes of an image file become pixels: its first bytes tell the format.
 */
#include "material/image.h"

#include <string.h>

psplat_result psplat_image_decode(const void *data, size_t size, psplat_image *image,
                                  psplat_error *error) {
    *image = (psplat_image){0};
    if (size >= 8 && memcmp(data, "\x89PNG\r\n\x1a\n", 8) == 0)
        return psplat_image_decode_png(data, size, image, error);
    if (size >= 3 && memcmp(data, "\xff\xd8\xff", 3) == 0)
        return psplat_image_decode_jpeg(data, size, image, error);
    return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0, "the image is neither PNG nor JPEG");
}
