/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_texcoord.c - texture coordinates over a splat, and how far their errors move a texture.
 */
#include "base/vector.h"
#include "splats/splat_texcoord.h"

#include "base/region.h"

#include <math.h>

/* The part of the squared change along a texture's fastest direction that counts as that along any
 * other at least. */
static const double least_change = 0.01;

void psplat_texcoord_at(const psplat_texcoord *t, const double uv[2], double at[2]) {
    double u = uv[0], v = uv[1];
    for (int k = 0; k < 2; ++k)
        at[k] = (double)t->at[k] + u * (double)t->along_u[k] + v * (double)t->along_v[k] +
                u * u * (double)t->along_uu[k] + u * v * (double)t->along_uv[k] +
                v * v * (double)t->along_vv[k];
}

void psplat_texcoord_slopes(const psplat_texcoord *t, const double uv[2], double slopes[2][2]) {
    double u = uv[0], v = uv[1];
    for (int k = 0; k < 2; ++k) {
        double mixed = (double)t->along_uv[k];
        slopes[0][k] = (double)t->along_u[k] + 2 * u * (double)t->along_uu[k] + v * mixed;
        slopes[1][k] = (double)t->along_v[k] + u * mixed + 2 * v * (double)t->along_vv[k];
    }
}

int psplat_texcoord_sense(const psplat_texcoord *t, const double uv[2]) {
    double slopes[2][2];
    psplat_texcoord_slopes(t, uv, slopes);
    double determinant = slopes[0][0] * slopes[1][1] - slopes[0][1] * slopes[1][0];
    return (determinant > 0) - (determinant < 0);
}

/* Finds the inverse of the metric of a region's surface at (u, v): xx, xy, yy. */
static void inverse_metric(const psplat_region *region, const double uv[2], double inverse[3]) {
    double slope[2], u = region->radius[0], v = region->radius[1];
    psplat_region_slope(region, uv, slope);
    double uu = u * u * (1 + slope[0] * slope[0]), vv = v * v * (1 + slope[1] * slope[1]);
    double mixed = u * v * slope[0] * slope[1], determinant = uu * vv - mixed * mixed;
    inverse[0] = vv / determinant, inverse[1] = -mixed / determinant;
    inverse[2] = uu / determinant;
}

/* Returns the length of the way along which coordinates change by an error e, in texels. m holds
 * the products of their changes with the position, in texels over lengths: the ellipse of
 * coordinates that one unit of length reaches. HUGE_VAL where they change nowhere. */
static double way_of(const double m[2][2], const double e[2]) {
    double mean = (m[0][0] + m[1][1]) / 2, half = (m[0][0] - m[1][1]) / 2;
    double greatest = mean + norm2(half, m[0][1]), least = mean - norm2(half, m[0][1]);
    double missing = fmax(least_change * greatest - least, 0);
    /* The part that the slow direction misses is added along it. */
    double angle = atan2(2 * m[0][1], m[0][0] - m[1][1]) / 2, x = -sin(angle), y = cos(angle);
    double a = m[0][0] + missing * x * x, b = m[0][1] + missing * x * y;
    double c = m[1][1] + missing * y * y, determinant = a * c - b * b;
    double squared = (c * e[0] * e[0] - 2 * b * e[0] * e[1] + a * e[1] * e[1]) / determinant;
    return determinant > 0 ? sqrt(fmax(squared, 0)) : HUGE_VAL;
}

psplat_slide psplat_texcoord_slide(const psplat_texcoord *t, const psplat_region *region,
                                   const double uv[2], const double texels[2],
                                   const double error[2]) {
    psplat_slide slide = {.texels = norm2(error[0] * texels[0], error[1] * texels[1])};
    double slopes[2][2], g[3];
    if (!(slide.texels > PSPLAT_LEAST_SLIDE_TEXELS)) return slide;
    psplat_texcoord_slopes(t, uv, slopes);
    inverse_metric(region, uv, g);
    double m[2][2], e[2] = {error[0] * texels[0], error[1] * texels[1]};
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k)
            m[i][k] = texels[i] * texels[k] *
                      (slopes[0][i] * slopes[0][k] * g[0] +
                       (slopes[0][i] * slopes[1][k] + slopes[1][i] * slopes[0][k]) * g[1] +
                       slopes[1][i] * slopes[1][k] * g[2]);
    double way = way_of((const double(*)[2])m, e);
    double seen = 1 - PSPLAT_LEAST_SLIDE_TEXELS / slide.texels;
    /* Coordinates that change nowhere are as wrong as the splat is large. */
    slide.length = way < HUGE_VAL ? seen * way : 2 * region->radius[0];
    return slide;
}

double psplat_texcoord_way(const float slopes[6], const double texels[2], const double error[2]) {
    double changes[2][3], m[2][2], e[2] = {error[0] * texels[0], error[1] * texels[1]};
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 3; ++i) changes[k][i] = (double)slopes[3 * k + i] * texels[k];
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k) m[i][k] = dot3(changes[i], changes[k]);
    return way_of((const double(*)[2])m, e);
}

int psplat_slide_is_kept(const psplat_slide *slide, double length, double texels) {
    if (texels > 0) return slide->texels <= texels;
    return !(length > 0) || slide->length <= length;
}
