/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * follow.c - creases continued along weak edges: hysteresis, as in Canny's edge detector. A faint
 * edge continues a crease, it does not branch off: facets that end at a crease would otherwise
 * leave spurs on it.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Cosine of the turn at a vertex up to which a chain continues: 66 degrees. */
static const double straight = 0.4;

/* Edges that may be weak, by their ends: lists through next, two links an edge. */
typedef struct follower {
    psplat_surface *surface;
    const psplat_relief *relief;
    double crease_angle, weak_angle;
    uint8_t *kinds;
    uint32_t *weak;  /* edges, weak_count */
    uint32_t *first; /* of each vertex: link, or PSPLAT_NONE */
    uint32_t *next;  /* of each link; link 2 i + end belongs to weak edge i */
    uint32_t *queue; /* crease edges to continue */
    size_t weak_count, queue_count;
} follower;

static uint32_t end_of(const psplat_mesh *mesh, uint32_t edge, uint32_t end) {
    return mesh->triangles[end ? (edge % 3 == 2 ? edge - 2 : edge + 1) : edge];
}

static void direction_from(const psplat_mesh *mesh, uint32_t edge, uint32_t end, double away[3]) {
    psplat_edge_vector(mesh, edge, away);
    if (end)
        for (int k = 0; k < 3; ++k) away[k] = -away[k];
    normalize3(away);
}

static size_t may_be_weak(uint8_t kind) {
    return kind == PSPLAT_BEND_OPEN || kind == PSPLAT_BEND_WEAK || kind == PSPLAT_BEND_FAINT;
}

static void list_weak(follower *f) {
    const psplat_mesh *mesh = f->surface->mesh;
    memset(f->first, 0xff, mesh->vertex_count * sizeof *f->first);
    for (uint32_t e = 0; e < 3 * mesh->triangle_count; ++e) {
        if (!may_be_weak(f->kinds[e])) continue;
        for (uint32_t end = 0; end < 2; ++end) {
            uint32_t vertex = end_of(mesh, e, end), link = (uint32_t)(2 * f->weak_count) + end;
            f->next[link] = f->first[vertex];
            f->first[vertex] = link;
        }
        f->weak[f->weak_count++] = e;
    }
}

static psplat_bend kind_of(follower *f, uint32_t edge) {
    if (f->kinds[edge] == PSPLAT_BEND_OPEN)
        f->kinds[edge] = (uint8_t)psplat_bend_judge_weak(f->surface, f->relief, edge,
                                                         f->crease_angle, f->weak_angle);
    return (psplat_bend)f->kinds[edge];
}

static void continue_at(follower *f, uint32_t edge, uint32_t end) {
    const psplat_mesh *mesh = f->surface->mesh;
    double away[3], onward[3];
    direction_from(mesh, edge, end, away);
    uint32_t link = f->first[end_of(mesh, edge, end)];
    for (; link != PSPLAT_NONE; link = f->next[link]) {
        uint32_t weak = f->weak[link / 2];
        if (f->surface->creases[weak]) continue;
        psplat_bend kind = kind_of(f, weak);
        direction_from(mesh, weak, link % 2, onward);
        int onwards = -dot3(away, onward) >= straight;
        if (kind == PSPLAT_BEND_SMOOTH || (kind == PSPLAT_BEND_FAINT && !onwards)) continue;
        psplat_crease_set(f->surface, weak, 1);
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
        for (uint32_t end = 0; end < 2; ++end) continue_at(f, f->queue[at], end);
}

psplat_result psplat_crease_follow(psplat_surface *surface, const psplat_relief *relief,
                                   double crease_angle, double weak_angle, uint8_t *kinds) {
    size_t edges = 3 * surface->mesh->triangle_count, weak = 0;
    for (size_t e = 0; e < edges; ++e) weak += may_be_weak(kinds[e]);
    follower f = {.surface = surface,
                  .relief = relief,
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
