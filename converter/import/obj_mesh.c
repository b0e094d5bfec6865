/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * obj_mesh.c - the mesh of an OBJ file from what its check has kept.
 *
 * check_obj.c has to read every number anyway. OpenMesh, which reads the colours of vertices, would
 * take four times as long to read them once more.
 */
#include "import/obj_mesh.h"

#include "base/polygon.h"
#include "mesh/mesh.h"
#include "source/obj_faces.h"
#include "source/source_file.h"

#include <stdlib.h>
#include <string.h>

static void store_corner(const psplat_obj_faces *obj, size_t face, size_t corner, psplat_mesh *mesh,
                         size_t target) {
    mesh->triangles[target] = obj->corner_vertices[corner];
    uint32_t normal = obj->corner_normals ? obj->corner_normals[corner] : UINT32_MAX;
    if (mesh->corner_normals && normal != UINT32_MAX)
        memcpy(mesh->corner_normals + 3 * target, obj->normals + 3 * (size_t)normal,
               3 * sizeof(float));
    if (mesh->corner_uvs[0]) psplat_obj_uv(obj, corner, mesh->corner_uvs[0] + 2 * target);
    if (!mesh->groups) return;
    uint32_t group = obj->groups[face], none = (uint32_t)obj->name_count;
    mesh->groups[target / 3] = group < none ? group : none;
}

/* Splits a face into triangles of corner numbers from 0. */
static psplat_result split_face(const psplat_obj_faces *obj, const psplat_mesh *mesh, size_t begin,
                                size_t count, uint32_t *split, psplat_error *error) {
    double outline[3 * PSPLAT_MAX_CORNERS];
    for (size_t i = 0; i < count; ++i)
        memcpy(outline + 3 * i, mesh->positions + 3 * (size_t)obj->corner_vertices[begin + i],
               3 * sizeof *outline);
    return psplat_polygon_triangulate(outline, count, split, error);
}

static psplat_result store_faces(const psplat_obj_faces *obj, psplat_mesh *mesh,
                                 psplat_error *error) {
    uint32_t split[3 * (PSPLAT_MAX_CORNERS - 2)] = {0, 1, 2};
    size_t begin = 0, target = 0;
    for (size_t face = 0; face < obj->face_count; ++face) {
        size_t count = obj->ends[face] - begin;
        if (count == 3)
            for (uint32_t k = 0; k < 3; ++k) split[k] = k;
        psplat_result result =
            count == 3 ? PSPLAT_OK : split_face(obj, mesh, begin, count, split, error);
        if (result) return result;
        for (size_t i = 0; i < 3 * (count - 2); ++i)
            store_corner(obj, face, begin + split[i], mesh, target++);
        begin = obj->ends[face];
    }
    return PSPLAT_OK;
}

psplat_result psplat_mesh_read_obj(psplat_source *source, psplat_mesh *mesh, psplat_error *error) {
    const psplat_obj_faces *obj = &source->obj;
    unsigned parts = obj->names_normals ? PSPLAT_MESH_NORMALS : 0;
    if (obj->library && obj->name_count) /* groups and uvs are useless without materials */
        parts |= PSPLAT_MESH_GROUPS | (obj->texcoord_count ? PSPLAT_MESH_UVS : 0u);
    psplat_result result = psplat_mesh_allocate(
        mesh, source->vertices, obj->corner_count - 2 * obj->face_count, parts, error);
    if (result) return result;
    free(mesh->positions);
    mesh->positions = source->positions;
    source->positions = NULL;
    mesh->dropped = source->dropped;
    return store_faces(obj, mesh, error);
}
