/* SPDX-License-Identifier: MIT
 *
 * engine_mesh.h - the engine's own lit triangles: surfaces of revolution about +y.
 */
#ifndef ENGINE_MESH_H
#define ENGINE_MESH_H

#include "engine_gl.h"
#include "engine_matrix.h"

/* The shader that all meshes share. */
typedef struct paint {
    GLuint program;
    GLint clip, color, light, sun, ambient;
} paint;

typedef struct mesh {
    GLuint array;
    GLsizei vertex_count;
} mesh;

int paint_make(paint *p, const engine_gl *gl); /* returns 0 where the compiler refuses */

/* Turns an outline of (radius, height) points about +y. Each piece of the outline is flat and its
 * ends are sharp edges. The outside lies to the right of the way along the outline. */
mesh mesh_lathe(const engine_gl *gl, const float (*outline)[2], int points);

/* Draws the mesh with the paint's program, which must be current. */
void mesh_draw(const mesh *m, const engine_gl *gl, const paint *p, const matrix *clip,
               const float color[3]);

#endif
