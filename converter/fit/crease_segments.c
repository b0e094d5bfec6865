/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_segments.c - crease edges clipped to the ellipse and the lines of a region.
 */
#include "fit/crease_segments.h"

#include "base/region.h"
#include "base/vector.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

/* Keeps the part of a segment between two places along it, which are 0 and 1 at its ends. */
static void keep_between(psplat_segment *s, double from, double to) {
    double d[3], start[3];
    sub3(d, s->b, s->a);
    memcpy(start, s->a, sizeof start);
    along3(s->a, start, from, d);
    along3(s->b, start, to, d);
}

/* Clips a segment to the unit circle and the lines. Returns 0 where nothing is left. */
static int clip_segment(psplat_segment *s, const psplat_region *region) {
    double d[3];
    sub3(d, s->b, s->a);
    double aa = d[0] * d[0] + d[1] * d[1], ab = s->a[0] * d[0] + s->a[1] * d[1];
    double root = ab * ab - aa * (s->a[0] * s->a[0] + s->a[1] * s->a[1] - 1);
    if (!(aa > 0) || !(root > 0)) return 0;
    double from = max2((-ab - sqrt(root)) / aa, 0), to = min2((-ab + sqrt(root)) / aa, 1);
    for (uint32_t i = 0; i < region->line_count; ++i) {
        const double *line = region->lines[i];
        double inside = line[0] * s->a[0] + line[1] * s->a[1] + line[2];
        double rate = line[0] * d[0] + line[1] * d[1];
        if (rate > 0) from = max2(from, -inside / rate);
        if (rate < 0) to = min2(to, -inside / rate);
        if (rate == 0 && inside < 0) return 0;
    }
    if (!(from < to)) return 0;
    keep_between(s, from, to);
    return 1;
}

size_t psplat_segments_find(const psplat_surface *surface, const uint32_t *creases,
                            size_t crease_count, const psplat_region *region, double height,
                            psplat_segment *segments) {
    const psplat_mesh *mesh = surface->mesh;
    size_t count = 0;
    for (size_t i = 0; i < crease_count; ++i) {
        uint32_t edge = creases[i], next = edge % 3 == 2 ? edge - 2 : edge + 1;
        if (dot3(surface->face_normals + 3 * (size_t)(edge / 3), region->n) <= 0) continue;
        psplat_segment *s = &segments[count];
        s->vertex[0] = mesh->triangles[edge], s->vertex[1] = mesh->triangles[next];
        s->across = surface->neighbors[edge];
        psplat_region_local(region, mesh->positions + 3 * (size_t)s->vertex[0], s->a);
        psplat_region_local(region, mesh->positions + 3 * (size_t)s->vertex[1], s->b);
        if (!clip_segment(s, region)) continue;
        count += min2(fabs(s->a[2]), fabs(s->b[2])) <= height;
    }
    return count;
}
