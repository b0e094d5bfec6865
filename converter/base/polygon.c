/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * polygon.c - triangulation of polygons by ear clipping (Meisters 1975).
 *
 * The polygon is flat or nearly so, and is projected along the main axis of its Newell normal.
 * Convex polygons become fans. The time grows with at least the square of the corners, which
 * PSPLAT_MAX_CORNERS bounds.
 */
#include "base/polygon.h"

#include <math.h>
#include <stdlib.h>

/* Computes the Newell normal of a polygon (Sutherland, Sproull, Schumacker 1974). Its length is
 * twice the area of the polygon projected along it. */
static void newell_normal(const double *p, size_t count, double normal[3]) {
    for (int k = 0; k < 3; ++k) normal[k] = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *a = p + i * 3, *b = p + (i + 1) % count * 3;
        for (int k = 0; k < 3; ++k) {
            int u = (k + 1) % 3, v = (k + 2) % 3;
            normal[k] += (a[u] - p[u]) * (b[v] - p[v]) - (a[v] - p[v]) * (b[u] - p[u]);
        }
    }
}

/* Projects the polygon along the main axis of its normal, counter-clockwise. flat: count x 2. */
static void project(const double *p, size_t count, double *flat) {
    double normal[3];
    newell_normal(p, count, normal);
    int axis = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    if (fabs(normal[2]) > fabs(normal[axis])) axis = 2;
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (size_t i = 0; i < count; ++i) {
        flat[i * 2] = p[i * 3 + (size_t)u] - p[u];
        flat[i * 2 + 1] = p[i * 3 + (size_t)v] - p[v];
        if (normal[axis] < 0) flat[i * 2] = -flat[i * 2];
    }
}

/* Returns twice the signed area of the triangle a b c: positive where it turns left. */
static double turn(const double *flat, uint32_t a, uint32_t b, uint32_t c) {
    const double *p = flat + (size_t)a * 2, *q = flat + (size_t)b * 2, *r = flat + (size_t)c * 2;
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

/* Returns whether corner i of the remaining ring is an ear: convex, without others in its triangle.
 */
static int is_ear(const double *flat, const uint32_t *ring, size_t count, size_t i) {
    uint32_t a = ring[(i + count - 1) % count], b = ring[i], c = ring[(i + 1) % count];
    if (!(turn(flat, a, b, c) > 0)) return 0;
    for (size_t k = 0; k < count; ++k) {
        uint32_t p = ring[k];
        if (p == a || p == b || p == c) continue;
        if (turn(flat, a, b, p) >= 0 && turn(flat, b, c, p) >= 0 && turn(flat, c, a, p) >= 0)
            return 0;
    }
    return 1;
}

static int is_convex(const double *flat, size_t count) {
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t b = (uint32_t)((i + 1) % count), c = (uint32_t)((i + 2) % count);
        if (turn(flat, i, b, c) < 0) return 0;
    }
    return 1;
}

static void emit(uint32_t *triangle, uint32_t a, uint32_t b, uint32_t c) {
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
}

/* Cuts off ears until three corners are left. Where the outline crosses itself there may be no ear.
 * The next corner is cut off all the same then, so that no face is lost. */
static void clip_ears(const double *flat, uint32_t *ring, size_t count, uint32_t *triangles) {
    size_t i = 0, misses = 0;
    while (count > 3) {
        i %= count;
        if (misses < count && !is_ear(flat, ring, count, i)) {
            ++i;
            ++misses;
            continue;
        }
        emit(triangles, ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]);
        triangles += 3;
        for (size_t k = i; k + 1 < count; ++k) ring[k] = ring[k + 1];
        --count;
        misses = 0;
    }
    emit(triangles, ring[0], ring[1], ring[2]);
}

psplat_result psplat_polygon_triangulate(const double *points, size_t count, uint32_t *triangles,
                                         psplat_error *error) {
    if (count < 3 || count > PSPLAT_MAX_CORNERS)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "a face of %zu corners", count);
    double *flat = malloc(count * 2 * sizeof *flat);
    uint32_t *ring = malloc(count * sizeof *ring);
    if (flat && ring) {
        project(points, count, flat);
        for (uint32_t i = 0; i < count; ++i) ring[i] = i;
        if (is_convex(flat, count))
            for (uint32_t i = 1; i + 1 < count; ++i) emit(triangles + (i - 1) * 3, 0, i, i + 1);
        else
            clip_ears(flat, ring, count, triangles);
    }
    psplat_result result = flat && ring
                               ? PSPLAT_OK
                               : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0,
                                             "out of memory for a face of %zu corners", count);
    free(flat);
    free(ring);
    return result;
}
