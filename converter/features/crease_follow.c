/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * crease_follow.c - creases continued along weak edges (hysteresis, as in Canny's edge detector).
 *
 * Edges with a small angle continue a crease only if they are collinear with it. Facets that end at
 * a crease would otherwise leave spurs on it.
 */
#include "features/crease_follow.h"

#include "base/vector.h"
#include "features/crease_classify.h"
#include "features/curvature.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

/* The least cosine of the turn at a vertex with which an edge continues a crease (66 degrees).
 * Chosen by hand. */
static const double collinear_cosine = 0.4;

/* The edges that may become creases, in linked lists by their end vertices, two links for each. */
typedef struct follower {
    psplat_surface *surface;
    const psplat_curvature *curvature;
    double crease_angle, weak_angle;
    uint8_t *kinds;
    uint32_t *weak;  /* weak_count edges */
    uint32_t *first; /* of each vertex the first link, or PSPLAT_NONE */
    uint32_t *next;  /* of each link the next one; link 2 i + end belongs to weak[i] */
    uint32_t *queue; /* crease edges that are continued */
    size_t weak_count, queue_count;
} follower;

/* Stores the unit direction of an edge away from one of its ends. */
static void direction_from(const psplat_mesh *mesh, uint32_t edge, int end, double away[3]) {
    psplat_edge_vector(mesh, edge, away);
    if (end)
        for (int k = 0; k < 3; ++k) away[k] = -away[k];
    normalize3(away);
}

static size_t may_be_weak(uint8_t kind) {
    return kind == PSPLAT_EDGE_UNTESTED || kind == PSPLAT_EDGE_WEAK ||
           kind == PSPLAT_EDGE_COLLINEAR;
}

static void list_weak(follower *f) {
    const psplat_mesh *mesh = f->surface->mesh;
    memset(f->first, 0xff, mesh->vertex_count * sizeof *f->first);
    for (uint32_t e = 0; e < 3 * mesh->triangle_count; ++e) {
        if (!may_be_weak(f->kinds[e])) continue;
        for (int end = 0; end < 2; ++end) {
            uint32_t vertex = psplat_edge_vertex(mesh, e, end);
            uint32_t link = (uint32_t)(2 * f->weak_count) + (uint32_t)end;
            f->next[link] = f->first[vertex];
            f->first[vertex] = link;
        }
        f->weak[f->weak_count++] = e;
    }
}

/* Returns the kind of an edge, which it classifies if that has not been done. */
static psplat_edge_kind kind_of(follower *f, uint32_t edge) {
    if (f->kinds[edge] == PSPLAT_EDGE_UNTESTED)
        f->kinds[edge] = (uint8_t)psplat_crease_classify_weak(f->surface, f->curvature, edge,
                                                              f->crease_angle, f->weak_angle);
    return (psplat_edge_kind)f->kinds[edge];
}

/* Makes creases of the weak edges at one end of a crease edge, and queues them. */
static void continue_at(follower *f, uint32_t edge, int end) {
    const psplat_mesh *mesh = f->surface->mesh;
    double away[3], onward[3];
    direction_from(mesh, edge, end, away);
    uint32_t link = f->first[psplat_edge_vertex(mesh, edge, end)];
    for (; link != PSPLAT_NONE; link = f->next[link]) {
        uint32_t weak = f->weak[link / 2];
        if (f->surface->creases[weak]) continue;
        psplat_edge_kind kind = kind_of(f, weak);
        direction_from(mesh, weak, link % 2, onward);
        int is_collinear = -dot3(away, onward) >= collinear_cosine;
        if (kind == PSPLAT_EDGE_SMOOTH || (kind == PSPLAT_EDGE_COLLINEAR && !is_collinear))
            continue;
        psplat_crease_set(f->surface, weak, PSPLAT_BOUND_CREASE);
        f->queue[f->queue_count++] = weak;
    }
}

static void follow(follower *f) {
    const psplat_surface *surface = f->surface;
    list_weak(f);
    for (uint32_t e = 0; f->weak_count && e < 3 * surface->mesh->triangle_count; ++e)
        if (surface->creases[e] && surface->neighbors[e] != PSPLAT_NONE &&
            e / 3 < surface->neighbors[e])
            f->queue[f->queue_count++] = e;
    for (size_t at = 0; at < f->queue_count; ++at)
        for (int end = 0; end < 2; ++end) continue_at(f, f->queue[at], end);
}

psplat_result psplat_crease_follow(psplat_surface *surface, const psplat_curvature *curvature,
                                   double crease_angle, double weak_angle, uint8_t *kinds) {
    size_t edges = 3 * surface->mesh->triangle_count, weak = 0;
    for (size_t e = 0; e < edges; ++e) weak += may_be_weak(kinds[e]);
    follower f = {.surface = surface,
                  .curvature = curvature,
                  .crease_angle = crease_angle,
                  .weak_angle = weak_angle,
                  .kinds = kinds,
                  .weak = malloc((weak + 1) * sizeof *f.weak),
                  .first = malloc(surface->mesh->vertex_count * sizeof *f.first),
                  .next = malloc((weak + 1) * 2 * sizeof *f.next),
                  .queue = malloc((edges / 2 + 1) * sizeof *f.queue)};
    int allocated = f.weak && f.first && f.next && f.queue;
    if (allocated) follow(&f);
    free(f.weak);
    free(f.first);
    free(f.next);
    free(f.queue);
    return allocated ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}

/* Returns the half-edge of the same edge in the neighbour, or PSPLAT_NONE. */
static uint32_t edge_twin(const psplat_surface *surface, uint32_t edge) {
    uint32_t other = surface->neighbors[edge];
    if (other == PSPLAT_NONE) return PSPLAT_NONE;
    for (uint32_t k = 0; k < 3; ++k)
        if (psplat_edge_vertex(surface->mesh, 3 * other + k, 0) ==
                psplat_edge_vertex(surface->mesh, edge, 1) &&
            psplat_edge_vertex(surface->mesh, 3 * other + k, 1) ==
                psplat_edge_vertex(surface->mesh, edge, 0))
            return 3 * other + k;
    return PSPLAT_NONE;
}

void psplat_crease_set(psplat_surface *surface, uint32_t edge, uint8_t value) {
    uint32_t twin = edge_twin(surface, edge);
    surface->creases[edge] = value;
    if (twin != PSPLAT_NONE) surface->creases[twin] = value;
}
