/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * chart_borders.h - the borders of charts: edges at which texture coordinates jump or mirror.
 */
#ifndef PHONGSPLAT_FEATURES_CHART_BORDERS_H
#define PHONGSPLAT_FEATURES_CHART_BORDERS_H

#include <phongsplat/splat.h>

#include "features/surface.h"

/* The area of a triangle in the image, in squared texels, up to which it has no sense there.
 * Chosen by hand. */
#define PSPLAT_LEAST_CHART_TEXELS (1.0 / 16)

/* Marks the edges that bound charts, as far as they are no creases, as PSPLAT_BOUND_CHART, and
 * fills in texcoord_slopes and chart_border_edges of a surface whose neighbours and creases are
 * known. Does nothing where the surface has no appearance or that keeps no textures. Fails only
 * with PSPLAT_ERROR_MEMORY.
 *
 * An edge bounds charts where one of its triangles keeps textures and the other does not, where
 * both do by different materials, where the coordinates of the two differ by more than half a texel
 * at an end of it, and where one triangle shows the image mirrored and the other does not. A
 * triangle that has next to no area in the image is never mirrored. */
psplat_result psplat_chart_borders_mark(psplat_surface *surface);

#endif
