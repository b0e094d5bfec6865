/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mipmap.c - mipmaps of texture images, averaged in linear light (Williams 1983).
 *
 * Level 0 is the image as it is stored. The coarser levels have 16 bits a channel, since 8 bits of
 * linear light would lose dark colours.
 */
#include "material/mipmap.h"

#include "material/image.h"

#include <math.h>
#include <stdlib.h>

float psplat_linear_of_srgb(float value) {
    return value <= 0.04045f ? value / 12.92f : powf((value + 0.055f) / 1.055f, 2.4f);
}

float psplat_srgb_of_linear(float value) {
    if (!(value > 0)) return 0;
    if (value >= 1) return 1;
    return value <= 0.0031308f ? value * 12.92f : 1.055f * powf(value, 1 / 2.4f) - 0.055f;
}

void psplat_mipmap_texel(const psplat_mipmap *mipmap, uint32_t level, uint32_t x, uint32_t y,
                         float rgba[4]) {
    const psplat_mipmap_level *l = &mipmap->levels[level];
    size_t at = ((size_t)y * l->width + x) * 4;
    if (level == 0) {
        const uint8_t *stored = mipmap->image->pixels + at;
        for (int k = 0; k < 3; ++k) rgba[k] = mipmap->linear[stored[k]];
        rgba[3] = (float)stored[3] / 255;
    } else {
        for (int k = 0; k < 4; ++k) rgba[k] = (float)l->pixels[at + (size_t)k] / 65535;
    }
}

/* The texels of the finer level, along one axis, that a texel of the coarser level covers: the
 * first, their number (1 ... 3) and their weights. Sides that are not even are divided into equal
 * parts, too, so that texels at the ends count in part. */
typedef struct span {
    uint32_t first, count;
    float weights[4];
} span;

static span covered_span(uint32_t fine, uint32_t coarse, uint32_t at) {
    double step = (double)fine / coarse, low = at * step, high = fmin(low + step, fine);
    span s = {.first = (uint32_t)low};
    for (uint32_t i = s.first; i < fine && i < high && s.count < 4; ++i)
        s.weights[s.count++] = (float)((fmin(high, i + 1.0) - fmax(low, i)) / step);
    return s;
}

static void average_texels(const psplat_mipmap *mipmap, uint32_t level, uint32_t x, uint32_t y,
                           uint16_t pixel[4]) {
    const psplat_mipmap_level *fine = &mipmap->levels[level - 1], *coarse = &mipmap->levels[level];
    span across = covered_span(fine->width, coarse->width, x);
    span down = covered_span(fine->height, coarse->height, y);
    float sum[4] = {0};
    for (uint32_t j = 0; j < down.count; ++j)
        for (uint32_t i = 0; i < across.count; ++i) {
            float rgba[4];
            psplat_mipmap_texel(mipmap, level - 1, across.first + i, down.first + j, rgba);
            for (int k = 0; k < 4; ++k) sum[k] += across.weights[i] * down.weights[j] * rgba[k];
        }
    for (int k = 0; k < 4; ++k) pixel[k] = (uint16_t)(fminf(sum[k], 1) * 65535 + 0.5f);
}

static int add_level(psplat_mipmap *mipmap) {
    const psplat_mipmap_level *fine = &mipmap->levels[mipmap->level_count - 1];
    psplat_mipmap_level coarse = {.width = fine->width > 1 ? fine->width / 2 : 1,
                                  .height = fine->height > 1 ? fine->height / 2 : 1};
    coarse.pixels = malloc((size_t)coarse.width * coarse.height * 4 * sizeof *coarse.pixels);
    if (!coarse.pixels) return 0;
    uint32_t level = mipmap->level_count++;
    mipmap->levels[level] = coarse;
    for (uint32_t y = 0; y < coarse.height; ++y)
        for (uint32_t x = 0; x < coarse.width; ++x)
            average_texels(mipmap, level, x, y, coarse.pixels + ((size_t)y * coarse.width + x) * 4);
    return 1;
}

psplat_result psplat_mipmap_build(const psplat_image *image, int is_srgb, psplat_mipmap *mipmap) {
    *mipmap = (psplat_mipmap){.image = image, .is_srgb = is_srgb};
    if (!image || !image->pixels) return PSPLAT_OK;
    for (int i = 0; i < 256; ++i) {
        float stored = (float)i / 255;
        mipmap->linear[i] = is_srgb ? psplat_linear_of_srgb(stored) : stored;
    }
    mipmap->levels[0] = (psplat_mipmap_level){.width = image->width, .height = image->height};
    mipmap->level_count = 1;
    for (;;) {
        const psplat_mipmap_level *last = &mipmap->levels[mipmap->level_count - 1];
        if (last->width == 1 && last->height == 1) return PSPLAT_OK;
        if (add_level(mipmap)) continue;
        psplat_mipmap_free(mipmap);
        return PSPLAT_ERROR_MEMORY;
    }
}

void psplat_mipmap_free(psplat_mipmap *mipmap) {
    for (uint32_t i = 0; i < mipmap->level_count; ++i) free(mipmap->levels[i].pixels);
    *mipmap = (psplat_mipmap){0};
}
