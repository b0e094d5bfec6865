/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease.c - which edges are creases, and the smooth patches that they bound.
 *
 * A dihedral angle alone takes the noise of scans for creases: relief.c measures the noise, bend.c
 * judges each edge by its surroundings, and of what may be noise only chains of some length are
 * creases (drop_short). From there they are followed along weaker edges, since creases fade out
 * (follow.c). Edges between groups of the file, and those that its normals make hard (authored.c),
 * are creases in any case.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* A crease is followed until it bends by a third of the angle, but by 20 degrees less at most. */
static const double weak_part = 1.0 / 3.0;
static const double most_fading = 0.349;
/* Bends of more than this are no roughness, whatever the crease angle is. */
static const double most_rough = 0.5236;
/* Connected creases shorter than this part of the diagonal are noise. */
static const double least_length = 0.02;
/* What the length of an edge counts there that is only likely a crease. */
static const double likely_part = 0.3;
/* And that so many such edges make a crease at least. */
enum { LEAST_LIKELY = 8 };
/* Of the crease angle: what an edge must bend by that the file's normals call smooth. */
static const double authored_factor = 2;

/* Loops over fewer than this are not worth waiting for other threads. */
enum { LEAST_SHARED = 50000 };

typedef struct find_rule {
    double crease_angle, weak_angle;
    const uint8_t *authored;
} find_rule;

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

void psplat_crease_set(psplat_surface *surface, uint32_t edge, uint8_t value) {
    uint32_t twin = edge_twin(surface, edge);
    surface->creases[edge] = value;
    if (twin != PSPLAT_NONE) surface->creases[twin] = value;
}

static uint32_t find_root(uint32_t *parents, uint32_t i) {
    while (parents[i] != i) i = parents[i] = parents[parents[i]];
    return i;
}

static double edge_length(const psplat_surface *surface, uint32_t edge) {
    double along[3];
    psplat_edge_vector(surface->mesh, edge, along);
    return length3(along);
}

/* Connected creases too short to be anything but noise become smooth again. */
static void drop_short(psplat_surface *surface, const uint8_t *kinds, uint32_t *parents,
                       double *lengths) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t edges = (uint32_t)(3 * mesh->triangle_count);
    double least = least_length * surface->diagonal;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) parents[v] = v, lengths[v] = 0;
    for (uint32_t e = 0; e < edges; ++e)
        if (kinds[e] >= PSPLAT_BEND_LIKELY)
            parents[find_root(parents, edge_end(surface, e, 0))] =
                find_root(parents, edge_end(surface, e, 1));
    for (uint32_t e = 0; e < edges; ++e) {
        double *length = lengths + find_root(parents, edge_end(surface, e, 0));
        if (kinds[e] >= PSPLAT_BEND_SHARP) *length += edge_length(surface, e);
        if (kinds[e] == PSPLAT_BEND_LIKELY)
            *length += min2(likely_part * edge_length(surface, e), least / LEAST_LIKELY);
    }
    for (uint32_t e = 0; e < edges; ++e) {
        if (kinds[e] != PSPLAT_BEND_LIKELY && kinds[e] != PSPLAT_BEND_SHARP) continue;
        /* A hair less, so that LEAST_LIKELY edges suffice in spite of rounding. */
        if (lengths[find_root(parents, edge_end(surface, e, 0))] < (1 - 1e-9) * least)
            psplat_crease_set(surface, e, 0);
    }
}

static int is_seam(const psplat_surface *surface, uint32_t edge) {
    const uint32_t *groups = surface->mesh->groups;
    return groups && groups[edge / 3] != groups[surface->neighbors[edge]];
}

static psplat_bend judge(const psplat_surface *surface, const psplat_relief *relief, uint32_t edge,
                         const find_rule *rule) {
    uint8_t authored = rule->authored[edge];
    double angle = rule->crease_angle * authored_factor;
    if (is_seam(surface, edge) || (authored & PSPLAT_AUTHORED_HARD)) return PSPLAT_BEND_GIVEN;
    if (authored & PSPLAT_AUTHORED_FADING) return PSPLAT_BEND_FAINT;
    if (authored & PSPLAT_AUTHORED_SMOOTH)
        return psplat_bend_judge(surface, relief, edge, angle, HUGE_VAL);
    return psplat_bend_judge(surface, relief, edge, rule->crease_angle, rule->weak_angle);
}

/* Fills kinds (psplat_bend) of edges that have a neighbour; an edge is judged from one side. */
static void judge_edges(const psplat_surface *surface, const psplat_relief *relief,
                        const find_rule *rule, uint8_t *kinds) {
    uint32_t count = (uint32_t)(3 * surface->mesh->triangle_count);
#pragma omp parallel for schedule(dynamic, 4096) if (count >= LEAST_SHARED)
    for (uint32_t e = 0; e < count; ++e)
        if (surface->neighbors[e] != PSPLAT_NONE && e / 3 < surface->neighbors[e])
            kinds[e] = (uint8_t)judge(surface, relief, e, rule);
}

static void mark_sharp(psplat_surface *surface, const uint8_t *kinds) {
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        if (kinds[e] >= PSPLAT_BEND_LIKELY || surface->neighbors[e] == PSPLAT_NONE)
            psplat_crease_set(surface, e, 1);
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

static psplat_result find_sharp(psplat_surface *surface, const find_rule *rule) {
    const psplat_mesh *mesh = surface->mesh;
    psplat_relief relief;
    uint8_t *kinds = calloc(mesh->triangle_count, 3);
    uint32_t *parents = malloc(mesh->vertex_count * sizeof *parents);
    double *lengths = malloc(mesh->vertex_count * sizeof *lengths);
    psplat_result result =
        psplat_relief_measure(surface, min2(rule->crease_angle, most_rough), &relief);
    if (!kinds || !parents || !lengths) result = PSPLAT_ERROR_MEMORY;
    if (!result) {
        judge_edges(surface, &relief, rule, kinds);
        mark_sharp(surface, kinds);
        drop_short(surface, kinds, parents, lengths);
        result =
            psplat_crease_follow(surface, &relief, rule->crease_angle, rule->weak_angle, kinds);
    }
    psplat_relief_free(&relief);
    free(kinds);
    free(parents);
    free(lengths);
    return result;
}

static void mark_borders(psplat_surface *surface) {
    for (uint32_t e = 0; e < 3 * surface->mesh->triangle_count; ++e)
        surface->creases[e] = surface->neighbors[e] == PSPLAT_NONE;
}

psplat_result psplat_crease_find(psplat_surface *surface, double crease_angle,
                                 const uint8_t *authored) {
    uint32_t *stack = malloc(surface->mesh->triangle_count * sizeof *stack);
    psplat_result result = stack ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
    find_rule rule = {.crease_angle = crease_angle,
                      .weak_angle = max2(weak_part * crease_angle, crease_angle - most_fading),
                      .authored = authored};
    if (!result && isinf(crease_angle)) mark_borders(surface);
    if (!result && !isinf(crease_angle)) result = find_sharp(surface, &rule);
    if (!result) {
        number_patches(surface, stack);
        measure_edges(surface);
    }
    free(stack);
    return result;
}
