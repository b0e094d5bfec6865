/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease.c - crease detection, and the smooth patches between creases.
 *
 * A limit of the dihedral angle alone would take the noise of scans for creases. Therefore
 * curvature.c measures the noise, crease_classify.c classifies each edge by the surface around it,
 * and connected creases that are too short become smooth again (drop_short_chains). From the
 * creases that are left, crease_follow.c continues along weaker edges, since creases fade out.
 * Edges between groups of the file, and edges that its normals make hard (authored_normals.c), are
 * creases at any angle and length. With PSPLAT_NO_CREASES only borders are creases. Last come the
 * borders of charts (chart_borders.c), tangent edges (tangent_edges.c) and, where they are asked
 * for, edges of facets (facet_edges.c), which bound patches and are no creases.
 */
#include "features/crease.h"

#include "base/vector.h"
#include "features/authored_normals.h"
#include "features/chart_borders.h"
#include "features/crease_classify.h"
#include "features/crease_follow.h"
#include "features/curvature.h"
#include "features/facet_edges.h"
#include "features/surface.h"
#include "features/tangent_edges.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Chosen by hand. A crease is followed along edges whose angle is at least this fraction of the
 * crease angle, and at most this many radians (20 degrees) less than it. */
static const double weak_angle_fraction = 1.0 / 3.0;
static const double max_angle_reduction = 0.349;
/* Angles over this (radians, 30 degrees) count neither as noise nor as roughness, whatever the
 * crease angle is. */
static const double max_rough_angle = 0.5236;
/* Connected creases whose lengths add up to less than this, in diagonals, are noise. */
static const double min_length_diagonals = 0.02;
/* The part of its length that a probable crease adds there, and the least number of probable
 * creases that are enough. */
static const double probable_length_fraction = 0.3;
enum { MIN_PROBABLE_EDGES = 8 };
/* The crease angle is this many times as great for edges that the file's normals make smooth. */
static const double smooth_normals_factor = 2;

/* The limits of the detection, angles in radians. */
typedef struct crease_rule {
    double crease_angle, weak_angle;
    const uint8_t *authored; /* psplat_authored_read */
} crease_rule;

static uint32_t find_root(uint32_t *parents, uint32_t i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

static double edge_length(const psplat_surface *surface, uint32_t edge) {
    double along[3];
    psplat_edge_vector(surface->mesh, edge, along);
    return length3(along);
}

/* Makes connected creases smooth again that are too short to be anything but noise. parents and
 * lengths have room for all vertices; parents is a union-find forest over them. */
static void drop_short_chains(psplat_surface *surface, const uint8_t *kinds, uint32_t *parents,
                              double *lengths) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t edges = (uint32_t)(3 * mesh->triangle_count);
    double min_length = min_length_diagonals * surface->diagonal;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) parents[v] = v, lengths[v] = 0;
    for (uint32_t e = 0; e < edges; ++e)
        if (kinds[e] >= PSPLAT_EDGE_PROBABLE)
            parents[find_root(parents, psplat_edge_vertex(surface->mesh, e, 0))] =
                find_root(parents, psplat_edge_vertex(surface->mesh, e, 1));
    for (uint32_t e = 0; e < edges; ++e) {
        double *length = lengths + find_root(parents, psplat_edge_vertex(surface->mesh, e, 0));
        if (kinds[e] >= PSPLAT_EDGE_SHARP) *length += edge_length(surface, e);
        if (kinds[e] == PSPLAT_EDGE_PROBABLE)
            *length += min2(probable_length_fraction * edge_length(surface, e),
                            min_length / MIN_PROBABLE_EDGES);
    }
    for (uint32_t e = 0; e < edges; ++e) {
        if (kinds[e] != PSPLAT_EDGE_PROBABLE && kinds[e] != PSPLAT_EDGE_SHARP) continue;
        /* The limit is a little less, so that rounding does not ask for one edge more. */
        if (lengths[find_root(parents, psplat_edge_vertex(surface->mesh, e, 0))] <
            (1 - 1e-9) * min_length)
            psplat_crease_set(surface, e, 0);
    }
}

/* Returns whether the two triangles of an edge belong to different groups. */
static int is_group_border(const psplat_surface *surface, uint32_t edge) {
    const uint32_t *groups = surface->mesh->groups;
    return groups && groups[edge / 3] != groups[surface->neighbors[edge]];
}

static psplat_edge_kind classify_edge(const psplat_surface *surface,
                                      const psplat_curvature *curvature, uint32_t edge,
                                      const crease_rule *rule) {
    uint8_t authored = rule->authored[edge];
    double angle = rule->crease_angle * smooth_normals_factor;
    if (is_group_border(surface, edge) || (authored & PSPLAT_AUTHORED_HARD))
        return PSPLAT_EDGE_AUTHORED;
    if (authored & PSPLAT_AUTHORED_HALF_HARD) return PSPLAT_EDGE_COLLINEAR;
    if (authored & PSPLAT_AUTHORED_SMOOTH)
        return psplat_crease_classify(surface, curvature, edge, angle, HUGE_VAL);
    return psplat_crease_classify(surface, curvature, edge, rule->crease_angle, rule->weak_angle);
}

/* Fills in kinds (psplat_edge_kind). Of the two half-edges of an edge only one is classified; the
 * other and borders stay PSPLAT_EDGE_SMOOTH. */
static void classify_edges(const psplat_surface *surface, const psplat_curvature *curvature,
                           const crease_rule *rule, uint8_t *kinds) {
    uint32_t count = (uint32_t)(3 * surface->mesh->triangle_count);
#pragma omp parallel for schedule(dynamic, 4096) if (count >= PSPLAT_MIN_PARALLEL_COUNT)
    for (uint32_t e = 0; e < count; ++e)
        if (surface->neighbors[e] != PSPLAT_NONE && e / 3 < surface->neighbors[e])
            kinds[e] = (uint8_t)classify_edge(surface, curvature, e, rule);
}

static void mark_creases(psplat_surface *surface, const uint8_t *kinds) {
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        if (kinds[e] >= PSPLAT_EDGE_PROBABLE || surface->neighbors[e] == PSPLAT_NONE)
            psplat_crease_set(surface, e, PSPLAT_BOUND_CREASE);
}

/* Numbers the patches by flooding over edges that bound none. */
static psplat_result number_patches(psplat_surface *surface) {
    size_t count = surface->mesh->triangle_count;
    uint32_t *stack = malloc(count * sizeof *stack);
    if (!stack) return PSPLAT_ERROR_MEMORY;
    memset(surface->patches, 0xff, count * sizeof(uint32_t));
    for (uint32_t seed = 0; seed < count; ++seed) {
        if (surface->patches[seed] != PSPLAT_NONE) continue;
        uint32_t patch = (uint32_t)surface->patch_count++;
        size_t depth = 0;
        stack[depth++] = seed;
        surface->patches[seed] = patch;
        while (depth) {
            uint32_t t = stack[--depth];
            for (uint32_t e = 3 * t; e < 3 * t + 3; ++e) {
                uint32_t next = surface->neighbors[e];
                if (surface->creases[e] || surface->patches[next] != PSPLAT_NONE) continue;
                surface->patches[next] = patch;
                stack[depth++] = next;
            }
        }
    }
    free(stack);
    return PSPLAT_OK;
}

/* Counts creases and measures the roughness between them. */
static void measure_edges(psplat_surface *surface) {
    size_t halves = 0, smooth = 0;
    double squares = 0;
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e) {
        if (surface->creases[e] == PSPLAT_BOUND_CREASE) {
            halves += surface->neighbors[e] != PSPLAT_NONE;
        } else if (e / 3 < surface->neighbors[e]) {
            const double *n = surface->face_normals;
            double c[3];
            cross3(c, n + 3 * (size_t)(e / 3), n + 3 * (size_t)surface->neighbors[e]);
            double angle = atan2(
                length3(c), dot3(n + 3 * (size_t)(e / 3), n + 3 * (size_t)surface->neighbors[e]));
            squares += angle * angle;
            ++smooth;
        }
    }
    surface->crease_edges = halves / 2;
    surface->roughness = smooth ? sqrt(squares / (double)smooth) : 0;
}

static psplat_result find_creases(psplat_surface *surface, const crease_rule *rule) {
    const psplat_mesh *mesh = surface->mesh;
    psplat_curvature curvature;
    uint8_t *kinds = calloc(mesh->triangle_count, 3);
    uint32_t *parents = malloc(mesh->vertex_count * sizeof *parents);
    double *lengths = malloc(mesh->vertex_count * sizeof *lengths);
    psplat_result result =
        psplat_curvature_measure(surface, min2(rule->crease_angle, max_rough_angle), &curvature);
    if (!kinds || !parents || !lengths) result = PSPLAT_ERROR_MEMORY;
    if (!result) {
        classify_edges(surface, &curvature, rule, kinds);
        mark_creases(surface, kinds);
        drop_short_chains(surface, kinds, parents, lengths);
        result =
            psplat_crease_follow(surface, &curvature, rule->crease_angle, rule->weak_angle, kinds);
    }
    psplat_curvature_free(&curvature);
    free(kinds);
    free(parents);
    free(lengths);
    return result;
}

static void mark_borders(psplat_surface *surface) {
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        surface->creases[e] = surface->neighbors[e] == PSPLAT_NONE;
}

psplat_result psplat_crease_find(psplat_surface *surface, const psplat_patch_bounds *bounds,
                                 const uint8_t *authored) {
    psplat_result result = PSPLAT_OK;
    double crease_angle = bounds->crease_angle;
    crease_rule rule = {
        .crease_angle = crease_angle,
        .weak_angle = max2(weak_angle_fraction * crease_angle, crease_angle - max_angle_reduction),
        .authored = authored};
    if (isinf(crease_angle))
        mark_borders(surface);
    else
        result = find_creases(surface, &rule);
    if (!result) result = psplat_chart_borders_mark(surface);
    if (!result) result = psplat_tangent_edges_mark(surface, authored, bounds->tolerance);
    if (!result) psplat_facet_edges_mark(surface, bounds->facet_tolerance);
    if (!result) result = number_patches(surface);
    if (!result) measure_edges(surface);
    return result;
}
