/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mesh.c - the arrays of a triangle mesh: allocated, listed, freed.
 */
#include "mesh/mesh.h"

#include "material/source_materials.h"

#include <stdlib.h>

size_t psplat_mesh_corners(const psplat_mesh *mesh, psplat_corners arrays[PSPLAT_CORNER_ARRAYS]) {
    const psplat_corners all[PSPLAT_CORNER_ARRAYS] = {
        {mesh->corner_normals, 3}, {mesh->corner_colors, 4}, {mesh->corner_tangents, 4},
        {mesh->corner_uvs[0], 2},  {mesh->corner_uvs[1], 2},
    };
    size_t count = 0;
    for (size_t i = 0; i < PSPLAT_CORNER_ARRAYS; ++i)
        if (all[i].values) arrays[count++] = all[i];
    return count;
}

/* Allocates an array over the corners of all triangles. Returns NULL if it is not wanted, or if
 * there is no memory, which increments *failed. */
static float *allocate_corners(const psplat_mesh *mesh, unsigned wanted, size_t components,
                               int *failed) {
    if (!wanted) return NULL;
    float *values = calloc(mesh->triangle_count + 1, 3 * components * sizeof *values);
    if (!values) ++*failed;
    return values;
}

psplat_result psplat_mesh_allocate(psplat_mesh *mesh, size_t vertex_count, size_t triangle_count,
                                   unsigned parts, psplat_error *error) {
    int failed = 0;
    *mesh = (psplat_mesh){.vertex_count = vertex_count, .triangle_count = triangle_count};
    if (vertex_count > PSPLAT_MAX_VERTICES || triangle_count > PSPLAT_MAX_TRIANGLES)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%zu vertices and %zu triangles; at most %u and %u are read",
                           vertex_count, triangle_count, PSPLAT_MAX_VERTICES, PSPLAT_MAX_TRIANGLES);
    mesh->positions = calloc(vertex_count + 1, 3 * sizeof(double));
    mesh->triangles = calloc(triangle_count + 1, 3 * sizeof(uint32_t));
    if (parts & PSPLAT_MESH_GROUPS) mesh->groups = calloc(triangle_count + 1, sizeof(uint32_t));
    mesh->corner_normals = allocate_corners(mesh, parts & PSPLAT_MESH_NORMALS, 3, &failed);
    mesh->corner_colors = allocate_corners(mesh, parts & PSPLAT_MESH_COLORS, 4, &failed);
    mesh->corner_tangents = allocate_corners(mesh, parts & PSPLAT_MESH_TANGENTS, 4, &failed);
    for (unsigned i = 0; i < PSPLAT_TEXCOORDS; ++i)
        mesh->corner_uvs[i] = allocate_corners(mesh, parts & PSPLAT_MESH_UVS << i, 2, &failed);
    if (mesh->positions && mesh->triangles && (!(parts & PSPLAT_MESH_GROUPS) || mesh->groups) &&
        !failed)
        return PSPLAT_OK;
    psplat_mesh_free(mesh);
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for %zu triangles",
                       triangle_count);
}

void psplat_mesh_free(psplat_mesh *mesh) {
    psplat_corners arrays[PSPLAT_CORNER_ARRAYS];
    if (!mesh) return;
    size_t count = psplat_mesh_corners(mesh, arrays);
    for (size_t i = 0; i < count; ++i) free(arrays[i].values);
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->groups);
    free(mesh->both_sides);
    free(mesh->points);
    free(mesh->point_triangles);
    psplat_source_materials_free(mesh->materials);
    free(mesh->materials);
    *mesh = (psplat_mesh){0};
}

int psplat_mesh_shows_both_sides(const psplat_mesh *mesh, size_t group) {
    return group < mesh->both_sides_count && mesh->both_sides[group];
}

const double *psplat_mesh_corner(const psplat_mesh *mesh, uint32_t triangle, int corner) {
    return mesh->positions + 3 * (size_t)mesh->triangles[3 * (size_t)triangle + (size_t)corner];
}
