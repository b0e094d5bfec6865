/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_texcoord.h - texture coordinates over a splat, and how far their errors move a texture.
 */
#ifndef PHONGSPLAT_SPLATS_SPLAT_TEXCOORD_H
#define PHONGSPLAT_SPLATS_SPLAT_TEXCOORD_H

#include <phongsplat/splat.h>

#include "base/region.h"

/* The error, in texels, up to which nobody sees that a texture slides: filtering spreads an edge
 * over a whole texel. Chosen by hand. */
#define PSPLAT_LEAST_SLIDE_TEXELS 0.25

/* How far a texture slides at a point of a splat. */
typedef struct psplat_slide {
    double length; /* over the surface, of the part of the error beyond PSPLAT_LEAST_SLIDE_TEXELS */
    double texels;
} psplat_slide;

/* Stores the coordinates at (u, v): spec eq. 4c. */
void psplat_texcoord_at(const psplat_texcoord *texcoord, const double uv[2], double at[2]);

/* Stores their change with u (slopes[0]) and with v (slopes[1]) at (u, v). */
void psplat_texcoord_slopes(const psplat_texcoord *texcoord, const double uv[2],
                            double slopes[2][2]);

/* Returns the sense in which the splat shows the image at (u, v): 1 where t turns from s as V does
 * from U, -1 where it turns the other way, 0 where the splat shows a line of the image or a point.
 */
int psplat_texcoord_sense(const psplat_texcoord *texcoord, const double uv[2]);

/* Returns how far the texture slides at (u, v) of a region where coordinates err by error. texels
 * are those of the image for each unit of s and t. The length is that of the way over the surface
 * along which the coordinates change by the error. Where they change with the position in one
 * direction less than a tenth as much as in the other, they count as if they changed by a tenth.
 * Where they do not change at all, the length is the greater diameter of the region. */
psplat_slide psplat_texcoord_slide(const psplat_texcoord *texcoord, const psplat_region *region,
                                   const double uv[2], const double texels[2],
                                   const double error[2]);

/* Returns the length of the way over a triangle's plane along which its coordinates, whose changes
 * with the position are slopes (psplat_surface.texcoord_slopes), change by error: how far from a
 * point the surface itself has what a splat shows there. Slow directions count as above; HUGE_VAL
 * where coordinates do not change. */
double psplat_texcoord_way(const float slopes[6], const double texels[2], const double error[2]);

/* Returns whether a slide is within a tolerance: a length, unless texels, which then is the
 * tolerance, is greater than 0. Where both are 0, any is. */
int psplat_slide_is_kept(const psplat_slide *slide, double length, double texels);

#endif
