/* SPDX-License-Identifier: MIT
 *
 * depth_span.h - the interval of a view's depth in which something is drawn, to which the near and
 * far plane are fitted. The runtime's own depth buffers hold that interval alone, so that their
 * precision depends on the scene and not on how far apart the host put its near and far planes.
 */
#ifndef PHONGSPLAT_RENDERER_DEPTH_SPAN_H
#define PHONGSPLAT_RENDERER_DEPTH_SPAN_H

/* Normalised device depths, -1 ... 1. The span is empty where low > high. */
typedef struct psplat_depth_span {
    double low, high;
} psplat_depth_span;

/* The empty span, and the span between the host's planes, which none exceeds. */
#define PSPLAT_SPAN_EMPTY ((psplat_depth_span){1.0, -1.0})
#define PSPLAT_SPAN_WHOLE ((psplat_depth_span){-1.0, 1.0})

/* Enlarges the span by what a view shows of a box of object space, and by some room before and
 * behind it, for which depth_span.c gives the reasons. shift is the greatest distance in eye space
 * by which the visibility pass shifts splats away from the eye (spec 5.3). */
void psplat_depth_span_add(psplat_depth_span *span, const double modelview[16],
                           const double projection[16], const float min[3], const float max[3],
                           double shift);

/* Return the middle and half the length of a span. The half is never 0. */
double psplat_depth_span_middle(const psplat_depth_span *span);
double psplat_depth_span_half(const psplat_depth_span *span);

/* Computes the projection whose near and far planes are the ends of the span. fitted may not be
 * projection. */
void psplat_depth_span_project(const psplat_depth_span *span, const double projection[16],
                               double fitted[16]);

#endif
