/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texcoord_fit.c - least-squares fits of texture coordinates to the samples that splats cover
 * (spec eq. 4c).
 *
 * What is fitted is the difference from the mean change on the samples' triangles, by ridge
 * regression: a direction of which the samples say nothing keeps the triangles' own change, and
 * second derivatives of which they say nothing are 0. So coordinates do not fly off between the
 * last sample and the rim. A sample weighs what the kernel gives the splat there: near the rim
 * other splats weigh more, so that errors show less than those in the middle. Those beyond the rim
 * weigh still less, but enough to hold coordinates where few samples lie inside.
 */
#include "fit/texcoord_fit.h"

#include "base/region.h"
#include "base/vector.h"

#include <math.h>

/* The ridges that are added to the mean squares of u and v, which over a disc with these weights
 * are 0.17, and to those of their second powers, 0.07 and 0.023, as parts of 1. Chosen by hand. */
static const double slope_ridge = 1e-3, bend_ridge = 2e-4;

/* The square of (u, v) from which on samples, all beyond the rim, weigh the same: so that weights
 * do not vanish around the smallest splats. Chosen by hand. */
static const double farthest_square = 4;

enum { LINEAR = 3, BENT = 6 }; /* unknowns: 1, u, v, u^2, u v, v^2 */
static const int powers_of[BENT][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};

void psplat_texcoord_sums_add(psplat_texcoord_sums *sums, const double uv[2],
                              const float texcoord[2], const float slopes[6]) {
    double u[5] = {1}, v[5] = {1}, square = uv[0] * uv[0] + uv[1] * uv[1];
    double weight = exp(-(double)PSPLAT_DEFAULT_KERNEL_SHARPNESS * min2(square, farthest_square));
    if (!(sums->weight > 0))
        for (int k = 0; k < 2; ++k) sums->base[k] = (double)texcoord[k];
    sums->weight += weight;
    for (int i = 1; i < 5; ++i) u[i] = u[i - 1] * uv[0], v[i] = v[i - 1] * uv[1];
    for (int i = 0; i < 5; ++i)
        for (int j = 0; i + j < 5; ++j) sums->powers[i][j] += weight * u[i] * v[j];
    for (int k = 0; k < 2; ++k) {
        double value = weight * ((double)texcoord[k] - sums->base[k]);
        for (int i = 0; i < BENT; ++i)
            sums->right[k][i] += value * u[powers_of[i][0]] * v[powers_of[i][1]];
        for (int c = 0; c < 3; ++c) sums->slopes[k][c] += weight * (double)slopes[3 * k + c];
    }
}

/* Factors a symmetric matrix as L D L^T in place, of which only the lower half is read. */
static void factor(double m[BENT][BENT], int unknowns) {
    for (int i = 0; i < unknowns; ++i) {
        for (int j = 0; j < i; ++j) {
            for (int k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k] * m[k][k];
            m[i][j] /= m[j][j];
        }
        for (int k = 0; k < i; ++k) m[i][i] -= m[i][k] * m[i][k] * m[k][k];
    }
}

/* Solves m x = x with the factors of m. */
static void solve(double m[BENT][BENT], int unknowns, double x[BENT]) {
    for (int i = 0; i < unknowns; ++i)
        for (int k = 0; k < i; ++k) x[i] -= m[i][k] * x[k];
    for (int i = 0; i < unknowns; ++i) x[i] /= m[i][i];
    for (int i = unknowns; i-- > 0;)
        for (int k = i + 1; k < unknowns; ++k) x[i] -= m[k][i] * x[k];
}

/* Finds how one coordinate changes along u and v on the samples' triangles on average. */
static void mean_slopes(const psplat_texcoord_sums *sums, int k, const psplat_region *region,
                        double slopes[2]) {
    slopes[0] = dot3(sums->slopes[k], region->u) * region->radius[0] / sums->weight;
    slopes[1] = dot3(sums->slopes[k], region->v) * region->radius[1] / sums->weight;
}

void psplat_texcoord_sums_fit(const psplat_texcoord_sums *sums, const psplat_region *region,
                              int bent, psplat_texcoord *texcoord) {
    int unknowns = bent ? BENT : LINEAR;
    double m[BENT][BENT];
    *texcoord = (psplat_texcoord){.at = {0}};
    for (int i = 0; i < unknowns; ++i)
        for (int j = 0; j < unknowns; ++j)
            m[i][j] =
                sums->powers[powers_of[i][0] + powers_of[j][0]][powers_of[i][1] + powers_of[j][1]];
    for (int i = 1; i < unknowns; ++i) m[i][i] += sums->weight * (i < 3 ? slope_ridge : bend_ridge);
    factor(m, unknowns);
    for (int k = 0; k < 2; ++k) {
        double x[BENT], slopes[2];
        mean_slopes(sums, k, region, slopes);
        for (int i = 0; i < unknowns; ++i) {
            const int *p = powers_of[i];
            x[i] = sums->right[k][i] - slopes[0] * sums->powers[p[0] + 1][p[1]] -
                   slopes[1] * sums->powers[p[0]][p[1] + 1];
        }
        solve(m, unknowns, x);
        texcoord->at[k] = (float)(sums->base[k] + x[0]);
        texcoord->along_u[k] = (float)(x[1] + slopes[0]);
        texcoord->along_v[k] = (float)(x[2] + slopes[1]);
        if (!bent) continue;
        texcoord->along_uu[k] = (float)x[3];
        texcoord->along_uv[k] = (float)x[4];
        texcoord->along_vv[k] = (float)x[5];
    }
}
