/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * khr_gaussians.h - splats as Gaussians, for viewers that know KHR_gaussian_splatting but not
 * PSPLAT_surface_splats.
 */
#ifndef PHONGSPLAT_EXPORT_KHR_GAUSSIANS_H
#define PHONGSPLAT_EXPORT_KHR_GAUSSIANS_H

#include "material/source_materials.h"
#include "splats/splats.h"

#include <phongsplat/splat.h>

/* A Gaussian at the centre of its splat, opaque. */
typedef struct psplat_gaussian {
    float rotation[4]; /* unit quaternion x, y, z, w */
    float scale[3];    /* standard deviations along the rotated axes, the longest first; the last is
                          tiny for flat splats */
    float harmonic[3]; /* spherical harmonic of degree 0 of the sRGB-encoded colour */
} psplat_gaussian;

/* The standard deviations of a Gaussian are those of what clip lines leave of the ellipse, or of
 * the surface over it, about the splat's centre, times this factor (no unit, chosen by hand). A
 * smaller factor shows gaps between splats, a larger one blurs their outlines. A whole ellipse of
 * radius r gets 0.6 r, so that the Gaussian has fallen to a quarter at its edge. */
#define PSPLAT_GAUSSIAN_WIDTH 1.2

/* Makes a Gaussian of every splat; *gaussians is from malloc and owned by the caller. Viewers do
 * not light Gaussians, so their colours are those of the splats under a fixed light from above
 * (+y), front and right; colours of unlit materials stay as they are. Where splats have texture
 * coordinates, the base colour, the occlusion and the emission of a Gaussian are the means of the
 * textures over its splat; sources holds their images, of which those without pixels count as
 * white, and may be NULL. Errors: MEMORY. */
psplat_result psplat_gaussians_make(const psplat_splats *splats,
                                    const psplat_source_materials *sources,
                                    psplat_gaussian **gaussians, psplat_error *error);

#endif
