/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * obj_faces.c - the faces of an OBJ file, with their texture coordinates, normals and materials.
 */
#include "source/obj_faces.h"

#include <stdlib.h>
#include <string.h>

static psplat_result out_of_memory(psplat_error *error) {
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory while reading an OBJ");
}

/* Returns the array with room for one more element of this size, or NULL if there is no memory; the
 * array stays as it is then. */
static void *grow(void *array, size_t count, size_t *capacity, size_t size) {
    if (count < *capacity) return array;
    size_t wanted = 2 * *capacity + 256;
    void *grown = realloc(array, wanted * size);
    if (grown) *capacity = wanted;
    return grown;
}

psplat_result psplat_obj_texcoord(psplat_obj_faces *faces, double u, double v,
                                  psplat_error *error) {
    float *grown =
        grow(faces->texcoords, faces->texcoord_count, &faces->texcoord_capacity, 2 * sizeof *grown);
    if (!grown) return out_of_memory(error);
    faces->texcoords = grown;
    grown[2 * faces->texcoord_count] = (float)u;
    grown[2 * faces->texcoord_count++ + 1] = (float)v;
    return PSPLAT_OK;
}

psplat_result psplat_obj_normal(psplat_obj_faces *faces, const double normal[3],
                                psplat_error *error) {
    float *grown =
        grow(faces->normals, faces->normal_count, &faces->normal_capacity, 3 * sizeof *grown);
    if (!grown) return out_of_memory(error);
    faces->normals = grown;
    for (int k = 0; k < 3; ++k) grown[3 * faces->normal_count + (size_t)k] = (float)normal[k];
    ++faces->normal_count;
    return PSPLAT_OK;
}

/* Makes one array of corners larger. Returns 0 when out of memory; the array stays as it is then.
 */
static int enlarge(uint32_t **array, size_t capacity) {
    uint32_t *grown = realloc(*array, capacity * sizeof *grown);
    if (grown) *array = grown;
    return grown != NULL;
}

psplat_result psplat_obj_add_corner(psplat_obj_faces *faces, const psplat_obj_corner *corner,
                                    psplat_error *error) {
    size_t at = faces->corner_count;
    if (at == faces->corner_capacity) {
        size_t capacity = 2 * faces->corner_capacity + 256;
        if (!enlarge(&faces->corner_vertices, capacity) ||
            (faces->has_texcoords && !enlarge(&faces->corner_texcoords, capacity)) ||
            (faces->has_normals && !enlarge(&faces->corner_normals, capacity)))
            return out_of_memory(error);
        faces->corner_capacity = capacity;
    }
    faces->corner_vertices[at] = corner->vertex;
    if (faces->corner_texcoords) faces->corner_texcoords[at] = corner->texcoord;
    if (faces->corner_normals) faces->corner_normals[at] = corner->normal;
    ++faces->corner_count;
    return PSPLAT_OK;
}

psplat_result psplat_obj_face(psplat_obj_faces *faces, psplat_error *error) {
    if (faces->face_count == faces->face_capacity) {
        size_t capacity = 2 * faces->face_capacity + 256;
        if (!enlarge(&faces->groups, capacity) || !enlarge(&faces->ends, capacity))
            return out_of_memory(error);
        faces->face_capacity = capacity;
    }
    faces->ends[faces->face_count] = (uint32_t)faces->corner_count;
    faces->groups[faces->face_count++] = faces->name_count ? faces->group : UINT32_MAX;
    return PSPLAT_OK;
}

/* Copies the rest of a line without the blanks around it. Names may contain blanks. */
static char *copy_trimmed(const char *text) {
    static const char blanks[] = " \t\r\v\f";
    text += strspn(text, blanks);
    size_t length = strlen(text);
    while (length && strchr(blanks, text[length - 1])) --length;
    char *copy = malloc(length + 1);
    if (!copy) return NULL;
    memcpy(copy, text, length);
    copy[length] = 0;
    return copy;
}

psplat_result psplat_obj_material(psplat_obj_faces *faces, const char *name, psplat_error *error) {
    char *copy = copy_trimmed(name);
    if (!copy) return out_of_memory(error);
    for (size_t i = 0; i < faces->name_count; ++i)
        if (!strcmp(faces->names[i], copy)) {
            faces->group = (uint32_t)i;
            free(copy);
            return PSPLAT_OK;
        }
    char **grown = faces->names;
    if (faces->name_count == 0) grown = calloc(PSPLAT_MAX_OBJ_MATERIALS, sizeof *grown);
    if (!grown || faces->name_count == PSPLAT_MAX_OBJ_MATERIALS) {
        free(copy);
        return grown ? PSPLAT_ERROR_RANGE : out_of_memory(error);
    }
    faces->names = grown;
    faces->group = (uint32_t)faces->name_count;
    grown[faces->name_count++] = copy;
    return PSPLAT_OK;
}

psplat_result psplat_obj_library(psplat_obj_faces *faces, const char *name, psplat_error *error) {
    if (faces->library) return PSPLAT_OK;
    faces->library = copy_trimmed(name);
    return faces->library ? PSPLAT_OK : out_of_memory(error);
}

void psplat_obj_uv(const psplat_obj_faces *faces, size_t corner, float uv[2]) {
    uint32_t texcoord = faces->corner_texcoords ? faces->corner_texcoords[corner] : UINT32_MAX;
    uv[0] = uv[1] = 0;
    if (texcoord == UINT32_MAX) return;
    uv[0] = faces->texcoords[2 * (size_t)texcoord];
    uv[1] = 1 - faces->texcoords[2 * (size_t)texcoord + 1];
}

void psplat_obj_faces_free(psplat_obj_faces *faces) {
    for (size_t i = 0; i < faces->name_count; ++i) free(faces->names[i]);
    free(faces->names);
    free(faces->library);
    free(faces->texcoords);
    free(faces->normals);
    free(faces->corner_vertices);
    free(faces->corner_texcoords);
    free(faces->corner_normals);
    free(faces->groups);
    free(faces->ends);
    *faces = (psplat_obj_faces){0};
}
