/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * vertices.h - a mesh's corners as GL takes them: equal ones of a vertex are one.
 */
#ifndef PHONGSPLAT_VERTICES_H
#define PHONGSPLAT_VERTICES_H

#include "compare.h"

typedef struct psplat_vertices {
    float *values; /* count x floats: position relative to the mesh's origin, normal, and, where
                      the mesh has any, linear colour */
    size_t floats; /* 6, or 9 with colours */
    size_t count;
    uint32_t *indices; /* index_count, three a triangle */
    size_t index_count;
} psplat_vertices;

/* Errors: MEMORY. */
psplat_result psplat_vertices_unite(const psplat_original *original, psplat_vertices *vertices,
                                    psplat_error *error);
void psplat_vertices_free(psplat_vertices *vertices);

#endif
