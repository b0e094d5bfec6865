/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facet_edges.c - edges of facets that are large beside the tolerance.
 *
 * Models of few polygons are shaded as if they were smooth, but their outlines are polygons. A
 * splat that is to stay within a small tolerance cannot reach over their edges by more than about
 * the tolerance over the angle, so that edges and corners fill up with small ones: their number
 * grows with the edges' length over the tolerance, to many times that of the triangles. With the
 * edges as bounds a splat for each facet is enough, whose field of normals is that of the facet.
 */
#include "features/facet_edges.h"

#include "base/vector.h"
#include "features/crease_follow.h"
#include "mesh/edges.h"

#include <math.h>
#include <stdlib.h>

/* The least error of a parabola across an edge that is marked, in tolerances. Of 0.05, 0.1, 0.25
 * and 0.5 it leaves the best pictures by bytes of a head of 968 triangles; where part of the
 * edges of a model are marked and splats reach over the others, those err more. */
static const double least_error = 0.05;

/* The part of the edges that bend by more than an angle, radians, that are between facets on a
 * model of facets. Elsewhere the parts between such edges are no facets and take many splats.
 * Chosen by hand. */
static const double least_facet_share = 0.5, bent_angle = 0.01;

/* Returns how far a triangle reaches from one of its edges, a length. */
static double altitude(const psplat_surface *surface, uint32_t triangle, double edge_length) {
    return 2 * surface->face_areas[triangle] / edge_length;
}

/* Returns whether an edge that bounds nothing is between two facets. *angle: how far the surface
 * turns over it, radians. */
static int is_between_facets(const psplat_surface *surface, uint32_t edge, double tolerance,
                             double *angle) {
    uint32_t other = surface->neighbors[edge];
    const double *left = surface->face_normals + 3 * (size_t)(edge / 3);
    const double *right = surface->face_normals + 3 * (size_t)other;
    double along[3], across[3];
    psplat_edge_vector(surface->mesh, edge, along);
    cross3(across, left, right);
    double length = length3(along);
    *angle = atan2(length3(across), dot3(left, right));
    double width = min2(altitude(surface, edge / 3, length), altitude(surface, other, length));
    return *angle * width >= 16 * least_error * tolerance;
}

void psplat_facet_edges_mark(psplat_surface *surface, double tolerance) {
    double angle;
    surface->facet_edges = 0;
    for (uint32_t e = 0; tolerance > 0 && e < 3 * surface->mesh->triangle_count; ++e) {
        if (surface->creases[e] || e / 3 > surface->neighbors[e]) continue;
        if (!is_between_facets(surface, e, tolerance, &angle)) continue;
        psplat_crease_set(surface, e, PSPLAT_BOUND_FACET);
        ++surface->facet_edges;
    }
}

static uint32_t find_root(uint32_t *parents, uint32_t t) {
    while (parents[t] != t) t = parents[t] = parents[parents[t]];
    return t;
}

psplat_result psplat_facets_count(const psplat_surface *surface, double tolerance, size_t *count) {
    const size_t triangles = surface->mesh->triangle_count;
    uint32_t *parents = malloc((triangles + 1) * sizeof *parents);
    size_t edges = 0, bent = 0;
    double angle;
    *count = 0;
    if (!parents) return PSPLAT_ERROR_MEMORY;
    for (uint32_t t = 0; t < triangles; ++t) parents[t] = t;
    for (uint32_t e = 0; e < 3 * triangles; ++e) {
        if (surface->creases[e] || e / 3 > surface->neighbors[e]) continue;
        if (is_between_facets(surface, e, tolerance, &angle))
            ++edges;
        else
            parents[find_root(parents, e / 3)] = find_root(parents, surface->neighbors[e]);
        bent += angle > bent_angle;
    }
    int are_facets = edges && (double)edges >= least_facet_share * (double)bent;
    for (uint32_t t = 0; t < triangles && are_facets; ++t) *count += parents[t] == t;
    free(parents);
    return PSPLAT_OK;
}
