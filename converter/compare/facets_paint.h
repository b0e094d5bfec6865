/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * facets_paint.h - the materials of a mesh on the GPU: factors, and textures as they are.
 */
#ifndef PHONGSPLAT_FACETS_PAINT_H
#define PHONGSPLAT_FACETS_PAINT_H

#include "facets_gl.h"
#include "vertices.h"

#define PSPLAT_WALL_TEXTURES 5

/* The triangles of one group, and what they look like. */
typedef struct psplat_wall {
    size_t first_index;
    GLsizei index_count;
    psplat_material material;
    /* Base colour, metallic-roughness, normal, occlusion, emissive: */
    GLuint textures[PSPLAT_WALL_TEXTURES];          /* 0: none */
    GLint sets[PSPLAT_WALL_TEXTURES];               /* of texture coordinates; -1: no texture */
    GLfloat transforms[PSPLAT_WALL_TEXTURES][2][3]; /* rows of (s, t, 1) */
    GLfloat strengths[3];                           /* of the normal's and the occlusion's */
} psplat_wall;

/* One wall for each range of the vertices. Where it fails, destroy what there is. Errors: MEMORY,
 * GRAPHICS. */
psplat_result psplat_walls_create(const psplat_facets_gl *gl, const psplat_mesh *mesh,
                                  const psplat_vertices *vertices, psplat_wall **walls,
                                  size_t *count, psplat_error *error);
void psplat_walls_destroy(const psplat_facets_gl *gl, psplat_wall *walls, size_t count);
/* Sets the program's uniforms and texture units; and leaves all units without a texture. */
void psplat_wall_bind(const psplat_facets_gl *gl, const psplat_wall *wall, GLuint program);
void psplat_wall_unbind(const psplat_facets_gl *gl);

#endif
