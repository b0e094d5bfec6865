/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * authored_normals.c - creases and smooth edges that the file's normals define.
 *
 * An edge whose corner normals differ across it at both ends is hard: a crease, however small its
 * dihedral angle. If they differ at one end only, the edge may continue a crease (crease_follow.c).
 * If they agree at both ends, the edge was meant to be smooth. It is a crease only if its angle is
 * twice the crease angle (crease.c), since a splat across such an edge would leave the surface. The
 * file's normals stay continuous across that crease all the same, so that a box with smooth normals
 * keeps its shape and its shading.
 *
 * Some normals are not credible. A normal that points to the back of its triangle is ignored. All
 * normals of a component (triangles connected by edges) are ignored if less than half of its
 * corners have one, or if hard edges divide it into more patches than a person would choose. It was
 * exported with one normal for each triangle then, or with garbage, and geometry alone decides. A
 * box with flat faces passes this test, and its angles would divide it in the same way.
 */
#include "features/authored_normals.h"

#include "base/vector.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

/* Normals whose cosine is less than this, at 5 degrees, make an edge hard. Quantised or recomputed
 * normals of one vertex differ by less. */
static const double hard_edge_cosine = 0.9962;
/* Normals whose cosine is at least this, at 0.25 degrees, are equal up to rounding. */
static const double equal_normals_cosine = 0.99999;
/* A component may have MAX_FREE_PATCHES patches in any case. If it has more, it needs
 * MIN_PATCH_TRIANGLES triangles for each patch. Chosen by hand. */
enum { MAX_FREE_PATCHES = 64, MIN_PATCH_TRIANGLES = 8 };

typedef struct normal_reader {
    const psplat_surface *surface;
    uint8_t *authored; /* the result: flags of corners and edges */
    uint8_t *reached;  /* of each triangle: how many flood fills have reached it */
    uint32_t *members; /* of one component */
    uint32_t *patch;   /* of one patch */
} normal_reader;

static const float *normal_of(const psplat_surface *surface, uint32_t corner) {
    return surface->mesh->corner_normals + 3 * (size_t)corner;
}

/* Returns whether the normal of a corner points to the front of its triangle. */
static int is_trusted(const psplat_surface *surface, uint32_t corner) {
    const float *n = normal_of(surface, corner);
    double own[3] = {(double)n[0], (double)n[1], (double)n[2]};
    return dot3(own, surface->face_normals + 3 * (size_t)(corner / 3)) > 0;
}

/* Returns 1 if the cosine between the normals of two corners is at least cosine, 0 if not, and -1
 * if one of them is not to be trusted. */
static int agree(const psplat_surface *surface, uint32_t a, uint32_t b, double cosine) {
    if (!is_trusted(surface, a) || !is_trusted(surface, b)) return -1;
    const float *m = normal_of(surface, a), *n = normal_of(surface, b);
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += (double)m[k] * (double)n[k];
    return sum >= cosine;
}

static uint32_t corner_at(const psplat_mesh *mesh, uint32_t triangle, uint32_t vertex) {
    uint32_t corner = 3 * triangle;
    while (mesh->triangles[corner] != vertex) ++corner;
    return corner;
}

/* Counts at how many ends of an edge the normals of its two triangles are unknown (counts[0]),
 * differ (counts[1]) and agree (counts[2]). The edge must have a neighbour. */
static void compare_ends(const psplat_surface *surface, uint32_t edge, double cosine,
                         int counts[3]) {
    const psplat_mesh *mesh = surface->mesh;
    uint32_t ends[2] = {edge, edge % 3 == 2 ? edge - 2 : edge + 1};
    counts[0] = counts[1] = counts[2] = 0;
    for (int end = 0; end < 2; ++end) {
        uint32_t across = corner_at(mesh, surface->neighbors[edge], mesh->triangles[ends[end]]);
        ++counts[agree(surface, ends[end], across, cosine) + 1];
    }
}

static uint8_t read_edge(const psplat_surface *surface, uint32_t edge) {
    int counts[3];
    if (surface->neighbors[edge] == PSPLAT_NONE) return 0;
    compare_ends(surface, edge, hard_edge_cosine, counts);
    if (counts[1]) return counts[1] == 2 ? PSPLAT_AUTHORED_HARD : PSPLAT_AUTHORED_HALF_HARD;
    return counts[2] == 2 ? PSPLAT_AUTHORED_SMOOTH : 0;
}

/* Returns whether the normals of its two triangles differ at both ends of an edge. */
static int normals_differ(const psplat_surface *surface, uint32_t edge) {
    int counts[3];
    compare_ends(surface, edge, equal_normals_cosine, counts);
    return counts[1] == 2;
}

/* Lists the triangles connected with seed that exactly `floods` flood fills have reached, and
 * counts this one. Unless whole is set, it does not cross edges where normals differ. */
static size_t flood(normal_reader *r, uint32_t seed, uint8_t floods, int whole, uint32_t *list) {
    size_t count = 0;
    list[count++] = seed;
    r->reached[seed] = (uint8_t)(floods + 1);
    for (size_t at = 0; at < count; ++at)
        for (uint32_t e = 3 * list[at]; e < 3 * list[at] + 3; ++e) {
            uint32_t next = r->surface->neighbors[e];
            if (next == PSPLAT_NONE || r->reached[next] != floods) continue;
            if (!whole && normals_differ(r->surface, e)) continue;
            r->reached[next] = (uint8_t)(floods + 1);
            list[count++] = next;
        }
    return count;
}

/* Returns whether the normals of a component of count triangles are credible. */
static int is_credible(normal_reader *r, size_t count) {
    size_t trusted = 0, patches = 0;
    for (size_t i = 0; i < count; ++i) {
        for (uint32_t c = 3 * r->members[i]; c < 3 * r->members[i] + 3; ++c)
            trusted += (r->authored[c] & PSPLAT_AUTHORED_NORMAL) != 0;
        if (r->reached[r->members[i]] != 1) continue;
        flood(r, r->members[i], 1, 0, r->patch);
        ++patches;
    }
    int fragmented = patches > MAX_FREE_PATCHES && patches * MIN_PATCH_TRIANGLES > count;
    return 2 * trusted >= 3 * count && !fragmented;
}

static void read_all(normal_reader *r) {
    uint32_t count = (uint32_t)r->surface->mesh->triangle_count;
    for (uint32_t e = 0; e < 3 * count; ++e) {
        r->authored[e] = read_edge(r->surface, e);
        if (is_trusted(r->surface, e)) r->authored[e] |= PSPLAT_AUTHORED_NORMAL;
    }
    for (uint32_t t = 0; t < count; ++t) {
        if (r->reached[t]) continue;
        size_t members = flood(r, t, 0, 1, r->members);
        if (is_credible(r, members)) continue;
        for (size_t i = 0; i < members; ++i) memset(r->authored + 3 * (size_t)r->members[i], 0, 3);
    }
}

psplat_result psplat_authored_read(const psplat_surface *surface, uint8_t *authored) {
    size_t count = surface->mesh->triangle_count;
    memset(authored, 0, 3 * count);
    if (!surface->mesh->corner_normals) return PSPLAT_OK;
    normal_reader r = {.surface = surface,
                       .authored = authored,
                       .reached = calloc(count, 1),
                       .members = malloc(count * sizeof *r.members),
                       .patch = malloc(count * sizeof *r.patch)};
    int allocated = r.reached && r.members && r.patch;
    if (allocated) read_all(&r);
    free(r.reached);
    free(r.members);
    free(r.patch);
    return allocated ? PSPLAT_OK : PSPLAT_ERROR_MEMORY;
}
