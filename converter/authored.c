/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * authored.c - what the normals of the file say about creases.
 *
 * An edge whose corner normals differ across it, at either end, is hard: a crease, however little
 * it bends. One whose normals agree at both ends was meant to be smooth. It becomes a crease only
 * where it bends by twice the crease angle (psplat_crease_find): a splat that bent around such an
 * edge would leave the surface. The file's normals stay continuous across that crease all the same,
 * so that a box with smooth normals keeps its shape and its shading.
 *
 * Some normals are not to be trusted. A normal that points to the back of its triangle is no
 * opinion. A component (triangles connected over edges) of which half of the corners have none, or
 * whose normals change along more edges than a person would choose, was exported with one normal
 * for each triangle, or with garbage: its normals are left alone, and geometry decides. A box with
 * flat faces passes, and would be cut the same way by its angles.
 */
#include "stages.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

/* Cosine of the difference that makes an edge hard, 5 degrees: what quantised or recomputed normals
 * of one vertex differ by is less. */
static const double same = 0.9962;
/* The same for normals that are equal but for rounding, 0.25 degrees. */
static const double equal = 0.99999;
/* Patches that a component may have in any case, and triangles for each further one. */
enum { FEW_PATCHES = 64, TRIANGLES_PER_PATCH = 8 };

typedef struct reader {
    const psplat_surface *surface;
    uint8_t *authored; /* of edges, and of corners: the result */
    uint8_t *reached;  /* of triangles: by how many floods */
    uint32_t *members; /* of one component */
    uint32_t *patch;   /* of one patch */
} reader;

static const float *normal_of(const psplat_surface *surface, uint32_t corner) {
    return surface->mesh->corner_normals + 3 * (size_t)corner;
}

static int is_trusted(const psplat_surface *surface, uint32_t corner) {
    const float *n = normal_of(surface, corner);
    double own[3] = {(double)n[0], (double)n[1], (double)n[2]};
    return dot3(own, surface->face_normals + 3 * (size_t)(corner / 3)) > 0;
}

/* Whether the normals of two corners differ by less than an angle of this cosine; -1: unknown. */
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

/* Of the two ends of an edge that has a neighbour, in how many the normals across it are unknown,
 * differ, agree. */
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
    compare_ends(surface, edge, same, counts);
    if (counts[1]) return counts[1] == 2 ? PSPLAT_AUTHORED_HARD : PSPLAT_AUTHORED_FADING;
    return counts[2] == 2 ? PSPLAT_AUTHORED_SMOOTH : 0;
}

/* Whether the normals differ at all along an edge. */
static int is_cut(const psplat_surface *surface, uint32_t edge) {
    int counts[3];
    compare_ends(surface, edge, equal, counts);
    return counts[1] == 2;
}

/* Lists the triangles connected with seed that `floods` floods have reached; whole: across cuts
 * too. */
static size_t flood(reader *r, uint32_t seed, uint8_t floods, int whole, uint32_t *list) {
    size_t count = 0;
    list[count++] = seed;
    r->reached[seed] = (uint8_t)(floods + 1);
    for (size_t at = 0; at < count; ++at)
        for (uint32_t e = 3 * list[at]; e < 3 * list[at] + 3; ++e) {
            uint32_t next = r->surface->neighbors[e];
            if (next == PSPLAT_NONE || r->reached[next] != floods) continue;
            if (!whole && is_cut(r->surface, e)) continue;
            r->reached[next] = (uint8_t)(floods + 1);
            list[count++] = next;
        }
    return count;
}

static int is_credible(reader *r, size_t count) {
    size_t trusted = 0, patches = 0;
    for (size_t i = 0; i < count; ++i) {
        for (uint32_t c = 3 * r->members[i]; c < 3 * r->members[i] + 3; ++c)
            trusted += (r->authored[c] & PSPLAT_AUTHORED_NORMAL) != 0;
        if (r->reached[r->members[i]] != 1) continue;
        flood(r, r->members[i], 1, 0, r->patch);
        ++patches;
    }
    int many = patches > FEW_PATCHES && patches * TRIANGLES_PER_PATCH > count;
    return 2 * trusted >= 3 * count && !many;
}

static void read_all(reader *r) {
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
    reader r = {.surface = surface,
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
