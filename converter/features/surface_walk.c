/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_walk.c - straight walks over a surface from triangle to triangle.
 */
#include "features/surface_walk.h"

#include "base/vector.h"
#include "features/surface.h"
#include "mesh/edges.h"
#include "mesh/mesh.h"

#include <math.h>
#include <string.h>

uint32_t psplat_surface_edge_across(const psplat_surface *surface, uint32_t edge) {
    uint32_t begin = psplat_edge_vertex(surface->mesh, edge, 0);
    uint32_t end = psplat_edge_vertex(surface->mesh, edge, 1), first = 3 * surface->neighbors[edge];
    for (uint32_t e = first; e < first + 2; ++e)
        if (psplat_edge_vertex(surface->mesh, e, 0) == end &&
            psplat_edge_vertex(surface->mesh, e, 1) == begin)
            return e;
    return first + 2;
}

static const double *edge_begin(const psplat_surface *surface, uint32_t edge) {
    return psplat_mesh_corner(surface->mesh, edge / 3, (int)(edge % 3));
}

static const double *face_normal(const psplat_surface *surface, uint32_t triangle) {
    return surface->face_normals + 3 * (size_t)triangle;
}

psplat_surface_walk psplat_surface_walk_begin(const psplat_surface *surface, uint32_t edge) {
    psplat_surface_walk w = {.surface = surface, .triangle = edge / 3, .entry = edge};
    double along[3];
    psplat_edge_vector(surface->mesh, edge, along);
    along3(w.at, edge_begin(surface, edge), 0.5, along);
    cross3(w.ahead, face_normal(surface, w.triangle), along);
    normalize3(w.ahead);
    return w;
}

double psplat_surface_walk_exit(const psplat_surface_walk *w, uint32_t *exit) {
    double least = HUGE_VAL;
    *exit = PSPLAT_NONE;
    for (uint32_t e = 3 * w->triangle; e < 3 * w->triangle + 3; ++e) {
        double along[3], inward[3], from[3];
        if (e == w->entry) continue;
        psplat_edge_vector(w->surface->mesh, e, along);
        cross3(inward, face_normal(w->surface, w->triangle), along);
        sub3(from, w->at, edge_begin(w->surface, e));
        double approach = -dot3(w->ahead, inward);
        if (!(approach > 0)) continue;
        double distance = max2(dot3(from, inward) / approach, 0);
        if (distance < least) least = distance, *exit = e;
    }
    return *exit == PSPLAT_NONE ? 0 : least;
}

/* Turns the direction about an edge from its triangle into the one across. */
static void turn_over(psplat_surface_walk *w, uint32_t edge) {
    double along[3], out[3], into[3], ahead[3] = {0, 0, 0};
    psplat_edge_vector(w->surface->mesh, edge, along);
    normalize3(along);
    cross3(out, along, face_normal(w->surface, w->triangle));
    cross3(into, along, face_normal(w->surface, w->surface->neighbors[edge]));
    mad3(ahead, dot3(w->ahead, along), along);
    mad3(ahead, dot3(w->ahead, out), into);
    normalize3(ahead);
    memcpy(w->ahead, ahead, sizeof ahead);
}

int psplat_surface_walk_on(psplat_surface_walk *w) {
    uint32_t exit;
    double distance = psplat_surface_walk_exit(w, &exit);
    if (exit == PSPLAT_NONE) return 0;
    w->length += distance;
    mad3(w->at, distance, w->ahead);
    if (w->surface->neighbors[exit] == PSPLAT_NONE ||
        (w->surface->creases[exit] & PSPLAT_BOUND_CREASE))
        return 0;
    turn_over(w, exit);
    w->entry = psplat_surface_edge_across(w->surface, exit);
    w->triangle = w->entry / 3;
    return 1;
}
