/* SPDX-License-Identifier: MIT
 *
 * texture.c - textures for the reference rasteriser: images with their mipmaps, wrapped and
 * filtered (spec 3.11, and the samplers of glTF 2.0 section 3.8.4, which are GL's).
 */
#include "reference/oracle.h"

#include <math.h>
#include <string.h>

/* ---- levels ---------------------------------------------------------------------------------- */

/* Inverts the sRGB transfer function (IEC 61966-2-1). */
static double decode(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

static int allocate(psplat_oracle_level *level, int width, int height) {
    level->width = width;
    level->height = height;
    level->rgba = psplat_oracle_allocate((size_t)width * (size_t)height, 4 * sizeof *level->rgba);
    return level->rgba != NULL;
}

static void fill(psplat_oracle_level *level, const uint8_t *rgba, int is_srgb) {
    float values[2][256];
    for (int i = 0; i < 256; ++i) {
        values[0][i] = (float)(i / 255.0);
        values[1][i] = (float)(is_srgb ? decode(i / 255.0) : i / 255.0);
    }
    size_t count = (size_t)level->width * (size_t)level->height * 4;
    for (size_t i = 0; i < count; ++i) level->rgba[i] = values[i % 4 != 3][rgba[i]];
}

/* Returns the mean of the texels that a texel of the next level covers: a box, of which the texels
 * at its borders count by the part inside. */
static void shrink_texel(const psplat_oracle_level *from, const psplat_oracle_level *to, int x,
                         int y, float mean[4]) {
    double step[2] = {(double)from->width / to->width, (double)from->height / to->height};
    double low[2] = {x * step[0], y * step[1]}, sum[4] = {0, 0, 0, 0};
    for (int row = (int)low[1]; row < from->height && row < low[1] + step[1]; ++row)
        for (int column = (int)low[0]; column < from->width && column < low[0] + step[0];
             ++column) {
            double wide = fmin(column + 1, low[0] + step[0]) - fmax(column, low[0]);
            double high = fmin(row + 1, low[1] + step[1]) - fmax(row, low[1]);
            const float *texel =
                from->rgba + 4 * ((size_t)row * (size_t)from->width + (size_t)column);
            for (int i = 0; i < 4; ++i) sum[i] += wide * high * (double)texel[i];
        }
    for (int i = 0; i < 4; ++i) mean[i] = (float)(sum[i] / (step[0] * step[1]));
}

static void shrink(const psplat_oracle_level *from, psplat_oracle_level *to) {
    for (int y = 0; y < to->height; ++y)
        for (int x = 0; x < to->width; ++x)
            shrink_texel(from, to, x, y,
                         to->rgba + 4 * ((size_t)y * (size_t)to->width + (size_t)x));
}

/* ---- images ---------------------------------------------------------------------------------- */

int psplat_oracle_image_set(psplat_oracle_image *image, const psplat_pixels *pixels, int is_srgb) {
    int width = (int)pixels->width, height = (int)pixels->height;
    psplat_oracle_level *level = image->levels;
    if (!allocate(level, width, height)) return 0;
    fill(level, pixels->rgba, is_srgb);
    image->level_count = 1;
    while (width > 1 || height > 1) {
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
        if (!allocate(level + 1, width, height)) return 0;
        ++image->level_count;
        shrink(level, level + 1);
        ++level;
    }
    return 1;
}

void psplat_oracle_image_free(psplat_oracle_image *image) {
    for (int i = 0; i < PSPLAT_ORACLE_LEVELS; ++i) psplat_oracle_release(image->levels[i].rgba);
    memset(image, 0, sizeof *image);
}

/* ---- samples --------------------------------------------------------------------------------- */

/* Returns the texel that stands for a whole number beyond the image. */
static int wrap_texel(psplat_wrap wrap, double at, int size) {
    if (wrap == PSPLAT_WRAP_CLAMP) return (int)fmin(fmax(at, 0), size - 1);
    double period = wrap == PSPLAT_WRAP_MIRROR ? 2.0 * size : size;
    double rest = at - period * floor(at / period);
    if (!(rest >= 0 && rest < period)) rest = 0; /* of numbers that doubles hold no digits of */
    return (int)(rest < size ? rest : period - 1 - rest);
}

static const float *texel_at(const psplat_oracle_level *level, const psplat_texture *texture,
                             double x, double y) {
    int column = wrap_texel(texture->wrap[0], x, level->width);
    int row = wrap_texel(texture->wrap[1], y, level->height);
    return level->rgba + 4 * ((size_t)row * (size_t)level->width + (size_t)column);
}

static void sample_nearest(const psplat_oracle_level *level, const psplat_texture *texture,
                           const double st[2], double rgba[4]) {
    const float *texel =
        texel_at(level, texture, floor(st[0] * level->width), floor(st[1] * level->height));
    for (int i = 0; i < 4; ++i) rgba[i] = (double)texel[i];
}

static void sample_linear(const psplat_oracle_level *level, const psplat_texture *texture,
                          const double st[2], double rgba[4]) {
    double x = st[0] * level->width - 0.5, y = st[1] * level->height - 0.5;
    double left = floor(x), top = floor(y), a = x - left, b = y - top;
    for (int i = 0; i < 4; ++i) rgba[i] = 0;
    for (int k = 0; k < 4; ++k) {
        const float *texel = texel_at(level, texture, left + k % 2, top + k / 2);
        double weight = (k % 2 ? a : 1 - a) * (k / 2 ? b : 1 - b);
        for (int i = 0; i < 4; ++i) rgba[i] += weight * (double)texel[i];
    }
}

/* Returns the level of detail: log2 of the texels between this pixel and the next, to the right or
 * above, whichever are more. Where a surface is seen along its contour there are infinitely many.
 */
static double level_of(const psplat_oracle_image *image, double by[2][2]) {
    const double size[2] = {image->levels->width, image->levels->height};
    double most = 0, coarsest = image->level_count - 1;
    for (int k = 0; k < 2; ++k) {
        double texels = hypot(by[k][0] * size[0], by[k][1] * size[1]);
        if (!isfinite(texels)) return coarsest;
        most = fmax(most, texels);
    }
    return most > 0 ? fmin(log2(most), coarsest) : -HUGE_VAL;
}

void psplat_oracle_sample(const psplat_oracle_image *image, const psplat_texture *texture,
                          const double st[2], double by[2][2], double rgba[4]) {
    double level = level_of(image, by), finer[4], coarser[4];
    if (!(level > 0)) {
        if (texture->nearest)
            sample_nearest(image->levels, texture, st, rgba);
        else
            sample_linear(image->levels, texture, st, rgba);
        return;
    }
    int below = (int)level, above = below + 1 < image->level_count ? below + 1 : below;
    sample_linear(&image->levels[below], texture, st, finer);
    sample_linear(&image->levels[above], texture, st, coarser);
    for (int i = 0; i < 4; ++i) rgba[i] = finer[i] + (level - below) * (coarser[i] - finer[i]);
}
