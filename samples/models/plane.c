/* SPDX-License-Identifier: MIT
 *
 * plane.c - outlines, and flat faces between them: a Delaunay triangulation of the points of the
 * outlines and of a hexagonal grid inside, by insertion (Bowyer 1981, Watson 1981).
 *
 * Grid points keep away from the outlines, so that the circle over each outline segment is empty
 * and the segment becomes an edge by itself.
 */
#include "generate.h"

#include <math.h>
#include <stdlib.h>

/* ---- outlines ------------------------------------------------------------------------------- */

void outline_point(outline *o, double x, double y) {
    o->points = resize(o->points, (o->count + 1) * sizeof *o->points);
    o->points[o->count][0] = x;
    o->points[o->count][1] = y;
    ++o->count;
}

static int steps_for(double length, double step) {
    int count = (int)floor(length / step + 0.5);
    return count < 1 ? 1 : count;
}

void outline_line(outline *o, double x, double y, double step) {
    double x0 = o->points[o->count - 1][0], y0 = o->points[o->count - 1][1];
    int count = steps_for(hypot(x - x0, y - y0), step);
    for (int i = 1; i < count; ++i)
        outline_point(o, x0 + (x - x0) * i / count, y0 + (y - y0) * i / count);
    outline_point(o, x, y);
}

void outline_arc(outline *o, double cx, double cy, double radius, double a, double b, double step) {
    int count = steps_for(radius * fabs(b - a), step);
    for (int i = o->count > 0; i <= count; ++i) {
        double angle = a + (b - a) * i / count;
        outline_point(o, cx + radius * cos(angle), cy + radius * sin(angle));
    }
}

/* Finds where corner i goes when the segments beside it move inwards: the point of its mitre that
 * is `distance` away from both lines. Returns the sine of the turn. */
static double mitre(const outline *o, size_t i, double distance, double moved[2]) {
    const double *p = o->points[(i + o->count - 1) % o->count], *q = o->points[i],
                 *r = o->points[(i + 1) % o->count];
    double a = hypot(q[0] - p[0], q[1] - p[1]), b = hypot(r[0] - q[0], r[1] - q[1]);
    double m[2] = {(p[1] - q[1]) / a, (q[0] - p[0]) / a};
    double n[2] = {(q[1] - r[1]) / b, (r[0] - q[0]) / b};
    double scale = distance / (1 + m[0] * n[0] + m[1] * n[1]);
    for (int k = 0; k < 2; ++k) moved[k] = q[k] + (m[k] + n[k]) * scale;
    return m[0] * n[1] - m[1] * n[0];
}

static int is_corner(const outline *o, size_t i) {
    double unused[2];
    return fabs(mitre(o, i, 0, unused)) > 1e-9;
}

/* Points on a straight stretch keep their relative position on it; otherwise they would pass its
 * ends where it becomes shorter. */
outline outline_inset(const outline *o, double distance) {
    outline inset = {0};
    for (size_t i = 0; i < o->count; ++i) {
        size_t before = i, after = i;
        while (!is_corner(o, before)) before = (before + o->count - 1) % o->count;
        while (!is_corner(o, after)) after = (after + 1) % o->count;
        double p[2], q[2], t = 0;
        mitre(o, before, distance, p);
        mitre(o, after, distance, q);
        const double *a = o->points[before], *b = o->points[after], *x = o->points[i];
        if (before != after) t = hypot(x[0] - a[0], x[1] - a[1]) / hypot(b[0] - a[0], b[1] - a[1]);
        outline_point(&inset, p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t);
    }
    return inset;
}

void outline_free(outline *o) {
    free(o->points);
    *o = (outline){0};
}

/* ---- triangulation -------------------------------------------------------------------------- */

typedef struct delaunay {
    double (*points)[2]; /* perturbed; used only for decisions */
    double (*exact)[2];  /* exact; used for the output */
    uint32_t (*triangles)[3];
    size_t point_count, triangle_count, triangle_capacity;
} delaunay;

/* Hashes a number to one in -1 ... 1 (splitmix64, Steele, Lea, Flood 2014). */
static double noise(uint64_t i) {
    uint64_t z = (i + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return (double)(z >> 11) / 4503599627370496.0 - 1;
}

/* Points of circles and grids are cocircular, so that the last digit of a cosine would decide how
 * they are joined. A perturbation far above rounding and far below the spacing makes every machine
 * decide alike. */
static void add_point(delaunay *d, double x, double y, double step) {
    size_t i = d->point_count++;
    d->points = resize(d->points, d->point_count * sizeof *d->points);
    d->exact = resize(d->exact, d->point_count * sizeof *d->exact);
    d->exact[i][0] = x;
    d->exact[i][1] = y;
    d->points[i][0] = x + noise(2 * i) * step * 1e-5;
    d->points[i][1] = y + noise(2 * i + 1) * step * 1e-5;
}

static void add_triangle(delaunay *d, uint32_t a, uint32_t b, uint32_t c) {
    if (d->triangle_count == d->triangle_capacity) {
        d->triangle_capacity = d->triangle_capacity * 2 + 64;
        d->triangles = resize(d->triangles, d->triangle_capacity * sizeof *d->triangles);
    }
    uint32_t *t = d->triangles[d->triangle_count++];
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

static int in_circle(const delaunay *d, const uint32_t t[3], const double p[2]) {
    double m[3][3];
    for (int i = 0; i < 3; ++i) {
        m[i][0] = d->points[t[i]][0] - p[0];
        m[i][1] = d->points[t[i]][1] - p[1];
        m[i][2] = m[i][0] * m[i][0] + m[i][1] * m[i][1];
    }
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) >
           0;
}

/* The rim of a hole: the edges that belong to only one of the removed triangles. */
typedef struct rim {
    uint32_t (*edges)[2];
    size_t count;
} rim;

static void toggle_edge(rim *r, uint32_t a, uint32_t b) {
    for (size_t e = 0; e < r->count; ++e)
        if (r->edges[e][0] == b && r->edges[e][1] == a) {
            --r->count;
            r->edges[e][0] = r->edges[r->count][0];
            r->edges[e][1] = r->edges[r->count][1];
            return;
        }
    r->edges = resize(r->edges, (r->count + 1) * sizeof *r->edges);
    r->edges[r->count][0] = a;
    r->edges[r->count++][1] = b;
}

/* Removes the triangles whose circumcircle holds point p and joins p with the rim of the hole. */
static void insert(delaunay *d, uint32_t p) {
    rim r = {0};
    for (size_t i = 0; i < d->triangle_count;) {
        uint32_t *t = d->triangles[i];
        if (!in_circle(d, t, d->points[p])) {
            ++i;
            continue;
        }
        for (int k = 0; k < 3; ++k) toggle_edge(&r, t[k], t[(k + 1) % 3]);
        for (int k = 0; k < 3; ++k) t[k] = d->triangles[d->triangle_count - 1][k];
        --d->triangle_count;
    }
    for (size_t e = 0; e < r.count; ++e) add_triangle(d, r.edges[e][0], r.edges[e][1], p);
    free(r.edges);
}

static int is_inside(const outline *o, double x, double y) {
    int inside = 0;
    for (size_t i = 0; i < o->count; ++i) {
        const double *p = o->points[i], *q = o->points[(i + 1) % o->count];
        if ((p[1] > y) != (q[1] > y) && x < p[0] + (q[0] - p[0]) * (y - p[1]) / (q[1] - p[1]))
            inside = !inside;
    }
    return inside;
}

static int is_in_region(const outline *outer, const outline *holes, size_t hole_count, double x,
                        double y) {
    if (!is_inside(outer, x, y)) return 0;
    for (size_t i = 0; i < hole_count; ++i)
        if (is_inside(&holes[i], x, y)) return 0;
    return 1;
}

static void add_outline(delaunay *d, const outline *o, double step) {
    for (size_t i = 0; i < o->count; ++i) add_point(d, o->points[i][0], o->points[i][1], step);
}

static void bounds(const outline *o, double low[2], double high[2]) {
    for (int k = 0; k < 2; ++k) low[k] = high[k] = o->points[0][k];
    for (size_t i = 0; i < o->count; ++i)
        for (int k = 0; k < 2; ++k) {
            low[k] = fmin(low[k], o->points[i][k]);
            high[k] = fmax(high[k], o->points[i][k]);
        }
}

static void add_grid(delaunay *d, const outline *outer, const outline *holes, size_t hole_count,
                     double step) {
    double low[2], high[2], row_height = step * 0.8660254037844386;
    size_t border = d->point_count;
    bounds(outer, low, high);
    int rows = (int)((high[1] - low[1]) / row_height), columns = (int)((high[0] - low[0]) / step);
    for (int row = 1; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            double x = low[0] + (column + 0.5 * (row % 2) + 0.25) * step;
            double y = low[1] + row * row_height;
            int clear = is_in_region(outer, holes, hole_count, x, y);
            for (size_t i = 0; i < border && clear; ++i)
                clear = hypot(d->exact[i][0] - x, d->exact[i][1] - y) > 0.72 * step;
            if (clear) add_point(d, x, y, step);
        }
}

void solid_face(solid *s, const outline *outer, const outline *holes, size_t hole_count, double z,
                double step, int up) {
    delaunay d = {0};
    double low[2], high[2];
    bounds(outer, low, high);
    double size = 64 * (high[0] - low[0] + high[1] - low[1]);
    add_point(&d, low[0] - size, low[1] - size, step);
    add_point(&d, high[0] + size, low[1] - size, step);
    add_point(&d, low[0], high[1] + size, step);
    add_triangle(&d, 0, 1, 2);
    add_outline(&d, outer, step);
    for (size_t i = 0; i < hole_count; ++i) add_outline(&d, &holes[i], step);
    add_grid(&d, outer, holes, hole_count, step);
    for (uint32_t p = 3; p < d.point_count; ++p) insert(&d, p);
    for (size_t i = 0; i < d.triangle_count; ++i) {
        const uint32_t *t = d.triangles[i];
        double x = 0, y = 0;
        uint32_t v[3];
        for (int k = 0; k < 3; ++k) {
            x += d.exact[t[k]][0] / 3;
            y += d.exact[t[k]][1] / 3;
        }
        if (t[0] < 3 || t[1] < 3 || t[2] < 3 || !is_in_region(outer, holes, hole_count, x, y))
            continue;
        for (int k = 0; k < 3; ++k) v[k] = solid_vertex(s, d.exact[t[k]][0], d.exact[t[k]][1], z);
        solid_triangle(s, v[0], v[up ? 1 : 2], v[up ? 2 : 1]);
    }
    free(d.points);
    free(d.exact);
    free(d.triangles);
}
