/* SPDX-License-Identifier: MIT
 *
 * mesh.h - the mesh that a model was made from, drawn as indexed triangles and lit per pixel.
 */
#ifndef PHONGSPLAT_BENCH_MESH_H
#define PHONGSPLAT_BENCH_MESH_H

#include "contestant.h"

typedef struct mesh_vertex {
    float position[3], normal[3], color[4];
} mesh_vertex;

typedef struct mesh {
    mesh_vertex *vertices; /* relative to origin */
    uint32_t *indices;     /* 3 * triangle_count */
    size_t vertex_count, triangle_count;
    double origin[3];
    psplat_material material;
} mesh;

/* Reads any file that the converter takes, with the normals that it would give it. Ends the program
 * with a message where that fails. Only where the converter is built. */
mesh mesh_read(const char *path);
void mesh_free(mesh *m);

/* A ball around it, scene space. */
void mesh_ball(const mesh *m, double center[3], double *radius);

/* Sides and lights as the view and the material say, always phong and lit. */
contestant contestant_mesh(psplat_host *host, const mesh *m);

#endif
