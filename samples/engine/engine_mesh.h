/* SPDX-License-Identifier: MIT
 *
 * engine_mesh.h - the engine's own triangles: surfaces of revolution about +y, in world space.
 */
#ifndef ENGINE_MESH_H
#define ENGINE_MESH_H

#include "engine_gl.h"
#include "engine_matrix.h"

/* A shader for meshes. */
typedef struct paint {
    GLuint program;
    GLint clip, color;
} paint;

typedef struct mesh {
    GLuint array;
    GLsizei vertex_count;
} mesh;

/* Compiles and links; returns 0 where the compiler refuses. */
GLuint program_make(const engine_gl *gl, const char *vertex, const char *fragment);

/* Makes a paint of a fragment shader, which gets the normal `n` and the place `at` of its point in
 * world space and the uniform `color`. Returns 0 where the compiler refuses. */
int paint_make(paint *p, const engine_gl *gl, const char *fragment);

/* Makes the paint's program current. clip leads from world to clip space. */
void paint_use(const paint *p, const engine_gl *gl, const matrix *clip);

/* Turns an outline of (radius, height) points about +y. Each piece of the outline is flat and its
 * ends are sharp edges. The outside lies to the right of the way along the outline. */
mesh mesh_lathe(const engine_gl *gl, const float (*outline)[2], int points);

/* Draws the mesh with the paint, which must be in use. */
void mesh_draw(const mesh *m, const engine_gl *gl, const paint *p, const float color[3]);

#endif
