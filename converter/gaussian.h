/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gaussian.h - splats as Gaussians, for viewers that know KHR_gaussian_splatting.
 */
#ifndef PHONGSPLAT_GAUSSIAN_H
#define PHONGSPLAT_GAUSSIAN_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Opaque, about the splat's centre. */
typedef struct psplat_gaussian {
    float rotation[4]; /* unit quaternion x, y, z, w */
    float scale[3];    /* standard deviations along the rotated axes; the last is next to none */
    float harmonic[3]; /* coefficients of degree 0 of the colour, which is encoded by sRGB */
} psplat_gaussian;

/* As wide as what clip lines leave of the ellipse: the second moments of that area about the
 * splat's centre, times this, squared. Less shows gaps between splats, more spills farther over
 * their outlines. A whole ellipse of radius r gets 0.6 r, where its weight is down to a quarter at
 * the edge. */
#define PSPLAT_GAUSSIAN_WIDTH 1.2

/* *gaussians is malloc'ed, one for each splat. Gaussians are not lit: their colours are the splats'
 * own under a fixed light, from above +y, front and right; of unlit materials as they are. Errors:
 * MEMORY. */
psplat_result psplat_gaussians_make(const psplat_splats *splats, psplat_gaussian **gaussians,
                                    psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
