/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh.h - triangle meshes, with attributes on the corners of triangles.
 */
#ifndef PHONGSPLAT_MESH_MESH_H
#define PHONGSPLAT_MESH_MESH_H

#include <phongsplat/splat.h>

#include "material/source_materials.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The index of no triangle, edge or vertex. */
#define PSPLAT_NONE UINT32_MAX

/* A triangle mesh. Attributes belong to corners (3 per triangle), so that a hard edge or a colour
 * seam of the file survives welding. Positions are relative to origin, which is subtracted in
 * double. Optional arrays are NULL if the file has none. */
typedef struct psplat_mesh {
    double *positions;     /* vertex_count x 3 */
    uint32_t *triangles;   /* triangle_count x 3 vertex indices */
    float *corner_normals; /* triangle_count x 3 x 3 unit normals, 0 0 0 where a corner has none */
    float *corner_colors;  /* triangle_count x 3 x 4 linear RGBA; NULL if uniform */
    uint32_t *groups;      /* triangle_count ids: indices of source_materials if there are any.
                            * Edges between groups are creases */
    float *corner_uvs[PSPLAT_TEXCOORDS]; /* triangle_count x 3 x 2 texture coordinates */
    float *corner_tangents;              /* triangle_count x 3 x 4 (glTF 2.0 section 3.7.2.1) */
    size_t vertex_count;
    size_t triangle_count;
    double origin[3];
    psplat_material material; /* factors common to all triangles */
    /* The materials of groups, owned by the scene or by materials; NULL if all have material. */
    const psplat_source_material *source_materials;
    size_t source_material_count;
    psplat_source_materials *materials; /* set by psplat_mesh_read, which has no scene; or NULL */
    size_t dropped;                     /* triangles dropped as degenerate or repeated */
    /* 1 for each group (without groups for 0) of which some triangles existed twice, facing both
     * ways: always double-sided. NULL if there are none. */
    uint8_t *both_sides;
    size_t both_sides_count;
    int holds_parts; /* set before cleaning: other meshes of the scene lie in its box */
    /* What cleaning did about closed shells that face inwards (mesh/shells.h). */
    size_t turned_shells, turned_triangles, kept_rooms;
    /* A point set keeps all its points here, and for each a triangle that it lies on or beside. Its
     * triangles say which points are neighbours and where the set has holes and borders. Distances
     * are measured to the points as well. NULL for a mesh. */
    double *points;            /* point_count x 3 */
    uint32_t *point_triangles; /* point_count */
    size_t point_count;
} psplat_mesh;

/* Frees what the mesh holds and makes it zero. */
void psplat_mesh_free(psplat_mesh *mesh);

/* Returns whether a group, or a mesh without groups as group 0, shows both its sides whatever its
 * material says. */
int psplat_mesh_shows_both_sides(const psplat_mesh *mesh, size_t group);

/* Returns the index of a triangle's source material, 0 where all triangles have one material. */
static inline uint32_t psplat_mesh_material_of(const psplat_mesh *mesh, size_t triangle) {
    return mesh->source_materials && mesh->groups ? mesh->groups[triangle] : 0;
}

/* The most triangles and vertices that are read, so that their numbers fit into 32 bits. */
#define PSPLAT_MAX_TRIANGLES 0x3fffffffu
#define PSPLAT_MAX_VERTICES 0x7ffffffeu

/* The optional arrays of a mesh, as parts of psplat_mesh_allocate. */
#define PSPLAT_MESH_NORMALS 1u
#define PSPLAT_MESH_COLORS 2u
#define PSPLAT_MESH_GROUPS 4u
#define PSPLAT_MESH_TANGENTS 8u
#define PSPLAT_MESH_UVS 16u /* shifted left by the number of the set */

/* Allocates the arrays of a mesh, zeroed. parts is the bitwise or of the optional ones. Errors:
 * PSPLAT_ERROR_RANGE, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_allocate(psplat_mesh *mesh, size_t vertex_count, size_t triangle_count,
                                   unsigned parts, psplat_error *error);

/* The most arrays of corners that a mesh has. */
#define PSPLAT_CORNER_ARRAYS (3 + PSPLAT_TEXCOORDS)

/* One array over corners, whatever it holds. Code that moves corners moves all these arrays. */
typedef struct psplat_corners {
    float *values;
    size_t components; /* of each corner */
} psplat_corners;

/* Lists the corner arrays that the mesh has, always in the same order. Returns their number. */
size_t psplat_mesh_corners(const psplat_mesh *mesh, psplat_corners arrays[PSPLAT_CORNER_ARRAYS]);

/* Returns the position (3 numbers) of a corner 0 ... 2 of a triangle. */
const double *psplat_mesh_corner(const psplat_mesh *mesh, uint32_t triangle, int corner);

#ifdef __cplusplus
}
#endif
#endif
