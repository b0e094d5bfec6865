/* SPDX-License-Identifier: MIT
 *
 * screen_extent.c - bounds of projected spheres. A sphere's clip coordinates differ from its
 * centre's by at most the radius times the length of their gradient, and quotients of the extremes
 * bound the image. The bounds are loose for spheres near the eye and tight for small ones.
 */
#include "renderer/screen_extent.h"

#include <math.h>

typedef struct range {
    double low, high;
} range;

/* Returns the range of clip coordinate `row` over the sphere. */
static range range_of(const float center[3], float radius, const double clip[16], int row) {
    double middle = clip[12 + row], length2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        middle += clip[4 * i + row] * (double)center[i];
        length2 += clip[4 * i + row] * clip[4 * i + row];
    }
    double reach = (double)radius * sqrt(length2);
    return (range){middle - reach, middle + reach};
}

/* Returns the pixels of an axis that the image may cover. They are all pixels where the sphere
 * reaches behind the eye. */
static range project(range at, range w, int size) {
    range pixels = {0.0, size};
    if (!(w.low > 0.0)) return pixels;
    double first = at.low / (at.low < 0.0 ? w.low : w.high);
    double last = at.high / (at.high > 0.0 ? w.low : w.high);
    pixels.low = fmin(fmax(floor((0.5 * first + 0.5) * size) - 1.0, 0.0), size);
    pixels.high = fmax(fmin(ceil((0.5 * last + 0.5) * size) + 1.0, size), 0.0);
    return pixels;
}

psplat_screen_extent psplat_screen_extent_of(const float center[3], float radius,
                                             const double clip[16], int width, int height) {
    range w = range_of(center, radius, clip, 3);
    range x = project(range_of(center, radius, clip, 0), w, width);
    range y = project(range_of(center, radius, clip, 1), w, height);
    if (!(x.low < x.high) || !(y.low < y.high)) return (psplat_screen_extent){0, 0, 0, 0};
    return (psplat_screen_extent){(int)x.low, (int)x.high, (int)y.low, (int)y.high};
}

void psplat_screen_extent_join(psplat_screen_extent *extent, const psplat_screen_extent *more) {
    if (!(more->x0 < more->x1)) return;
    int is_first = !(extent->x0 < extent->x1);
    if (is_first || more->x0 < extent->x0) extent->x0 = more->x0;
    if (is_first || more->x1 > extent->x1) extent->x1 = more->x1;
    if (is_first || more->y0 < extent->y0) extent->y0 = more->y0;
    if (is_first || more->y1 > extent->y1) extent->y1 = more->y1;
}
