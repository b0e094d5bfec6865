/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * rim_points.c - points a little beyond the rims of splats.
 *
 * Whoever looks through a gap between splats sees rims all around it. So points along the rims find
 * gaps that are far narrower than random points of the surface lie apart.
 */
#include "measure/rim_points.h"

#include "base/angle.h"
#include "base/random.h"
#include "base/vector.h"

#include <math.h>
#include <stdlib.h>

/* The most points of an ellipse or of a line, which bounds the time that large splats take. */
enum { MOST_POINTS = 512 };

typedef struct rim {
    psplat_rim_point *points;
    size_t count, capacity;
} rim;

static int push(rim *r, const psplat_region *region, const double uv[2]) {
    if (r->count == r->capacity) {
        size_t capacity = 2 * r->capacity + 1024;
        psplat_rim_point *points = realloc(r->points, capacity * sizeof *points);
        if (!points) return 0;
        r->points = points;
        r->capacity = capacity;
    }
    psplat_region_point(region, uv, r->points[r->count].point);
    psplat_region_normal(region, uv, r->points[r->count++].normal);
    return 1;
}

static int points_on(double length, double spacing) {
    return (int)fmin(fmax(ceil(length / spacing), 1), MOST_POINTS);
}

/* Returns how far outside the rim a point is to lie. */
static double beyond(const psplat_rim_draw *draw, uint64_t *random) {
    return draw->least * pow(draw->greatest / draw->least, psplat_random_unit(random));
}

/* Adds points beyond the ellipse of a region, where its lines keep them. */
static int add_ellipse(const psplat_rim_draw *draw, const psplat_region *region, uint64_t *random,
                       rim *r) {
    double mean = (region->radius[0] + region->radius[1]) / 2;
    int count = points_on(2 * PSPLAT_PI * mean, draw->spacing), ok = 1;
    double turn = psplat_random_unit(random);
    for (int i = 0; i < count && ok; ++i) {
        double angle = 2 * PSPLAT_PI * (i + turn) / count;
        const double out[2] = {cos(angle), sin(angle)};
        double across = hypot(out[0] / region->radius[0], out[1] / region->radius[1]);
        double scale =
            1 + beyond(draw, random) * across; /* Distances to the rim grow by one over that. */
        const double uv[2] = {scale * out[0], scale * out[1]};
        if (psplat_region_contains(region, uv, 2 * scale, 0)) ok = push(r, region, uv);
    }
    return ok;
}

/* Returns the length of the gradient of line i at (u, v): how fast its value changes along the
 * plane, for each unit of length. Stores the unit direction in (u, v) that leads out. */
static double line_rate(const psplat_region *region, uint32_t i, const double uv[2],
                        double out[2]) {
    const double *line = region->lines[i];
    double turn = region->bends[i] * (line[0] * uv[1] - line[1] * uv[0]);
    double a = (line[0] - turn * line[1]) / region->radius[0];
    double b = (line[1] + turn * line[0]) / region->radius[1], rate = hypot(a, b);
    out[0] = -a / rate / region->radius[0];
    out[1] = -b / rate / region->radius[1];
    return rate;
}

/* Adds points beyond line i of a region, where its ellipse and its other lines keep the line. */
static int add_line(const psplat_rim_draw *draw, const psplat_region *region, uint32_t i,
                    uint64_t *random, rim *r) {
    psplat_region others = *region;
    int count = points_on(2 * region->radius[0], draw->spacing), ok = 1;
    double part = psplat_random_unit(random);
    others.lines[i][0] = others.lines[i][1] = others.bends[i] = 0;
    others.lines[i][2] = 1;
    for (int k = 0; k < count && ok; ++k) {
        double uv[2], out[2];
        psplat_region_line_point(region, i, 2 * (k + part) / count - 1, uv);
        if (!psplat_region_contains(&others, uv, 1, 0)) continue;
        if (!(line_rate(region, i, uv, out) > 0)) continue;
        double away = beyond(draw, random);
        uv[0] += away * out[0];
        uv[1] += away * out[1];
        ok = push(r, region, uv);
    }
    return ok;
}

psplat_result psplat_rim_points_draw(const psplat_rim_draw *draw, psplat_rim_point **points,
                                     size_t *count) {
    rim r = {0};
    int ok = 1;
    for (size_t i = 0; i < draw->count && ok; ++i) {
        const psplat_region *region = &draw->regions[i];
        uint64_t random = draw->seed ^ i;
        ok = add_ellipse(draw, region, &random, &r);
        for (uint32_t k = 0; k < region->line_count && ok; ++k)
            ok = add_line(draw, region, k, &random, &r);
    }
    if (!ok) free(r.points);
    *points = ok ? r.points : NULL;
    *count = ok ? r.count : 0;
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}
