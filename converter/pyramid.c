/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * pyramid.c - an image at all sizes (Williams 1983), averaged in linear light.
 *
 * The image itself stays as it is stored; what is below it has 16 bits, which keep dark colours.
 */
#include "texture.h"

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

void psplat_pyramid_texel(const psplat_pyramid *pyramid, uint32_t level, uint32_t x, uint32_t y,
                          float rgba[4]) {
    const psplat_level *l = &pyramid->levels[level];
    size_t at = ((size_t)y * l->width + x) * 4;
    if (level == 0) {
        const uint8_t *stored = pyramid->image->pixels + at;
        for (int k = 0; k < 3; ++k) rgba[k] = pyramid->linear[stored[k]];
        rgba[3] = (float)stored[3] / 255;
    } else {
        for (int k = 0; k < 4; ++k) rgba[k] = (float)l->pixels[at + (size_t)k] / 65535;
    }
}

/* First texel of the finer level, their number (1 ... 3) and their weights under one of a coarser
 * level: sizes that are not even divide into equal parts all the same. */
typedef struct span {
    uint32_t first, count;
    float weights[4];
} span;

static span span_under(uint32_t fine, uint32_t coarse, uint32_t at) {
    double step = (double)fine / coarse, low = at * step, high = fmin(low + step, fine);
    span s = {.first = (uint32_t)low};
    for (uint32_t i = s.first; i < fine && i < high && s.count < 4; ++i)
        s.weights[s.count++] = (float)((fmin(high, i + 1.0) - fmax(low, i)) / step);
    return s;
}

static void average(const psplat_pyramid *pyramid, uint32_t level, uint32_t x, uint32_t y,
                    uint16_t pixel[4]) {
    const psplat_level *fine = &pyramid->levels[level - 1], *coarse = &pyramid->levels[level];
    span across = span_under(fine->width, coarse->width, x);
    span down = span_under(fine->height, coarse->height, y);
    float sum[4] = {0};
    for (uint32_t j = 0; j < down.count; ++j)
        for (uint32_t i = 0; i < across.count; ++i) {
            float rgba[4];
            psplat_pyramid_texel(pyramid, level - 1, across.first + i, down.first + j, rgba);
            for (int k = 0; k < 4; ++k) sum[k] += across.weights[i] * down.weights[j] * rgba[k];
        }
    for (int k = 0; k < 4; ++k) pixel[k] = (uint16_t)(fminf(sum[k], 1) * 65535 + 0.5f);
}

static int add_level(psplat_pyramid *pyramid) {
    const psplat_level *fine = &pyramid->levels[pyramid->level_count - 1];
    psplat_level coarse = {.width = fine->width > 1 ? fine->width / 2 : 1,
                           .height = fine->height > 1 ? fine->height / 2 : 1};
    coarse.pixels = malloc((size_t)coarse.width * coarse.height * 4 * sizeof *coarse.pixels);
    if (!coarse.pixels) return 0;
    uint32_t level = pyramid->level_count++;
    pyramid->levels[level] = coarse;
    for (uint32_t y = 0; y < coarse.height; ++y)
        for (uint32_t x = 0; x < coarse.width; ++x)
            average(pyramid, level, x, y, coarse.pixels + ((size_t)y * coarse.width + x) * 4);
    return 1;
}

psplat_result psplat_pyramid_build(const psplat_image *image, int is_srgb,
                                   psplat_pyramid *pyramid) {
    *pyramid = (psplat_pyramid){.image = image, .is_srgb = is_srgb};
    if (!image || !image->pixels) return PSPLAT_OK;
    for (int i = 0; i < 256; ++i) {
        float stored = (float)i / 255;
        pyramid->linear[i] = is_srgb ? psplat_linear_of_srgb(stored) : stored;
    }
    pyramid->levels[0] = (psplat_level){.width = image->width, .height = image->height};
    pyramid->level_count = 1;
    for (;;) {
        const psplat_level *last = &pyramid->levels[pyramid->level_count - 1];
        if (last->width == 1 && last->height == 1) return PSPLAT_OK;
        if (add_level(pyramid)) continue;
        psplat_pyramid_free(pyramid);
        return PSPLAT_ERROR_MEMORY;
    }
}

void psplat_pyramid_free(psplat_pyramid *pyramid) {
    for (uint32_t i = 0; i < pyramid->level_count; ++i) free(pyramid->levels[i].pixels);
    *pyramid = (psplat_pyramid){0};
}
