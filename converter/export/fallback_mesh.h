/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fallback_mesh.h - the fallback mesh: a simplified mesh that viewers show which do not know splats
 * (spec 6.1).
 */
#ifndef PHONGSPLAT_EXPORT_FALLBACK_MESH_H
#define PHONGSPLAT_EXPORT_FALLBACK_MESH_H

#include "mesh/mesh.h"
#include "select/conversion.h"

#include <phongsplat/splat.h>

typedef struct psplat_fallback_vertex {
    float position[3]; /* relative to the mesh's origin */
    float normal[3];   /* unit */
    float color[4];    /* linear RGBA, multiplies the material's base colour */
    uint32_t group;    /* of the mesh's groups (materials) */
    float texcoord[2]; /* 0 where the material keeps no texture */
} psplat_fallback_vertex;

/* The triangles of one group, which become a glTF primitive. */
typedef struct psplat_fallback_primitive {
    uint32_t group;
    size_t first, count;      /* range of indices */
    psplat_material material; /* of the group; factors times the means of textures that are baked */
    int has_texcoord;         /* the material keeps textures */
} psplat_fallback_primitive;

/* A zero-initialised struct has no triangles. */
typedef struct psplat_fallback_mesh {
    psplat_fallback_vertex *vertices; /* in the order of their first use */
    uint32_t *indices;
    psplat_fallback_primitive *primitives; /* in ascending order of groups */
    size_t vertex_count, index_count, primitive_count;
    double origin[3]; /* of the mesh; positions are relative to it */
    int has_color;    /* 0 if color is 1 1 1 1 in every vertex */
    int has_texcoord; /* of some primitive */
} psplat_fallback_mesh;

/* Simplifies the mesh as far as its triangles stay within desc's tolerance, by the estimate of the
 * simplifier (quadric error metrics: Garland and Heckbert 1997). Edges along creases, borders and
 * where groups, colours or texture coordinates meet are kept, and vertices are not moved. Normals
 * are those of the conversion, colours those of the mesh with textures that are baked. The caller
 * frees *fallback with psplat_fallback_mesh_free. Errors: MEMORY, RANGE, INTERRUPTED. */
psplat_result psplat_fallback_mesh_make(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                        psplat_fallback_mesh *fallback, psplat_error *error);
/* The same with all triangles of the mesh: what a page shows as the source. */
psplat_result psplat_whole_mesh_make(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                     psplat_fallback_mesh *whole, psplat_error *error);
void psplat_fallback_mesh_free(psplat_fallback_mesh *fallback);

#endif
