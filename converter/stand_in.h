/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stand_in.h - a coarse mesh for viewers that know no splats (spec 6.1).
 */
#ifndef PHONGSPLAT_STAND_IN_H
#define PHONGSPLAT_STAND_IN_H

#include "converter.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct psplat_stand_in_vertex {
    float position[3]; /* relative to the mesh's origin */
    float normal[3];   /* unit */
    float color[4];    /* linear RGBA, multiplies the material's base colour */
    uint32_t group;    /* of the mesh's groups */
} psplat_stand_in_vertex;

/* Triangles of one group. */
typedef struct psplat_stand_in_part {
    uint32_t group;
    size_t first, count;      /* of indices */
    psplat_material material; /* of the group, its factors times the means of what varies */
} psplat_stand_in_part;

/* Zero-initialised: none. */
typedef struct psplat_stand_in {
    psplat_stand_in_vertex *vertices; /* in the order in which indices name them first */
    uint32_t *indices;
    psplat_stand_in_part *parts; /* in ascending order of groups */
    size_t vertex_count, index_count, part_count;
    double origin[3]; /* of the mesh */
    int has_color;    /* 0: color is 1 1 1 1 in every vertex */
} psplat_stand_in;

/* Simplifies the mesh as far as its triangles stay within desc's tolerance, by the simplifier's
 * estimate (quadrics: Garland and Heckbert 1997). Creases, borders, and where groups or colours
 * meet keep their edges, vertices keep their places, normals are those that conversions work with,
 * colours those of the mesh with its textures. Errors: MEMORY, RANGE, INTERRUPTED. */
psplat_result psplat_stand_in_make(const psplat_mesh *mesh, const psplat_convert_desc *desc,
                                   psplat_stand_in *stand_in, psplat_error *error);
void psplat_stand_in_free(psplat_stand_in *stand_in);

#ifdef __cplusplus
}
#endif
#endif
