/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vertices.c - corners of a mesh united where vertex, normal and colour are the same, so that a
 * smooth mesh costs one vertex where six triangles meet, and a crease keeps two.
 */
#include "vertices.h"
#include "original.h"

#include <stdlib.h>
#include <string.h>

/* Vertices made so far of each of the mesh's, as chains. */
typedef struct chains {
    uint32_t *first; /* of each vertex of the mesh, or PSPLAT_NONE */
    uint32_t *next;  /* of each vertex made, or PSPLAT_NONE */
} chains;

static void fill(const psplat_original *original, size_t corner, float *values) {
    const psplat_mesh *mesh = original->mesh;
    const double *position = mesh->positions + 3 * (size_t)mesh->triangles[corner];
    const float *normal = original->surface.corner_normals + 3 * corner;
    for (size_t k = 0; k < 3; ++k) {
        values[k] = (float)position[k];
        values[3 + k] = normal[k];
        if (mesh->corner_colors) values[6 + k] = mesh->corner_colors[4 * corner + k];
    }
}

/* The vertex for a corner, made where there is none like it yet. */
static uint32_t take(const psplat_original *original, size_t corner, chains *c,
                     psplat_vertices *vertices) {
    uint32_t *link = &c->first[original->mesh->triangles[corner]];
    float *made = vertices->values + vertices->count * vertices->floats;
    size_t size = vertices->floats * sizeof *made;
    fill(original, corner, made);
    while (*link != PSPLAT_NONE) {
        if (!memcmp(vertices->values + (size_t)*link * vertices->floats, made, size)) return *link;
        link = &c->next[*link];
    }
    c->next[vertices->count] = PSPLAT_NONE;
    return *link = (uint32_t)vertices->count++;
}

psplat_result psplat_vertices_unite(const psplat_original *original, psplat_vertices *vertices,
                                    psplat_error *error) {
    const psplat_mesh *mesh = original->mesh;
    size_t corners = 3 * mesh->triangle_count, floats = mesh->corner_colors ? 9 : 6;
    chains c = {malloc(mesh->vertex_count * sizeof *c.first), malloc(corners * sizeof *c.next)};
    *vertices = (psplat_vertices){
        .values = malloc(corners * floats * sizeof *vertices->values),
        .floats = floats,
        .indices = malloc(corners * sizeof *vertices->indices),
        .index_count = corners,
    };
    int allocated = c.first && c.next && vertices->values && vertices->indices;
    if (allocated) {
        memset(c.first, 0xff, mesh->vertex_count * sizeof *c.first); /* PSPLAT_NONE */
        for (size_t i = 0; i < corners; ++i) vertices->indices[i] = take(original, i, &c, vertices);
    }
    free(c.first);
    free(c.next);
    if (allocated) return PSPLAT_OK;
    psplat_vertices_free(vertices);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to draw %zu triangles",
                       mesh->triangle_count);
}

void psplat_vertices_free(psplat_vertices *vertices) {
    free(vertices->values);
    free(vertices->indices);
    *vertices = (psplat_vertices){0};
}
