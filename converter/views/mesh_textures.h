/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh_textures.h - the materials and textures of a mesh on the GPU.
 */
#ifndef PHONGSPLAT_VIEWS_MESH_TEXTURES_H
#define PHONGSPLAT_VIEWS_MESH_TEXTURES_H

#include "mesh/mesh.h"
#include "views/mesh_programs.h"
#include "views/vertex_buffer.h"

#include <phongsplat/splat.h>

#define PSPLAT_MATERIAL_TEXTURES 5

/* The triangles of one group with their material, drawn by one call. */
typedef struct psplat_drawn_group {
    size_t first_index;
    GLsizei index_count;
    psplat_material material;
    /* The order of textures is base colour, metallic-roughness, normal, occlusion, emissive. */
    GLuint textures[PSPLAT_MATERIAL_TEXTURES];          /* 0 where there is none */
    GLint sets[PSPLAT_MATERIAL_TEXTURES];               /* of coordinates; -1 without a texture */
    GLfloat transforms[PSPLAT_MATERIAL_TEXTURES][2][3]; /* 2 x 3 matrices of (s, t, 1), by rows */
    GLfloat strengths[3]; /* of the normal and the occlusion texture */
} psplat_drawn_group;

/* Creates a group for each range of the vertices and uploads its textures. The caller frees *groups
 * with psplat_drawn_groups_destroy, also after an error. Errors: MEMORY, GRAPHICS. */
psplat_result psplat_drawn_groups_create(const psplat_mesh_programs *gl, const psplat_mesh *mesh,
                                         const psplat_vertex_buffer *vertices,
                                         psplat_drawn_group **groups, size_t *count,
                                         psplat_error *error);
void psplat_drawn_groups_destroy(const psplat_mesh_programs *gl, psplat_drawn_group *groups,
                                 size_t count);
/* Sets the material's uniforms in the program, and binds the textures. */
void psplat_drawn_group_bind(const psplat_mesh_programs *gl, const psplat_drawn_group *group,
                             GLuint program);
/* Unbinds the textures of all units. */
void psplat_drawn_group_unbind(const psplat_mesh_programs *gl);

#endif
