/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture.h - images and what a texture says at a place of them. Internal: for those that read
 * materials, and for paint.c.
 */
#ifndef PSPLAT_TEXTURE_H
#define PSPLAT_TEXTURE_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Larger images are refused: 256 MiB of pixels. */
#define PSPLAT_MAX_IMAGE_PIXELS (1u << 26)

/* ---- image.c, image_png.c, image_jpeg.c ------------------------------------------------------ */

/* Decodes a PNG or a JPEG, told apart by their first bytes. Numbers are as stored: chunks and
 * profiles that speak of colour spaces are ignored (glTF 2.0 section 3.8.2). What the image lacks
 * is 255: alpha of three channels; grey fills all three. Errors: UNSUPPORTED (neither), FORMAT,
 * RANGE (too large), MEMORY. */
psplat_result psplat_image_decode(const void *data, size_t size, psplat_image *image,
                                  psplat_error *error);
psplat_result psplat_image_decode_png(const void *data, size_t size, psplat_image *image,
                                      psplat_error *error);
psplat_result psplat_image_decode_jpeg(const void *data, size_t size, psplat_image *image,
                                       psplat_error *error);
/* Allocates the pixels; RANGE, MEMORY. */
psplat_result psplat_image_allocate(psplat_image *image, size_t width, size_t height,
                                    psplat_error *error);
void psplat_image_free(psplat_image *image);

/* ---- pyramid.c: an image at all sizes -------------------------------------------------------- */

#define PSPLAT_MAX_LEVELS 28

/* A level below the image itself: numbers 0 ... 65535 in linear light, RGBA. */
typedef struct psplat_level {
    uint16_t *pixels;
    uint32_t width, height;
} psplat_level;

/* Each level averages the one before by two in both directions. */
typedef struct psplat_pyramid {
    const psplat_image *image; /* level 0, as stored; not owned */
    int is_srgb;
    psplat_level levels[PSPLAT_MAX_LEVELS]; /* levels[0] has a size but no pixels */
    uint32_t level_count;                   /* 0: there is no texture */
    float linear[256];                      /* of the stored R, G, B */
} psplat_pyramid;

/* is_srgb: R, G, B are encoded (base colour and emissive). An image without pixels gives no levels.
 * MEMORY is the only failure. */
psplat_result psplat_pyramid_build(const psplat_image *image, int is_srgb, psplat_pyramid *pyramid);
void psplat_pyramid_free(psplat_pyramid *pyramid);
/* A texel in linear light, 0 ... 1. */
void psplat_pyramid_texel(const psplat_pyramid *pyramid, uint32_t level, uint32_t x, uint32_t y,
                          float rgba[4]);

/* sRGB of IEC 61966-2-1 to linear light, and back; 0 ... 1. */
float psplat_linear_of_srgb(float value);
float psplat_srgb_of_linear(float value);

/* ---- texture.c ------------------------------------------------------------------------------- */

/* Texture coordinates of a mesh to those of the image (KHR_texture_transform), 0 ... 1 across it,
 * before wrapping. No transform at all, six zeros, is the identity. */
void psplat_texture_transform(const psplat_texture *texture, const double uv[2], double st[2]);
/* The mean of a texture over the ellipse of image coordinates about st whose half axes are axes[0]
 * and axes[1] (both may be 0: one point, magnified as the sampler says). */
void psplat_texture_average(const psplat_texture *texture, const psplat_pyramid *pyramid,
                            const double st[2], const double axes[2][2], float rgba[4]);

#ifdef __cplusplus
}
#endif
#endif
