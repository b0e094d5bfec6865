/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture_sampling.c - filtered texture lookup: trilinear and anisotropic.
 *
 * The mean over an ellipse is taken as graphics hardware does (EXT_texture_filter_anisotropic): the
 * shorter axis determines the mipmap level, and several samples along the longer axis are averaged.
 */
#include "material/texture_sampling.h"

#include "material/mipmap.h"
#include "material/source_materials.h"

#include <math.h>
#include <string.h>

/* The most samples along the longer axis. A longer ellipse is read from a coarser level. */
enum { MAX_ANISOTROPY = 16 };
/* Image coordinates are clamped to this magnitude, so that texel numbers fit into 64 bits. */
static const double max_coordinate = 1e9;

void psplat_texture_transform(const psplat_texture_info *texture, const double uv[2],
                              double st[2]) {
    static const double none[6];
    const double *m = texture->transform;
    if (memcmp(m, none, sizeof none) == 0) {
        st[0] = uv[0], st[1] = uv[1];
        return;
    }
    st[0] = m[0] * uv[0] + m[1] * uv[1] + m[2];
    st[1] = m[3] * uv[0] + m[4] * uv[1] + m[5];
}

static uint32_t wrap_texel(psplat_wrap wrap, int64_t at, uint32_t size) {
    int64_t n = size;
    if (wrap == PSPLAT_WRAP_CLAMP) return (uint32_t)(at < 0 ? 0 : at >= n ? n - 1 : at);
    int64_t period = wrap == PSPLAT_WRAP_MIRROR ? 2 * n : n;
    at %= period;
    if (at < 0) at += period;
    return (uint32_t)(at < n ? at : period - 1 - at);
}

/* Returns an image coordinate in texels of a level with this size. NaN becomes 0. */
static double texels(double s, uint32_t size) {
    if (!(fabs(s) <= max_coordinate)) s = s > 0 ? max_coordinate : s < 0 ? -max_coordinate : 0;
    return s * size;
}

static void sample_nearest(const psplat_texture_info *texture, const psplat_mipmap *mipmap,
                           const double st[2], float rgba[4]) {
    const psplat_mipmap_level *l = &mipmap->levels[0];
    int64_t x = (int64_t)floor(texels(st[0], l->width));
    int64_t y = (int64_t)floor(texels(st[1], l->height));
    psplat_mipmap_texel(mipmap, 0, wrap_texel(texture->wrap[0], x, l->width),
                        wrap_texel(texture->wrap[1], y, l->height), rgba);
}

/* Adds the bilinear mean of the four texels about st, times weight, to sum. */
static void add_bilinear(const psplat_texture_info *texture, const psplat_mipmap *mipmap,
                         uint32_t level, const double st[2], double weight, double sum[4]) {
    const psplat_mipmap_level *l = &mipmap->levels[level];
    double x = texels(st[0], l->width) - 0.5, y = texels(st[1], l->height) - 0.5;
    double fx = x - floor(x), fy = y - floor(y);
    for (int corner = 0; corner < 4; ++corner) {
        float texel[4];
        uint32_t column = wrap_texel(texture->wrap[0], (int64_t)floor(x) + (corner & 1), l->width);
        uint32_t row = wrap_texel(texture->wrap[1], (int64_t)floor(y) + (corner >> 1), l->height);
        double w = weight * (corner & 1 ? fx : 1 - fx) * (corner >> 1 ? fy : 1 - fy);
        if (!(w > 0)) continue;
        psplat_mipmap_texel(mipmap, level, column, row, texel);
        for (int k = 0; k < 4; ++k) sum[k] += w * (double)texel[k];
    }
}

/* Adds the mean of the two levels whose texels are about length texels of level 0 wide. */
static void add_trilinear(const psplat_texture_info *texture, const psplat_mipmap *mipmap,
                          double length, const double st[2], double weight, double sum[4]) {
    double level = fmin(fmax(log2(length), 0), mipmap->level_count - 1);
    uint32_t low = (uint32_t)level;
    double rest = level - low;
    add_bilinear(texture, mipmap, low, st, weight * (1 - rest), sum);
    if (rest > 0) add_bilinear(texture, mipmap, low + 1, st, weight * rest, sum);
}

/* Finds the principal half axes of the ellipse with conjugate half axes axes[0] and axes[1].
 * Returns the length of the shorter one in texels and stores that of the longer one in *longer.
 * axis is the longer half axis in image coordinates. */
static double principal_axes(const psplat_mipmap *mipmap, const double axes[2][2], double *longer,
                             double axis[2]) {
    const double size[2] = {mipmap->levels[0].width, mipmap->levels[0].height};
    double xx = 0, xy = 0, yy = 0;
    for (int i = 0; i < 2; ++i) {
        double x = axes[i][0] * size[0], y = axes[i][1] * size[1];
        xx += x * x, xy += x * y, yy += y * y;
    }
    double mean = (xx + yy) / 2, difference = hypot((xx - yy) / 2, xy);
    double angle = atan2(2 * xy, xx - yy) / 2;
    *longer = sqrt(mean + difference);
    axis[0] = *longer * cos(angle) / size[0];
    axis[1] = *longer * sin(angle) / size[1];
    return sqrt(fmax(mean - difference, 0));
}

void psplat_texture_average(const psplat_texture_info *texture, const psplat_mipmap *mipmap,
                            const double st[2], const double axes[2][2], float rgba[4]) {
    double longer, axis[2], sum[4] = {0};
    double shorter = principal_axes(mipmap, axes, &longer, axis);
    if (!isfinite(longer)) longer = shorter = 0;
    if (longer <= 0.5 && texture->nearest) {
        sample_nearest(texture, mipmap, st, rgba);
        return;
    }
    shorter = fmax(fmax(shorter, longer / MAX_ANISOTROPY), 0.5);
    int sample_count = longer > shorter ? (int)ceil(longer / shorter) : 1;
    for (int i = 0; i < sample_count; ++i) {
        double along = (2 * i + 1.0) / sample_count - 1;
        const double center[2] = {st[0] + along * axis[0], st[1] + along * axis[1]};
        add_trilinear(texture, mipmap, 2 * shorter, center, 1.0 / sample_count, sum);
    }
    for (int k = 0; k < 4; ++k) rgba[k] = (float)sum[k];
}

void psplat_texture_stored(const psplat_texture_info *texture, const double st[2], float rgba[4]) {
    const psplat_image *image = texture->image;
    double half = texture->nearest ? 0 : 0.5, sum[4] = {0};
    double x = texels(st[0], image->width) - half, y = texels(st[1], image->height) - half;
    double fx = texture->nearest ? 0 : x - floor(x), fy = texture->nearest ? 0 : y - floor(y);
    for (int corner = 0; corner < 4; ++corner) {
        int64_t right = (int64_t)floor(x) + (corner & 1), down = (int64_t)floor(y) + (corner >> 1);
        size_t column = wrap_texel(texture->wrap[0], right, image->width);
        size_t row = wrap_texel(texture->wrap[1], down, image->height);
        double weight = (corner & 1 ? fx : 1 - fx) * (corner >> 1 ? fy : 1 - fy);
        const uint8_t *texel = image->pixels + 4 * (row * image->width + column);
        for (int k = 0; k < 4; ++k) sum[k] += weight * texel[k] / 255;
    }
    for (int k = 0; k < 4; ++k) rgba[k] = (float)sum[k];
}
