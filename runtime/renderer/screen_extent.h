/* SPDX-License-Identifier: MIT
 *
 * screen_extent.h - the screen-space bounding rectangle of the splats of a view. The resolve pass
 * leaves out all pixels outside it.
 */
#ifndef PHONGSPLAT_RENDERER_SCREEN_EXTENT_H
#define PHONGSPLAT_RENDERER_SCREEN_EXTENT_H

/* The pixels x0 <= x < x1, y0 <= y < y1. It is empty unless x0 < x1. */
typedef struct psplat_screen_extent {
    int x0, x1, y0, y1;
} psplat_screen_extent;

/* Returns the pixels that the image of a sphere may cover in a view of width x height pixels, and
 * one pixel around them. clip is the 4 x 4 matrix from the sphere's space to clip space. */
psplat_screen_extent psplat_screen_extent_of(const float center[3], float radius,
                                             const double clip[16], int width, int height);

/* Enlarges the rectangle by another one. */
void psplat_screen_extent_join(psplat_screen_extent *extent, const psplat_screen_extent *more);

#endif
