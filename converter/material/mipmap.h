/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mipmap.h - mipmaps of texture images, averaged in linear light (Williams 1983).
 */
#ifndef PHONGSPLAT_MATERIAL_MIPMAP_H
#define PHONGSPLAT_MATERIAL_MIPMAP_H

#include <phongsplat/splat.h>

#include "material/image.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The most levels of an image: its pixels fit into 26 bits, and each level halves both sides. */
#define PSPLAT_MAX_LEVELS 28

/* A level coarser than the image itself: RGBA, 0 ... 65535, in linear light. */
typedef struct psplat_mipmap_level {
    uint16_t *pixels;
    uint32_t width, height;
} psplat_mipmap_level;

/* An image and its coarser levels. Each level halves the sides of the one before, rounded down. */
typedef struct psplat_mipmap {
    const psplat_image *image;                     /* level 0, as stored; not owned */
    int is_srgb;                                   /* R, G, B of the image are sRGB */
    psplat_mipmap_level levels[PSPLAT_MAX_LEVELS]; /* levels[0] has a size but no pixels */
    uint32_t level_count;                          /* 0 if there are no pixels */
    float linear[256];                             /* linear value of each stored R, G, B */
} psplat_mipmap;

/* Builds the levels of an image, which may be NULL and must live as long as the mipmap. is_srgb
 * says that R, G, B are sRGB, as those of base colours and emission are. An image without pixels
 * gives no levels. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mipmap_build(const psplat_image *image, int is_srgb, psplat_mipmap *mipmap);

void psplat_mipmap_free(psplat_mipmap *mipmap);

/* Stores a texel of a level in linear light, 0 ... 1. */
void psplat_mipmap_texel(const psplat_mipmap *mipmap, uint32_t level, uint32_t x, uint32_t y,
                         float rgba[4]);

/* These convert a value 0 ... 1 from sRGB (IEC 61966-2-1) to linear light and back. */
float psplat_linear_of_srgb(float value);

float psplat_srgb_of_linear(float value);

#ifdef __cplusplus
}
#endif
#endif
