/* SPDX-License-Identifier: MIT
 *
 * surface.c - the surface of a splat: its slope at the centre, the bound of its slopes, and a box
 * around it (spec 3.4 and 3.5).
 */
#include "asset/surface.h"

#include <math.h>

void psplat_surface_find_tilt(const psplat_splat *splat, float tilt[2]) {
    double axes[3][3], along[3] = {0, 0, 0};
    psplat_rotation_axes(splat->rotation, axes);
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) along[i] += (double)splat->normal[k] * axes[i][k];
    for (int k = 0; k < 2; ++k) tilt[k] = (float)(along[k] / along[2]);
}

int psplat_surface_is_allowed(const psplat_splat *splat) {
    double s[5], ratio = (double)splat->radius[1] / (double)splat->radius[0];
    for (int i = 0; i < 5; ++i) s[i] = (double)splat->shape[i];
    double change = sqrt(s[2] * s[2] + s[3] * s[3] + s[4] * s[4] * (1 + ratio * ratio));
    return sqrt(s[0] * s[0] + s[1] * s[1]) + change <= 4;
}

/* Finds how far the surface reaches below and above its tangent plane at the centre, along N and in
 * units of r_u. That height is half the quadratic form of a matrix (spec eq. 1a), which over the
 * unit disc is between the eigenvalues or 0. */
static void find_heights(const psplat_splat *splat, double heights[2]) {
    double q = (double)splat->radius[1] / (double)splat->radius[0];
    double uu = -(double)splat->shape[2], vv = -q * (double)splat->shape[3];
    double uv = -q * (double)splat->shape[4];
    double mean = (uu + vv) / 2, spread = sqrt((uu - vv) * (uu - vv) / 4 + uv * uv);
    heights[0] = mean < spread ? (mean - spread) / 2 : 0;
    heights[1] = mean > -spread ? (mean + spread) / 2 : 0;
}

void psplat_surface_find_box(const psplat_splat *splat, double low[3], double high[3]) {
    double axes[3][3], heights[2], x = (double)splat->shape[0], y = (double)splat->shape[1];
    psplat_rotation_axes(splat->rotation, axes);
    find_heights(splat, heights);
    for (int i = 0; i < 3; ++i) {
        double u = (double)splat->radius[0] * (axes[0][i] - x * axes[2][i]);
        double v = (double)splat->radius[1] * (axes[1][i] - y * axes[2][i]);
        double reach = sqrt(u * u + v * v), up = (double)splat->radius[0] * axes[2][i];
        low[i] = fmin(up * heights[0], up * heights[1]) - reach;
        high[i] = fmax(up * heights[0], up * heights[1]) + reach;
    }
}
