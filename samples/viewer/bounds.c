/* SPDX-License-Identifier: MIT
 *
 * bounds.c - a sphere around the visible parts of splats. psplat_asset_bounds, which encloses whole
 * ellipses, is several times too large where large splats are cut down to small faces.
 */
#include "viewer.h"

#include <math.h>
#include <string.h>

enum { SIDES = 12, MAX_CORNERS = SIDES + PSPLAT_MAX_CLIP_LINES };

/* A convex polygon in the splat's coordinates (u, v). */
typedef struct polygon {
    double corners[MAX_CORNERS][2];
    int count;
} polygon;

/* Returns a regular polygon around the unit circle. */
static polygon whole_splat(void) {
    polygon p = {.count = SIDES};
    const double step = 2 * 3.14159265358979323846 / SIDES;
    for (int i = 0; i < SIDES; ++i) {
        p.corners[i][0] = cos(i * step) / cos(0.5 * step);
        p.corners[i][1] = sin(i * step) / cos(0.5 * step);
    }
    return p;
}

static double side_of(const float line[3], const double corner[2]) {
    return (double)line[0] * corner[0] + (double)line[1] * corner[1] + (double)line[2];
}

static void add_corner(polygon *p, double u, double v) {
    if (p->count == MAX_CORNERS) return;
    p->corners[p->count][0] = u;
    p->corners[p->count++][1] = v;
}

/* Keeps the part on the side that the clip line keeps (Sutherland and Hodgman 1974). The polygon is
 * convex and gains one corner at most. */
static void cut(polygon *p, const float line[3]) {
    polygon kept = {.count = 0};
    for (int i = 0; i < p->count; ++i) {
        const double *a = p->corners[i], *b = p->corners[(i + 1) % p->count];
        double sa = side_of(line, a), sb = side_of(line, b), t = sa / (sa - sb);
        if (sa >= 0) add_corner(&kept, a[0], a[1]);
        if ((sa >= 0) != (sb >= 0))
            add_corner(&kept, a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]));
    }
    *p = kept;
}

/* Computes center + x U + y V, where U and V are the first columns of the quaternion's rotation
 * matrix. */
static void to_object(const psplat_splat *s, double x, double y, double out[3]) {
    const double q[4] = {(double)s->rotation[0], (double)s->rotation[1], (double)s->rotation[2],
                         (double)s->rotation[3]};
    const double u[3] = {1 - 2 * (q[1] * q[1] + q[2] * q[2]), 2 * (q[0] * q[1] + q[3] * q[2]),
                         2 * (q[0] * q[2] - q[3] * q[1])};
    const double v[3] = {2 * (q[0] * q[1] - q[3] * q[2]), 1 - 2 * (q[0] * q[0] + q[2] * q[2]),
                         2 * (q[1] * q[2] + q[3] * q[0])};
    for (int i = 0; i < 3; ++i) out[i] = (double)s->center[i] + x * u[i] + y * v[i];
}

typedef struct extent {
    double min[3], max[3];
    sphere around;
} extent;

static void grow_box(extent *e, const double p[3]) {
    for (int i = 0; i < 3; ++i) {
        e->min[i] = fmin(e->min[i], p[i]);
        e->max[i] = fmax(e->max[i], p[i]);
    }
}

static void grow_sphere(extent *e, const double p[3]) {
    const double *c = e->around.center;
    double square = (p[0] - c[0]) * (p[0] - c[0]) + (p[1] - c[1]) * (p[1] - c[1]) +
                    (p[2] - c[2]) * (p[2] - c[2]);
    e->around.radius = fmax(e->around.radius, sqrt(square));
}

static void visit_splat(const psplat_splat *s, const double m[16], extent *e,
                        void (*visit)(extent *e, const double p[3])) {
    polygon outline = whole_splat();
    for (uint32_t i = 0; i < s->clip_count; ++i) cut(&outline, s->clip[i]);
    for (int i = 0; i < outline.count; ++i) {
        double p[3], q[3];
        to_object(s, (double)s->radius[0] * outline.corners[i][0],
                  (double)s->radius[1] * outline.corners[i][1], p);
        for (int r = 0; r < 3; ++r)
            q[r] = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
        visit(e, q);
    }
}

static void visit_all(const psplat_asset *asset, extent *e,
                      void (*visit)(extent *e, const double p[3])) {
    for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
        const psplat_batch *batch = psplat_asset_batch(asset, b);
        for (size_t i = 0; i < batch->splat_count; ++i)
            visit_splat(&batch->splats[i], batch->model, e, visit);
    }
}

sphere bounds_of(const psplat_asset *asset) {
    extent e = {.min = {INFINITY, INFINITY, INFINITY}, .max = {-INFINITY, -INFINITY, -INFINITY}};
    visit_all(asset, &e, grow_box);
    /* Where the clip lines leave nothing of any splat, the asset's bounds are used. */
    if (!(e.min[0] <= e.max[0])) psplat_asset_bounds(asset, e.min, e.max);
    for (int i = 0; i < 3; ++i) e.around.center[i] = 0.5 * (e.min[i] + e.max[i]);
    visit_all(asset, &e, grow_sphere);
    return e.around;
}
