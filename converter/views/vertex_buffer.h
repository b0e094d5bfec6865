/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vertex_buffer.h - the vertex and index buffer of a mesh for GL: equal corners of a vertex are
 * merged.
 */
#ifndef PHONGSPLAT_VIEWS_VERTEX_BUFFER_H
#define PHONGSPLAT_VIEWS_VERTEX_BUFFER_H

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"

#include <phongsplat/splat.h>

/* The triangles of one group of the mesh. */
typedef struct psplat_group_range {
    size_t first, count; /* of indices */
    uint32_t group;
} psplat_group_range;

typedef struct psplat_vertex_buffer {
    float *values; /* count x floats: position relative to the mesh's origin, normal; linear colour
                      if has_color; two pairs of texture coordinates if has_texcoords */
    size_t floats; /* of a vertex */
    int has_color, has_texcoords;
    size_t count;
    uint32_t *indices; /* index_count, three for a triangle, sorted by groups */
    size_t index_count;
    psplat_group_range *ranges; /* range_count */
    size_t range_count;
} psplat_vertex_buffer;

/* Merges corners where vertex, normal, colour and texture coordinates are equal. The caller frees
 * *vertices with psplat_vertex_buffer_free. Errors: MEMORY. */
psplat_result psplat_vertex_buffer_unite(const psplat_source_mesh *source,
                                         psplat_vertex_buffer *vertices, psplat_error *error);
void psplat_vertex_buffer_free(psplat_vertex_buffer *vertices);

#endif
