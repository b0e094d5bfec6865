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

static void fill(const psplat_original *original, size_t corner, const psplat_vertices *vertices,
                 float *values) {
    const psplat_mesh *mesh = original->mesh;
    const double *position = mesh->positions + 3 * (size_t)mesh->triangles[corner];
    const float *normal = original->surface.corner_normals + 3 * corner;
    float *next = values + 6;
    for (size_t k = 0; k < 3; ++k) values[k] = (float)position[k];
    for (size_t k = 0; k < 3; ++k) values[3 + k] = normal[k];
    for (size_t k = 0; k < 3 && vertices->has_color; ++k)
        *next++ = mesh->corner_colors[4 * corner + k];
    for (size_t k = 0; k < 4 && vertices->has_texcoords; ++k) {
        const float *uvs = mesh->corner_uvs[k / 2];
        *next++ = uvs ? uvs[2 * corner + k % 2] : 0;
    }
}

/* The vertex for a corner, made where there is none like it yet. */
static uint32_t take(const psplat_original *original, size_t corner, chains *c,
                     psplat_vertices *vertices) {
    uint32_t *link = &c->first[original->mesh->triangles[corner]];
    float *made = vertices->values + vertices->count * vertices->floats;
    size_t size = vertices->floats * sizeof *made;
    fill(original, corner, vertices, made);
    while (*link != PSPLAT_NONE) {
        if (!memcmp(vertices->values + (size_t)*link * vertices->floats, made, size)) return *link;
        link = &c->next[*link];
    }
    c->next[vertices->count] = PSPLAT_NONE;
    return *link = (uint32_t)vertices->count++;
}

static uint32_t group_of(const psplat_mesh *mesh, size_t triangle) {
    return mesh->groups && mesh->groups[triangle] < mesh->appearance_count ? mesh->groups[triangle]
                                                                           : 0;
}

/* Ranges of the groups that have triangles, in order; their counts stay 0. */
static void find_ranges(const psplat_mesh *mesh, psplat_vertices *vertices, size_t *starts) {
    size_t groups = mesh->appearance_count ? mesh->appearance_count : 1, at = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) starts[group_of(mesh, t)] += 3;
    for (uint32_t g = 0; g < groups; ++g) {
        size_t count = starts[g];
        starts[g] = at;
        if (count) vertices->ranges[vertices->range_count++] = (psplat_range){at, count, g};
        at += count;
    }
}

static int allocate(const psplat_mesh *mesh, psplat_vertices *vertices, chains *c,
                    size_t **starts) {
    size_t corners = 3 * mesh->triangle_count;
    size_t groups = mesh->appearance_count ? mesh->appearance_count : 1;
    *vertices = (psplat_vertices){.has_color = mesh->corner_colors != NULL,
                                  .has_texcoords = mesh->corner_uvs[0] || mesh->corner_uvs[1],
                                  .index_count = corners};
    vertices->floats = 6 + (vertices->has_color ? 3u : 0u) + (vertices->has_texcoords ? 4u : 0u);
    vertices->values = malloc(corners * vertices->floats * sizeof *vertices->values);
    vertices->indices = malloc(corners * sizeof *vertices->indices);
    vertices->ranges = malloc(groups * sizeof *vertices->ranges);
    *starts = calloc(groups, sizeof **starts);
    *c = (chains){malloc(mesh->vertex_count * sizeof *c->first), malloc(corners * sizeof *c->next)};
    return c->first && c->next && vertices->values && vertices->indices && vertices->ranges &&
           *starts;
}

psplat_result psplat_vertices_unite(const psplat_original *original, psplat_vertices *vertices,
                                    psplat_error *error) {
    const psplat_mesh *mesh = original->mesh;
    chains c;
    size_t *starts;
    int allocated = allocate(mesh, vertices, &c, &starts);
    if (allocated) {
        memset(c.first, 0xff, mesh->vertex_count * sizeof *c.first); /* PSPLAT_NONE */
        find_ranges(mesh, vertices, starts);
        for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
            vertices->indices[starts[group_of(mesh, i / 3)]++] = take(original, i, &c, vertices);
    }
    free(c.first);
    free(c.next);
    free(starts);
    if (allocated) return PSPLAT_OK;
    psplat_vertices_free(vertices);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to draw %zu triangles",
                       mesh->triangle_count);
}

void psplat_vertices_free(psplat_vertices *vertices) {
    free(vertices->values);
    free(vertices->indices);
    free(vertices->ranges);
    *vertices = (psplat_vertices){0};
}
