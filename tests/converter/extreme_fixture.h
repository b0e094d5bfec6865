/* SPDX-License-Identifier: MIT
 *
 * extreme_fixture.h - shapes for tests of extreme input, which are converted after a round through
 * the reader, as a user's file is, and a brute-force measure of coverage and distance that shares
 * no search with the converter. Include it after mesh_fixture.h.
 */
#ifndef PHONGSPLAT_TESTS_EXTREME_FIXTURE_H
#define PHONGSPLAT_TESTS_EXTREME_FIXTURE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "extreme.h"
#include "base/random.h"
#include "base/region.h"
#include "base/vector.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "splats/splats.h"
#include "verify/report.h"

static const double extreme_pi = 3.14159265358979323846;

/* ---- shapes ------------------------------------------------------------------------------- */

typedef struct shape {
    double (*vertices)[3];
    uint32_t (*triangles)[3];
    size_t vertex_count, triangle_count, vertex_capacity, triangle_capacity;
} shape;

static inline uint32_t shape_vertex(shape *s, double x, double y, double z) {
    if (s->vertex_count == s->vertex_capacity) {
        s->vertex_capacity = 2 * s->vertex_capacity + 64;
        s->vertices = realloc(s->vertices, s->vertex_capacity * sizeof *s->vertices);
        assert_non_null(s->vertices);
    }
    double *p = s->vertices[s->vertex_count];
    p[0] = x, p[1] = y, p[2] = z;
    return (uint32_t)s->vertex_count++;
}

static inline void shape_triangle(shape *s, uint32_t a, uint32_t b, uint32_t c) {
    if (s->triangle_count == s->triangle_capacity) {
        s->triangle_capacity = 2 * s->triangle_capacity + 64;
        s->triangles = realloc(s->triangles, s->triangle_capacity * sizeof *s->triangles);
        assert_non_null(s->triangles);
    }
    uint32_t *t = s->triangles[s->triangle_count++];
    t[0] = a, t[1] = b, t[2] = c;
}

static inline void shape_quad(shape *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    shape_triangle(s, a, b, c);
    shape_triangle(s, a, c, d);
}

/* Adds a box that faces outwards, or inwards where low and high are exchanged in one axis. */
static inline void shape_box(shape *s, const double low[3], const double high[3]) {
    uint32_t v[8];
    for (int i = 0; i < 8; ++i)
        v[i] = shape_vertex(s, i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1],
                            i & 4 ? high[2] : low[2]);
    shape_quad(s, v[0], v[2], v[3], v[1]);
    shape_quad(s, v[4], v[5], v[7], v[6]);
    shape_quad(s, v[0], v[1], v[5], v[4]);
    shape_quad(s, v[2], v[6], v[7], v[3]);
    shape_quad(s, v[0], v[4], v[6], v[2]);
    shape_quad(s, v[1], v[3], v[7], v[5]);
}

/* Adds columns x rows squares; place gives the point at s and t, both in 0 ... 1. */
static inline void shape_grid(shape *s, uint32_t columns, uint32_t rows,
                              void (*place)(double s, double t, double p[3])) {
    uint32_t first = (uint32_t)s->vertex_count;
    for (uint32_t y = 0; y <= rows; ++y)
        for (uint32_t x = 0; x <= columns; ++x) {
            double p[3];
            place((double)x / columns, (double)y / rows, p);
            shape_vertex(s, p[0], p[1], p[2]);
        }
    for (uint32_t y = 0; y < rows; ++y)
        for (uint32_t x = 0; x < columns; ++x) {
            uint32_t a = first + y * (columns + 1) + x, c = a + columns + 1;
            shape_quad(s, a, a + 1, c + 1, c);
        }
}

/* Adds triangles between an apex and a closed ring of `sides` vertices, which runs
 * counter-clockwise as seen from the apex. */
static inline void shape_fan(shape *s, uint32_t apex, uint32_t ring, uint32_t sides) {
    for (uint32_t i = 0; i < sides; ++i) shape_triangle(s, apex, ring + i, ring + (i + 1) % sides);
}

static inline uint32_t shape_ring(shape *s, uint32_t sides, double radius, double z) {
    uint32_t first = (uint32_t)s->vertex_count;
    for (uint32_t i = 0; i < sides; ++i) {
        double angle = 2 * extreme_pi * i / sides;
        shape_vertex(s, radius * cos(angle), radius * sin(angle), z);
    }
    return first;
}

static inline void shape_free(shape *s) {
    free(s->vertices);
    free(s->triangles);
    *s = (shape){0};
}

/* Returns the mesh that the reader makes of the shape. */
static inline psplat_mesh shape_read(const shape *s) {
    size_t capacity = 64 + 80 * s->vertex_count + 40 * s->triangle_count, size;
    char *text = malloc(capacity);
    assert_non_null(text);
    size = (size_t)sprintf(text, "OFF\n%zu %zu 0\n", s->vertex_count, s->triangle_count);
    for (size_t i = 0; i < s->vertex_count; ++i)
        size += (size_t)sprintf(text + size, "%.17g %.17g %.17g\n", s->vertices[i][0],
                                s->vertices[i][1], s->vertices[i][2]);
    for (size_t i = 0; i < s->triangle_count; ++i)
        size += (size_t)sprintf(text + size, "3 %u %u %u\n", s->triangles[i][0], s->triangles[i][1],
                                s->triangles[i][2]);
    psplat_mesh mesh = read_bytes("shape.off", text, size);
    free(text);
    return mesh;
}

/* ---- measure by brute force ----------------------------------------------------------------- */

static inline double segment_distance(const double p[3], const double a[3], const double b[3]) {
    double ab[3], ap[3];
    sub3(ab, b, a);
    sub3(ap, p, a);
    double squared = dot3(ab, ab), t = squared > 0 ? dot3(ap, ab) / squared : 0;
    mad3(ap, -min2(max2(t, 0), 1), ab);
    return length3(ap);
}

static inline double triangle_distance(const double p[3], const double *corners[3]) {
    double ab[3], ac[3], n[3], d[3], least = HUGE_VAL;
    int inside = 1;
    sub3(ab, corners[1], corners[0]);
    sub3(ac, corners[2], corners[0]);
    cross3(n, ab, ac);
    for (int k = 0; k < 3; ++k) {
        double edge[3], inwards[3];
        sub3(edge, corners[(k + 1) % 3], corners[k]);
        cross3(inwards, n, edge);
        sub3(d, p, corners[k]);
        inside &= dot3(d, inwards) >= 0;
        least = min2(least, segment_distance(p, corners[k], corners[(k + 1) % 3]));
    }
    if (!inside || normalize3(n) == 0) return least;
    return fabs(dot3(n, d));
}

static inline void triangle_corners(const psplat_mesh *mesh, size_t triangle,
                                    const double *corners[3]) {
    for (size_t k = 0; k < 3; ++k)
        corners[k] = mesh->positions + 3 * (size_t)mesh->triangles[3 * triangle + k];
}

static inline double surface_distance(const psplat_mesh *mesh, const double p[3]) {
    double least = HUGE_VAL;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        const double *corners[3];
        triangle_corners(mesh, t, corners);
        least = min2(least, triangle_distance(p, corners));
    }
    return least;
}

static inline int splat_covers(const psplat_region *region, const double p[3], const double n[3],
                               double tolerance) {
    double uvh[3], facing[3];
    psplat_region_local(region, p, uvh);
    psplat_region_normal(region, uvh, facing);
    return fabs(uvh[2]) <= tolerance && dot3(facing, n) > 0 &&
           psplat_region_contains(region, uvh, 1 + 1e-5, 1e-5); /* rounding to float */
}

static inline int is_covered(const psplat_region *regions, size_t count, const double p[3],
                             const double n[3], double tolerance) {
    for (size_t i = 0; i < count; ++i)
        if (splat_covers(&regions[i], p, n, tolerance)) return 1;
    return 0;
}

/* Counts random points of the mesh that no splat facing their way covers. Each triangle gets at
 * least three points, and its share by area of another 20,000. */
static inline size_t count_uncovered(const psplat_mesh *mesh, const psplat_region *regions,
                                     size_t count, double tolerance) {
    uint64_t random = 17;
    size_t uncovered = 0;
    double total = 0;
    for (int pass = 0; pass < 2; ++pass)
        for (size_t t = 0; t < mesh->triangle_count; ++t) {
            const double *c[3];
            double ab[3], ac[3], n[3];
            triangle_corners(mesh, t, c);
            sub3(ab, c[1], c[0]);
            sub3(ac, c[2], c[0]);
            cross3(n, ab, ac);
            double area = normalize3(n);
            total += pass ? 0 : area;
            size_t points = pass ? 3 + (size_t)(20000 * area / total) : 0;
            for (size_t i = 0; i < points; ++i) {
                double p[3], s = psplat_random_unit(&random), r = psplat_random_unit(&random);
                if (s + r > 1) s = 1 - s, r = 1 - r;
                memcpy(p, c[0], sizeof p);
                mad3(p, s, ab);
                mad3(p, r, ac);
                uncovered += !is_covered(regions, count, p, n, tolerance);
            }
        }
    return uncovered;
}

/* Returns the greatest distance of a splat from the surface, over the corners of its outline and
 * the points halfway from these to its middle. */
static inline double greatest_distance(const psplat_mesh *mesh, const psplat_region *regions,
                                       size_t count) {
    double greatest = 0;
    for (size_t i = 0; i < count; ++i) {
        const psplat_region *r = &regions[i];
        double polygon[68][2], middle[2] = {0, 0};
        size_t corners = psplat_region_polygon(r, 1, polygon, 68);
        for (size_t k = 0; k < corners; ++k)
            for (int a = 0; a < 2; ++a) middle[a] += polygon[k][a] / (double)corners;
        for (size_t k = 0; k < 2 * corners; ++k) {
            double p[3], uv[2], part = k < corners ? 1 : 0.5;
            for (int a = 0; a < 2; ++a)
                uv[a] = middle[a] + part * (polygon[k % corners][a] - middle[a]);
            psplat_region_point(r, uv, p);
            greatest = max2(greatest, surface_distance(mesh, p));
        }
    }
    return greatest;
}

/* The result of a conversion and its measures by brute force: mesh points without a splat, and the
 * greatest distance of a splat in tolerances. */
typedef struct extreme {
    psplat_mesh mesh;
    psplat_splats splats;
    psplat_region *regions;
    psplat_report report;
    double tolerance;
    size_t uncovered;
    double distance;
} extreme;

static inline void extreme_free(extreme *e) {
    free(e->regions);
    psplat_splats_free(&e->splats);
    psplat_mesh_free(&e->mesh);
}

/* Converts the shape at a tolerance in % of the diagonal, measures the result, and frees the shape.
 */
static inline extreme extreme_convert(const char *name, shape *s, double percent) {
    extreme e = {.mesh = shape_read(s)};
    psplat_error error;
    psplat_convert_desc desc = {.tolerance_percent = percent};
    shape_free(s);
    if (psplat_convert(&e.mesh, &desc, &e.splats, &e.report, &error)) fail_msg("%s", error.text);
    e.regions = psplat_splat_regions(&e.splats);
    assert_non_null(e.regions);
    e.tolerance = percent / 100 * e.report.diagonal;
    e.uncovered = count_uncovered(&e.mesh, e.regions, e.splats.count, e.tolerance * (1 + 1e-5));
    e.distance = greatest_distance(&e.mesh, e.regions, e.splats.count) / e.tolerance;
    print_message("%s: %zu splats\n", name, e.splats.count);
    return e;
}

/* Converts the shape and checks what every conversion promises: no open point, and no splat farther
 * than the tolerance. */
static inline extreme extreme_right(const char *name, shape *s, double percent) {
    extreme e = extreme_convert(name, s, percent);
    extreme_at_most(name, (double)e.uncovered, "of 20,000 points uncovered", 0);
    extreme_at_most(name, e.distance, "of the tolerance, the farthest splat", 1 + 1e-5);
    assert_int_equal(e.report.uncovered_samples, 0);
    assert_true(e.report.max_distance_percent <= percent * (1 + 1e-5));
    return e;
}

#endif
