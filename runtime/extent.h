/* SPDX-License-Identifier: MIT
 *
 * extent.h - the rectangle of a view that splats may cover; the resolve pass leaves out the rest.
 */
#ifndef PHONGSPLAT_EXTENT_H
#define PHONGSPLAT_EXTENT_H

/* Pixels x0 <= x < x1, y0 <= y < y1; empty where not x0 < x1. */
typedef struct psplat_extent {
    int x0, x1, y0, y1;
} psplat_extent;

/* Adds what the image of a sphere may cover of width x height pixels, and a pixel around it. clip:
 * the sphere's space to clip space. */
void psplat_extent_add(psplat_extent *extent, const float center[3], float radius,
                       const double clip[16], int width, int height);

#endif
