/* SPDX-License-Identifier: MIT
 *
 * span.h - the part of a view's depth in which something is drawn. The runtime's own depth buffers
 * hold that part alone, so that their steps depend on the scene and not on how far apart the host
 * put its near and far planes.
 */
#ifndef PHONGSPLAT_SPAN_H
#define PHONGSPLAT_SPAN_H

/* Normalised device depths; nothing where low > high. */
typedef struct psplat_span {
    double low, high;
} psplat_span;

/* What there is before anything is added, and what a view holds at most. */
#define PSPLAT_SPAN_EMPTY ((psplat_span){1.0, -1.0})
#define PSPLAT_SPAN_WHOLE ((psplat_span){-1.0, 1.0})

/* Adds what a view shows of a box of object space, with room before and behind it: see span.c.
 * shift: by how much visibility lies behind splats at most (spec 5.3), eye space. */
void psplat_span_add(psplat_span *span, const double modelview[16], const double projection[16],
                     const float min[3], const float max[3], double shift);

double psplat_span_middle(const psplat_span *span);
double psplat_span_half(const psplat_span *span);

/* The projection whose near and far planes are the ends of the span. */
void psplat_span_project(const psplat_span *span, const double projection[16], double fitted[16]);

#endif
