/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vertices.h - a mesh's corners as GL takes them: equal ones of a vertex are one.
 */
#ifndef PHONGSPLAT_VERTICES_H
#define PHONGSPLAT_VERTICES_H

#include "compare.h"

/* Triangles of one group of the mesh. */
typedef struct psplat_range {
    size_t first, count; /* indices */
    uint32_t group;
} psplat_range;

typedef struct psplat_vertices {
    float *values; /* count x floats: position relative to the mesh's origin, normal, linear colour
                      (where the mesh has any), two pairs of texture coordinates (the same) */
    size_t floats;
    int has_color, has_texcoords;
    size_t count;
    uint32_t *indices; /* index_count, three a triangle, by groups */
    size_t index_count;
    psplat_range *ranges; /* range_count */
    size_t range_count;
} psplat_vertices;

/* Errors: MEMORY. */
psplat_result psplat_vertices_unite(const psplat_original *original, psplat_vertices *vertices,
                                    psplat_error *error);
void psplat_vertices_free(psplat_vertices *vertices);

#endif
