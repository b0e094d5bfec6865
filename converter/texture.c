/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texture.c - what a texture says over a part of an image: the pyramid's level is that of the
 * part's shorter axis, and several places along the longer one are averaged, as graphics hardware
 * filters anisotropically (EXT_texture_filter_anisotropic).
 */
#include "texture.h"

#include <math.h>
#include <string.h>

/* Places along the longer axis. Beyond, the level rises instead. */
enum { MOST_PLACES = 16 };
/* Coordinates are of no meaning beyond; and stay within integers. */
static const double greatest_coordinate = 1e9;

void psplat_texture_transform(const psplat_texture *texture, const double uv[2], double st[2]) {
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

/* A coordinate in texels of a level; what is not a number is 0. */
static double texels(double s, uint32_t size) {
    if (!(fabs(s) <= greatest_coordinate))
        s = s > 0 ? greatest_coordinate : s < 0 ? -greatest_coordinate : 0;
    return s * size;
}

static void nearest(const psplat_texture *texture, const psplat_pyramid *pyramid,
                    const double st[2], float rgba[4]) {
    const psplat_level *l = &pyramid->levels[0];
    int64_t x = (int64_t)floor(texels(st[0], l->width));
    int64_t y = (int64_t)floor(texels(st[1], l->height));
    psplat_pyramid_texel(pyramid, 0, wrap_texel(texture->wrap[0], x, l->width),
                         wrap_texel(texture->wrap[1], y, l->height), rgba);
}

/* Between the four texels about a place, weighted by nearness, added to sum. */
static void add_bilinear(const psplat_texture *texture, const psplat_pyramid *pyramid,
                         uint32_t level, const double st[2], double weight, double sum[4]) {
    const psplat_level *l = &pyramid->levels[level];
    double x = texels(st[0], l->width) - 0.5, y = texels(st[1], l->height) - 0.5;
    double fx = x - floor(x), fy = y - floor(y);
    for (int corner = 0; corner < 4; ++corner) {
        float texel[4];
        uint32_t column = wrap_texel(texture->wrap[0], (int64_t)floor(x) + (corner & 1), l->width);
        uint32_t row = wrap_texel(texture->wrap[1], (int64_t)floor(y) + (corner >> 1), l->height);
        double w = weight * (corner & 1 ? fx : 1 - fx) * (corner >> 1 ? fy : 1 - fy);
        if (!(w > 0)) continue;
        psplat_pyramid_texel(pyramid, level, column, row, texel);
        for (int k = 0; k < 4; ++k) sum[k] += w * (double)texel[k];
    }
}

/* Between the two levels that a length in texels of level 0 lies between. */
static void add_trilinear(const psplat_texture *texture, const psplat_pyramid *pyramid,
                          double length, const double st[2], double weight, double sum[4]) {
    double level = fmin(fmax(log2(length), 0), pyramid->level_count - 1);
    uint32_t low = (uint32_t)level;
    double rest = level - low;
    add_bilinear(texture, pyramid, low, st, weight * (1 - rest), sum);
    if (rest > 0) add_bilinear(texture, pyramid, low + 1, st, weight * rest, sum);
}

/* Principal half axes, in texels, of the ellipse with conjugate half axes a and b: *longer is the
 * length of one, whose direction in image coordinates is axis; the other one's is returned. */
static double principal_axes(const psplat_pyramid *pyramid, const double axes[2][2], double *longer,
                             double axis[2]) {
    const double size[2] = {pyramid->levels[0].width, pyramid->levels[0].height};
    double xx = 0, xy = 0, yy = 0;
    for (int i = 0; i < 2; ++i) {
        double x = axes[i][0] * size[0], y = axes[i][1] * size[1];
        xx += x * x, xy += x * y, yy += y * y;
    }
    double mean = (xx + yy) / 2, half = hypot((xx - yy) / 2, xy);
    double angle = atan2(2 * xy, xx - yy) / 2;
    *longer = sqrt(mean + half);
    axis[0] = *longer * cos(angle) / size[0];
    axis[1] = *longer * sin(angle) / size[1];
    return sqrt(fmax(mean - half, 0));
}

void psplat_texture_average(const psplat_texture *texture, const psplat_pyramid *pyramid,
                            const double st[2], const double axes[2][2], float rgba[4]) {
    double longer, axis[2], sum[4] = {0};
    double shorter = principal_axes(pyramid, axes, &longer, axis);
    if (!isfinite(longer)) longer = shorter = 0;
    if (longer <= 0.5 && texture->nearest) {
        nearest(texture, pyramid, st, rgba);
        return;
    }
    shorter = fmax(fmax(shorter, longer / MOST_PLACES), 0.5);
    int places = longer > shorter ? (int)ceil(longer / shorter) : 1;
    for (int i = 0; i < places; ++i) {
        double along = (2 * i + 1.0) / places - 1;
        const double at[2] = {st[0] + along * axis[0], st[1] + along * axis[1]};
        add_trilinear(texture, pyramid, 2 * shorter, at, 1.0 / places, sum);
    }
    for (int k = 0; k < 4; ++k) rgba[k] = (float)sum[k];
}
