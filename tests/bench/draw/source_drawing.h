/* SPDX-License-Identifier: MIT
 *
 * source_drawing.h - the mesh that a model was made from, drawn as indexed triangles and lit per
 * pixel. It is built only together with the converter.
 */
#ifndef PHONGSPLAT_BENCH_SOURCE_DRAWING_H
#define PHONGSPLAT_BENCH_SOURCE_DRAWING_H

#include "draw_method.h"

#include "compare/source_mesh.h"
#include "compare/source_mesh_parts.h"
#include "mesh/mesh.h"

typedef struct mesh {
    psplat_mesh source;
    psplat_source_mesh *original; /* made from source, which must not move */
    double center[3], radius;     /* of a sphere around it, in scene space */
} mesh;

/* Reads any file that the converter takes, with the normals that the converter would give it. Ends
 * the program with a message where that fails. */
void mesh_read(const char *path, mesh *m);
/* Reads a file that has lost the materials of another, whose only one it gets. Ends the program
 * where that has several. */
void mesh_read_like(const char *path, const mesh *other, mesh *m);
void mesh_free(mesh *m);

/* Returns the draw method. Sides and lights follow the view and the material; the mode is always
 * phong and lit. */
draw_method draw_method_mesh(psplat_host *host, const mesh *m);

#endif
