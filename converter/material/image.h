/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * image.h - texture images: PNG and JPEG decoded to RGBA pixels.
 */
#ifndef PHONGSPLAT_MATERIAL_IMAGE_H
#define PHONGSPLAT_MATERIAL_IMAGE_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* An image as its file stores it: 8 bits a channel, RGBA, the first row at the top. Values are not
 * converted to linear light. Without pixels and problem, no material of the file uses the image. */
typedef struct psplat_image {
    uint8_t *pixels; /* height x width x 4, malloc'ed; or NULL */
    char *problem;   /* why the image could not be read, malloc'ed; or NULL */
    uint32_t width, height;
    uint8_t *bytes; /* the encoded image, size bytes, malloc'ed; NULL where only pixels are known */
    size_t size;
    const char *mime_type; /* of bytes, as its first bytes tell: static, or NULL without bytes */
    char *name;            /* what the file calls it, or its path; malloc'ed, or NULL */
} psplat_image;

/* The most pixels of an image: they take 256 MiB. Larger images are refused. */
#define PSPLAT_MAX_IMAGE_PIXELS (1u << 26)

/* Decodes a PNG or a JPEG, which differ in their first bytes. Values are as stored: chunks and
 * profiles for colour spaces are ignored (glTF 2.0 section 3.8.2). Alpha is 255 if the image has
 * none, and grey is copied to R, G and B. psplat_image_free releases *image. Errors:
 * PSPLAT_ERROR_UNSUPPORTED (neither format, or an interlaced PNG of 16 bits), PSPLAT_ERROR_FORMAT,
 * PSPLAT_ERROR_RANGE (too large), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_image_decode(const void *data, size_t size, psplat_image *image,
                                  psplat_error *error);

/* Decodes an image as psplat_image_decode does and keeps a copy of its bytes beside the pixels, so
 * that it can be written as it was. A PNG's chunks for colour space and shape of pixels are left
 * out: glTF ignores them, and the Khronos validator warns of them. Errors are those of
 * psplat_image_decode. */
psplat_result psplat_image_read(const void *data, size_t size, psplat_image *image,
                                psplat_error *error);

/* Decodes a PNG (libpng). *image must be zero. Errors as above. */
psplat_result psplat_image_decode_png(const void *data, size_t size, psplat_image *image,
                                      psplat_error *error);

/* Decodes a JPEG (libjpeg). *image must be zero. Errors as above. */
psplat_result psplat_image_decode_jpeg(const void *data, size_t size, psplat_image *image,
                                       psplat_error *error);

/* Sets the size and allocates the pixels, uninitialised. Errors: PSPLAT_ERROR_RANGE,
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_image_allocate(psplat_image *image, size_t width, size_t height,
                                    psplat_error *error);

/* Frees what the image holds and makes it zero. */
void psplat_image_free(psplat_image *image);

#ifdef __cplusplus
}
#endif
#endif
