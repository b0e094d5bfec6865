/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * slivers.c - normals of slivers, from the triangles beside them.
 *
 * Which way is right spreads from the triangles that are no slivers. A sliver keeps its normal
 * where one beside it agrees that is known to be right, as one strip of a narrow fillet does with
 * the next, up to a crease. What no sliver beside it agrees with in the end takes the normal of the
 * one across its longest edge, and what lies behind it is asked anew.
 */
#include "features/slivers.h"

#include "base/vector.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The greatest altitude of a sliver, in longest sides. Chosen by hand. */
static const double greatest_slimness = 0.2;
/* The cosine of the angle up to which normals agree: 30 degrees, as no crease has by default. */
static const double agreeing_cosine = 0.866;

/* The part of its longest side from which a sliver's edge counts: the strips of a thin wire face
 * all around it, and not as the ends do. */
static const double long_part = 0.5;

/* The slivers of a surface of which it is open whether their normals are right. */
typedef struct slivers {
    uint32_t *triangles; /* count, in order */
    uint32_t *ring;      /* those that have just been settled */
    size_t count, ring_count;
    uint8_t *is_open; /* of each triangle of the surface: it is one of them */
} slivers;

static double side_length(const psplat_mesh *mesh, uint32_t triangle, int side) {
    return sqrt(distance2_3(psplat_mesh_corner(mesh, triangle, side),
                            psplat_mesh_corner(mesh, triangle, (side + 1) % 3)));
}

static double longest_side(const psplat_mesh *mesh, uint32_t triangle) {
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = max2(longest, side_length(mesh, triangle, k));
    return longest;
}

static int is_sliver(const psplat_surface *surface, uint32_t triangle, double height) {
    double longest = longest_side(surface->mesh, triangle);
    /* A triangle's least altitude stands on its longest side. */
    double area = surface->face_areas[triangle];
    return 2 * area < longest * min2(height, greatest_slimness * longest);
}

static double *normal_of(const psplat_surface *surface, uint32_t triangle) {
    return surface->face_normals + 3 * (size_t)triangle;
}

/* Returns the triangle across the longest of the long edges of a sliver beyond which the normal is
 * right, of those where it agrees with the sliver's or of all; PSPLAT_NONE where there is no such
 * edge. */
static uint32_t right_beside(const psplat_surface *surface, const slivers *s, uint32_t triangle,
                             int agrees) {
    double least_cosine = agrees ? agreeing_cosine : -HUGE_VAL;
    uint32_t found = PSPLAT_NONE;
    double longest = long_part * longest_side(surface->mesh, triangle);
    for (int k = 0; k < 3; ++k) {
        uint32_t other = surface->neighbors[3 * (size_t)triangle + (size_t)k];
        double length = side_length(surface->mesh, triangle, k);
        if (other == PSPLAT_NONE || s->is_open[other] || length <= longest ||
            dot3(normal_of(surface, triangle), normal_of(surface, other)) < least_cosine)
            continue;
        longest = length;
        found = other;
    }
    return found;
}

/* Settles slivers beside triangles whose normal is right: those that agree with it keep theirs; or
 * all take it. They count only once all of this ring are settled, so that the order of triangles
 * does not matter. Returns whether there were any. */
static int settle_ring(psplat_surface *surface, slivers *s, int agrees) {
    size_t kept = 0;
    s->ring_count = 0;
    for (size_t i = 0; i < s->count; ++i) {
        uint32_t triangle = s->triangles[i];
        uint32_t other = right_beside(surface, s, triangle, agrees);
        if (other == PSPLAT_NONE) {
            s->triangles[kept++] = triangle;
            continue;
        }
        if (!agrees)
            memcpy(normal_of(surface, triangle), normal_of(surface, other), 3 * sizeof(double));
        s->ring[s->ring_count++] = triangle;
    }
    for (size_t i = 0; i < s->ring_count; ++i) s->is_open[s->ring[i]] = 0;
    s->count = kept;
    return s->ring_count > 0;
}

static void find_slivers(const psplat_surface *surface, double height, slivers *s) {
    for (uint32_t t = 0; t < surface->mesh->triangle_count; ++t) {
        s->is_open[t] = (uint8_t)is_sliver(surface, t, height);
        if (s->is_open[t]) s->triangles[s->count++] = t;
    }
}

psplat_result psplat_slivers_settle(psplat_surface *surface, double height) {
    size_t count = surface->mesh->triangle_count;
    slivers s = {0};
    if (!(height > 0)) return PSPLAT_OK;
    s.triangles = malloc((count + 1) * sizeof *s.triangles);
    s.ring = malloc((count + 1) * sizeof *s.ring);
    s.is_open = calloc(count + 1, 1);
    int ok = s.triangles && s.ring && s.is_open;
    if (ok) find_slivers(surface, height, &s);
    while (s.count && (settle_ring(surface, &s, 1) || settle_ring(surface, &s, 0))) continue;
    free(s.triangles);
    free(s.ring);
    free(s.is_open);
    return ok ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}
