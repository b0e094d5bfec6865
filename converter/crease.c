/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease.c - which edges are creases, and the smooth patches that they bound.
 *
 * A dihedral angle alone takes the noise of scans for creases. An edge is a crease where its own
 * angle reaches the threshold and the mean normals of the two sides, a dozen triangles each, also
 * differ by a good part of it. From there the crease is followed along edges of a third of the
 * angle that stand out from their surroundings (hysteresis, as in Canny's edges), since creases
 * fade out.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE_TRIANGLES = 12 };

/* Parts of the crease angle, and of the model's size; see the functions that use them. */
static const double side_part = 0.6;
static const double weak_part = 1.0 / 3.0;
static const double prominence = 3.0;
static const double sharp_prominence = 1.6;
static const double least_length = 0.02;

static double angle_between(const double a[3], const double b[3]) {
    double c[3];
    cross3(c, a, b);
    return atan2(length3(c), dot3(a, b));
}

static double edge_angle(const psplat_surface *surface, uint32_t edge) {
    const double *n = surface->face_normals;
    return angle_between(n + 3 * (size_t)(edge / 3), n + 3 * (size_t)surface->neighbors[edge]);
}

/* The two sides of an edge: triangles reached from either without crossing a sharp edge. */
typedef struct edge_sides {
    uint32_t triangles[2][SIDE_TRIANGLES];
    size_t counts[2];
    double roughness; /* greatest angle inside a side */
} edge_sides;

static int side_holds(const edge_sides *sides, uint32_t triangle) {
    for (int side = 0; side < 2; ++side)
        for (size_t i = 0; i < sides->counts[side]; ++i)
            if (sides->triangles[side][i] == triangle) return 1;
    return 0;
}

static void side_expand(const psplat_surface *surface, edge_sides *sides, int side, size_t at,
                        uint32_t own_edge, double limit) {
    for (uint32_t k = 0; k < 3; ++k) {
        uint32_t edge = 3 * sides->triangles[side][at] + k, next = surface->neighbors[edge];
        if (edge == own_edge || next == PSPLAT_NONE || sides->counts[side] == SIDE_TRIANGLES)
            continue;
        double angle = edge_angle(surface, edge);
        if (angle >= limit || side_holds(sides, next)) continue;
        if (angle > sides->roughness) sides->roughness = angle;
        sides->triangles[side][sides->counts[side]++] = next;
    }
}

/* Grows both sides in turn, so that neither runs around the edge's end into the other. */
static void find_sides(const psplat_surface *surface, uint32_t edge, double limit,
                       edge_sides *sides) {
    uint32_t other = surface->neighbors[edge], back = 3 * other;
    while (surface->mesh->triangles[back] !=
           surface->mesh->triangles[edge % 3 == 2 ? edge - 2 : edge + 1])
        ++back;
    *sides = (edge_sides){.triangles = {{edge / 3}, {other}}, .counts = {1, 1}};
    uint32_t own[2] = {edge, back};
    for (size_t at = 0; at < SIDE_TRIANGLES; ++at)
        for (int side = 0; side < 2; ++side)
            if (at < sides->counts[side]) side_expand(surface, sides, side, at, own[side], limit);
}

static double side_angle(const psplat_surface *surface, const edge_sides *sides) {
    double sums[2][3] = {{0}};
    for (int side = 0; side < 2; ++side)
        for (size_t i = 0; i < sides->counts[side]; ++i) {
            uint32_t t = sides->triangles[side][i];
            mad3(sums[side], surface->face_areas[t], surface->face_normals + 3 * (size_t)t);
        }
    return angle_between(sums[0], sums[1]);
}

enum { EDGE_SMOOTH = 0, EDGE_SHARP = 1, EDGE_WEAK = 2 };

static int classify(const psplat_surface *surface, uint32_t edge, double crease_angle) {
    double angle = edge_angle(surface, edge);
    if (angle < weak_part * crease_angle) return EDGE_SMOOTH;
    edge_sides sides;
    find_sides(surface, edge, angle < crease_angle ? angle : crease_angle, &sides);
    double mean_angle = side_angle(surface, &sides);
    int calm = angle >= 2 * crease_angle || sides.roughness * sharp_prominence <= angle;
    if (angle >= crease_angle && mean_angle >= side_part * crease_angle && calm) return EDGE_SHARP;
    int stands_out =
        sides.roughness * prominence <= angle && mean_angle >= weak_part * crease_angle;
    return stands_out ? EDGE_WEAK : EDGE_SMOOTH;
}

static uint32_t edge_end(const psplat_surface *surface, uint32_t edge, int end) {
    uint32_t next = edge % 3 == 2 ? edge - 2 : edge + 1;
    return surface->mesh->triangles[end ? next : edge];
}

static uint32_t edge_twin(const psplat_surface *surface, uint32_t edge) {
    uint32_t other = surface->neighbors[edge];
    if (other == PSPLAT_NONE) return PSPLAT_NONE;
    for (uint32_t k = 0; k < 3; ++k)
        if (edge_end(surface, 3 * other + k, 0) == edge_end(surface, edge, 1) &&
            edge_end(surface, 3 * other + k, 1) == edge_end(surface, edge, 0))
            return 3 * other + k;
    return PSPLAT_NONE;
}

static void set_crease(psplat_surface *surface, uint32_t edge, uint8_t value) {
    uint32_t twin = edge_twin(surface, edge);
    surface->creases[edge] = value;
    if (twin != PSPLAT_NONE) surface->creases[twin] = value;
}

/* Weak edges become creases where they continue one; repeated until nothing changes, each pass
 * along the whole list, with a flag per vertex that a crease has reached. */
static void follow_weak(psplat_surface *surface, const uint32_t *weak, size_t count,
                        uint8_t *reached) {
    for (int changed = 1; changed;) {
        changed = 0;
        for (size_t i = 0; i < count; ++i) {
            uint32_t edge = weak[i], a = edge_end(surface, edge, 0), b = edge_end(surface, edge, 1);
            if (surface->creases[edge] || !(reached[a] | reached[b])) continue;
            set_crease(surface, edge, 1);
            reached[a] = reached[b] = 1;
            changed = 1;
        }
    }
}

static uint32_t find_root(uint32_t *parents, uint32_t i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

static double edge_length(const psplat_surface *surface, uint32_t edge) {
    double d[3];
    sub3(d, surface->mesh->positions + 3 * (size_t)edge_end(surface, edge, 0),
         surface->mesh->positions + 3 * (size_t)edge_end(surface, edge, 1));
    return length3(d);
}

/* Connected creases too short to be anything but noise become smooth again. */
static void drop_short(psplat_surface *surface, uint32_t *parents, double *lengths) {
    const psplat_mesh *mesh = surface->mesh;
    size_t edges = 3 * mesh->triangle_count;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) parents[v] = v, lengths[v] = 0;
    for (uint32_t e = 0; e < edges; ++e)
        if (surface->creases[e])
            parents[find_root(parents, edge_end(surface, e, 0))] =
                find_root(parents, edge_end(surface, e, 1));
    for (uint32_t e = 0; e < edges; ++e)
        if (surface->creases[e])
            lengths[find_root(parents, edge_end(surface, e, 0))] +=
                edge_length(surface, e) * (edge_twin(surface, e) == PSPLAT_NONE ? 1 : 0.5);
    for (uint32_t e = 0; e < edges; ++e) {
        if (!surface->creases[e] || surface->neighbors[e] == PSPLAT_NONE) continue;
        uint32_t other = surface->neighbors[e];
        if (mesh->groups && mesh->groups[e / 3] != mesh->groups[other]) continue;
        if (lengths[find_root(parents, edge_end(surface, e, 0))] < least_length * surface->diagonal)
            set_crease(surface, e, 0);
    }
}

/* Marks sharp edges and what bounds the surface, and lists the weak ones. */
static size_t mark_edges(psplat_surface *surface, double crease_angle, uint32_t *weak) {
    const psplat_mesh *mesh = surface->mesh;
    size_t weak_count = 0;
    for (uint32_t e = 0; e < 3 * mesh->triangle_count; ++e) {
        uint32_t other = surface->neighbors[e];
        int kind = EDGE_SHARP;
        if (other != PSPLAT_NONE) {
            if (other < e / 3) continue; /* decided from the other side */
            int seam = mesh->groups && mesh->groups[e / 3] != mesh->groups[other];
            if (isinf(crease_angle))
                kind = EDGE_SMOOTH;
            else if (!seam)
                kind = classify(surface, e, crease_angle);
        }
        if (kind == EDGE_WEAK) weak[weak_count++] = e;
        if (kind == EDGE_SHARP) set_crease(surface, e, 1);
    }
    return weak_count;
}

/* Numbers the patches by flooding over edges that are not creases. */
static void number_patches(psplat_surface *surface, uint32_t *stack) {
    size_t count = surface->mesh->triangle_count;
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
}

static void measure_edges(psplat_surface *surface) {
    size_t halves = 0, smooth = 0;
    double squares = 0;
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e) {
        if (surface->creases[e]) {
            halves += surface->neighbors[e] != PSPLAT_NONE;
        } else if (e / 3 < surface->neighbors[e]) {
            double angle = edge_angle(surface, e);
            squares += angle * angle;
            ++smooth;
        }
    }
    surface->crease_edges = halves / 2;
    surface->roughness = smooth ? sqrt(squares / (double)smooth) : 0;
}

psplat_result psplat_crease_find(psplat_surface *surface, double crease_angle) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t *edges = malloc(3 * mesh->triangle_count * sizeof *edges);
    uint8_t *reached = calloc(mesh->vertex_count, 1);
    uint32_t *parents = malloc(mesh->vertex_count * sizeof *parents);
    double *lengths = malloc(mesh->vertex_count * sizeof *lengths);
    psplat_result result = PSPLAT_ERROR_MEMORY;
    if (edges && reached && parents && lengths) {
        size_t weak_count = mark_edges(surface, crease_angle, edges);
        drop_short(surface, parents, lengths);
        for (uint32_t e = 0; e < 3 * mesh->triangle_count; ++e)
            if (surface->creases[e]) reached[edge_end(surface, e, 0)] = 1;
        follow_weak(surface, edges, weak_count, reached);
        number_patches(surface, edges);
        measure_edges(surface);
        result = PSPLAT_OK;
    }
    free(edges);
    free(reached);
    free(parents);
    free(lengths);
    return result;
}
