/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * obj_faces.h - the faces of an OBJ file, with their texture coordinates, normals and materials.
 */
#ifndef PHONGSPLAT_SOURCE_OBJ_FACES_H
#define PHONGSPLAT_SOURCE_OBJ_FACES_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The most material names of a file. */
#define PSPLAT_MAX_OBJ_MATERIALS 4096

/* A corner of a face: indices from 0, or UINT32_MAX where it has no texture coordinate or normal.
 */
typedef struct psplat_obj_corner {
    uint32_t vertex, texcoord, normal;
} psplat_obj_corner;

/* What check_obj.c has read about the faces of an OBJ file. If a face names a vertex several times,
 * only the first corner counts, as in OpenMesh. Zero-initialise. */
typedef struct psplat_obj_faces {
    float *texcoords; /* texcoord_count x 2, as in the file: v runs upwards */
    float *normals;   /* normal_count x 3, as in the file */
    size_t texcoord_count, texcoord_capacity, normal_count, normal_capacity;
    int has_texcoords, has_normals; /* the file has any: set before the first corner */
    /* Of the corners of kept faces, the members of psplat_obj_corner. corner_texcoords and
     * corner_normals are NULL where the file has none. */
    uint32_t *corner_vertices, *corner_texcoords, *corner_normals;
    size_t corner_count, corner_capacity;
    int names_normals; /* a corner has a normal */
    uint32_t *groups;  /* of each kept face: the index of its material's name, or UINT32_MAX */
    uint32_t *ends;    /* of each kept face: one past its last corner */
    size_t face_count, face_capacity;
    char **names; /* of materials, as in usemtl; malloc'ed */
    size_t name_count;
    char *library;  /* the first mtllib, malloc'ed, or NULL */
    uint32_t group; /* of the faces that follow */
} psplat_obj_faces;

/* These add a texture coordinate, a normal, a corner, and a face of the corners since the last one
 * with the material of the last usemtl. They fail only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_obj_texcoord(psplat_obj_faces *faces, double u, double v, psplat_error *error);
psplat_result psplat_obj_normal(psplat_obj_faces *faces, const double normal[3],
                                psplat_error *error);
psplat_result psplat_obj_add_corner(psplat_obj_faces *faces, const psplat_obj_corner *corner,
                                    psplat_error *error);
psplat_result psplat_obj_face(psplat_obj_faces *faces, psplat_error *error);

/* Sets the material of the faces that follow. name is the rest of a line, with or without blanks
 * around it. Errors: PSPLAT_ERROR_MEMORY; PSPLAT_ERROR_RANGE (too many materials), which leaves
 * *error as it is. */
psplat_result psplat_obj_material(psplat_obj_faces *faces, const char *name, psplat_error *error);

/* Sets the material library, unless the file has named one before. Fails only with
 * PSPLAT_ERROR_MEMORY. */
psplat_result psplat_obj_library(psplat_obj_faces *faces, const char *name, psplat_error *error);

/* Stores the texture coordinates of a corner as glTF has them, with t downwards, or 0 0 if the
 * corner has none. */
void psplat_obj_uv(const psplat_obj_faces *faces, size_t corner, float uv[2]);

/* Frees all that faces holds and makes it zero. */
void psplat_obj_faces_free(psplat_obj_faces *faces);

#ifdef __cplusplus
}
#endif
#endif
