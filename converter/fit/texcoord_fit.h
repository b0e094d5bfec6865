/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * texcoord_fit.h - least-squares fits of texture coordinates to the samples that splats cover.
 */
#ifndef PHONGSPLAT_FIT_TEXCOORD_FIT_H
#define PHONGSPLAT_FIT_TEXCOORD_FIT_H

#include <phongsplat/splat.h>

#include "base/region.h"

/* The sums over samples from which texture coordinates are fitted. Zero-initialise them. */
typedef struct psplat_texcoord_sums {
    double weight;       /* of all samples */
    double base[2];      /* the coordinates of the first sample, which all are relative to */
    double powers[5][5]; /* of u^i v^j, as all of these times the samples' weights */
    double right[2][6];  /* of s and t times 1, u, v, u^2, u v, v^2 */
    double slopes[2][3]; /* of the changes of s and t with the position on the samples' triangles */
} psplat_texcoord_sums;

/* Adds a sample with parameters uv, which weighs what the default kernel gives the splat there,
 * also beyond the rim, up to twice the radii. slopes are those of its triangle (psplat_surface). */
void psplat_texcoord_sums_add(psplat_texcoord_sums *sums, const double uv[2],
                              const float texcoord[2], const float slopes[6]);

/* Fits coordinates of the second order (bent is 1) or linear ones to the samples of these sums, at
 * least one. Where samples do not determine them, as where they lie in a row, they change as on the
 * samples' triangles on average. */
void psplat_texcoord_sums_fit(const psplat_texcoord_sums *sums, const psplat_region *region,
                              int bent, psplat_texcoord *texcoord);

#endif
