/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vertex_buffer.c - the vertex and index buffer of a mesh for GL. Corners with equal attributes
 * share a vertex, so that a smooth mesh has one vertex where six triangles meet, and two at a
 * crease.
 */
#include "views/vertex_buffer.h"

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

/* The vertices made so far for each vertex of the mesh, as linked lists. */
typedef struct chains {
    uint32_t *first; /* for each vertex of the mesh, or PSPLAT_NONE */
    uint32_t *next;  /* after each vertex that was made, or PSPLAT_NONE */
} chains;

static void fill(const psplat_source_mesh *source, size_t corner,
                 const psplat_vertex_buffer *vertices, float *values) {
    const psplat_mesh *mesh = source->mesh;
    const double *position = mesh->positions + 3 * (size_t)mesh->triangles[corner];
    const float *normal = source->surface.corner_normals + 3 * corner;
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

/* Returns the vertex for a corner, which is made if there is no equal one yet. */
static uint32_t find_or_add(const psplat_source_mesh *source, size_t corner, chains *c,
                            psplat_vertex_buffer *vertices) {
    uint32_t *link = &c->first[source->mesh->triangles[corner]];
    float *made = vertices->values + vertices->count * vertices->floats;
    size_t size = vertices->floats * sizeof *made;
    fill(source, corner, vertices, made);
    while (*link != PSPLAT_NONE) {
        if (!memcmp(vertices->values + (size_t)*link * vertices->floats, made, size)) return *link;
        link = &c->next[*link];
    }
    c->next[vertices->count] = PSPLAT_NONE;
    return *link = (uint32_t)vertices->count++;
}

static uint32_t group_of(const psplat_mesh *mesh, size_t triangle) {
    return mesh->groups && mesh->groups[triangle] < mesh->source_material_count
               ? mesh->groups[triangle]
               : 0;
}

/* Makes the ranges of the groups that have triangles, in order. starts, zeros before, gets the
 * first index of each group. */
static void find_ranges(const psplat_mesh *mesh, psplat_vertex_buffer *vertices, size_t *starts) {
    size_t groups = mesh->source_material_count ? mesh->source_material_count : 1, at = 0;
    for (size_t t = 0; t < mesh->triangle_count; ++t) starts[group_of(mesh, t)] += 3;
    for (uint32_t g = 0; g < groups; ++g) {
        size_t count = starts[g];
        starts[g] = at;
        if (count) vertices->ranges[vertices->range_count++] = (psplat_group_range){at, count, g};
        at += count;
    }
}

static int allocate(const psplat_mesh *mesh, psplat_vertex_buffer *vertices, chains *c,
                    size_t **starts) {
    size_t corners = 3 * mesh->triangle_count;
    size_t groups = mesh->source_material_count ? mesh->source_material_count : 1;
    *vertices = (psplat_vertex_buffer){.has_color = mesh->corner_colors != NULL,
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

psplat_result psplat_vertex_buffer_unite(const psplat_source_mesh *source,
                                         psplat_vertex_buffer *vertices, psplat_error *error) {
    const psplat_mesh *mesh = source->mesh;
    chains c;
    size_t *starts;
    int allocated = allocate(mesh, vertices, &c, &starts);
    if (allocated) {
        memset(c.first, 0xff, mesh->vertex_count * sizeof *c.first); /* PSPLAT_NONE */
        find_ranges(mesh, vertices, starts);
        for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
            vertices->indices[starts[group_of(mesh, i / 3)]++] =
                find_or_add(source, i, &c, vertices);
    }
    free(c.first);
    free(c.next);
    free(starts);
    if (allocated) return PSPLAT_OK;
    psplat_vertex_buffer_free(vertices);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to draw %zu triangles",
                       mesh->triangle_count);
}

void psplat_vertex_buffer_free(psplat_vertex_buffer *vertices) {
    free(vertices->values);
    free(vertices->indices);
    free(vertices->ranges);
    *vertices = (psplat_vertex_buffer){0};
}
