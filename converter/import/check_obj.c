/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * check_obj.c - the strict validation of an OBJ file before OpenMesh reads it.
 *
 * It replaces by blanks or comments what OpenMesh must not see: material statements, because
 * OpenMesh would open any file that they name (obj_faces.c keeps them), line continuations, and
 * faces with fewer than three different vertices. A file with vertices, but without faces, lines,
 * curves and surfaces is a point set, which obj_points.c reads.
 */
#include "base/polygon.h"
#include "import/check.h"
#include "source/obj_faces.h"
#include "source/source_file.h"
#include "source/text_lines.h"

#include <stdlib.h>
#include <string.h>

/* The elements counted so far, to which negative numbers in faces refer. */
typedef struct obj_state {
    psplat_lines lines;
    size_t texcoords, normals, colored,
        others; /* others: elements that are neither face nor point */
    size_t all_vertices, all_texcoords, all_normals; /* of the whole file */
} obj_state;

/* Joins lines that end in a backslash, which OpenMesh does not do. */
static void join_continued_lines(psplat_source *source) {
    for (char *c = source->data; (c = strchr(c, '\\')) != NULL; ++c) {
        char *end = c + 1 + (c[1] == '\r');
        if (*end == '\n') memset(c, ' ', (size_t)(end - c) + 1);
    }
}

static int is_word(const char *token, size_t length, const char *word) {
    return token && strlen(word) == length && memcmp(token, word, length) == 0;
}

/* Counts all elements first, since the indices of a face may refer to later ones. */
static void count_elements(psplat_source *source, obj_state *state) {
    psplat_lines lines = psplat_lines_begin(source);
    while (psplat_lines_next(&lines)) {
        size_t length;
        char *word = psplat_lines_token(&lines, &length);
        state->all_vertices += (size_t)is_word(word, length, "v");
        state->all_texcoords += (size_t)is_word(word, length, "vt");
        state->all_normals += (size_t)is_word(word, length, "vn");
    }
}

static psplat_result check_vertex(psplat_source *source, obj_state *state, psplat_error *error) {
    static const char *const names[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
    double *position = source->positions + source->vertices++ * 3;
    for (int axis = 0; axis < 3; ++axis) {
        psplat_result result =
            psplat_lines_number(&state->lines, names[axis], &position[axis], error);
        if (result) return result;
    }
    size_t length, more = 0;
    while (psplat_lines_token(&state->lines, &length)) ++more;
    state->colored += more >= 3; /* x y z r g b; a single fourth number is a weight */
    return PSPLAT_OK;
}

static psplat_result check_normal(psplat_source *source, obj_state *state, psplat_error *error) {
    double normal[3];
    psplat_result result = PSPLAT_OK;
    for (int k = 0; k < 3 && !result; ++k)
        result = psplat_lines_number(&state->lines, "a component of the normal", &normal[k], error);
    ++state->normals;
    return result ? result : psplat_obj_normal(&source->obj, normal, error);
}

/* Reads one index: positive numbers count from the first element, negative ones back from the
 * latest. */
static psplat_result check_index(const obj_state *state, const char *what, const char *text,
                                 size_t so_far, size_t total, size_t *index, psplat_error *error) {
    long long number = strtoll(text, NULL, 10);
    if (number < 0 && number >= -(long long)so_far) number += (long long)so_far + 1;
    if (number < 1 || (unsigned long long)number > total)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_RANGE,
                                 "%s %lld does not exist (%zu in the file)", what, number, total);
    *index = (size_t)number - 1;
    return PSPLAT_OK;
}

/* Reads a corner: v, v/t, v//n or v/t/n. */
static psplat_result check_corner(const psplat_source *source, const obj_state *state, char *token,
                                  size_t length, psplat_obj_corner *corner, psplat_error *error) {
    if (strspn(token, "0123456789-/") < length || token[0] == '/')
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "'%.*s' is not a corner of a face",
                                 (int)(length < 40 ? length : 40), token);
    size_t index = 0;
    char *end = token + length;
    char *slash = memchr(token, '/', length);
    char *second = slash ? memchr(slash + 1, '/', (size_t)(end - slash - 1)) : NULL;
    psplat_result result =
        check_index(state, "vertex", token, source->vertices, state->all_vertices, &index, error);
    if (!result) corner->vertex = (uint32_t)index;
    if (!result && slash && slash + 1 < end && slash[1] != '/') {
        result = check_index(state, "texture coordinate", slash + 1, state->texcoords,
                             state->all_texcoords, &index, error);
        corner->texcoord = (uint32_t)index;
    }
    if (!result && second && second + 1 < end) {
        result = check_index(state, "normal", second + 1, state->normals, state->all_normals,
                             &index, error);
        corner->normal = (uint32_t)index;
    }
    return result;
}

/* One face: its distinct vertices, and the number of its corners with repeated ones. */
typedef struct obj_face {
    uint32_t vertices[PSPLAT_MAX_CORNERS];
    size_t distinct, corners;
} obj_face;

static psplat_result add_corner(psplat_source *source, obj_state *state, char *token, size_t length,
                                obj_face *face, psplat_error *error) {
    psplat_obj_faces *obj = &source->obj;
    psplat_obj_corner corner = {0, UINT32_MAX, UINT32_MAX};
    psplat_result result = check_corner(source, state, token, length, &corner, error);
    if (result) return result;
    if (++face->corners > PSPLAT_MAX_CORNERS)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_RANGE,
                                 "the face has more than %u corners", PSPLAT_MAX_CORNERS);
    obj->names_normals |= corner.normal != UINT32_MAX;
    for (size_t i = 0; i < face->distinct; ++i) {
        if (face->vertices[i] != corner.vertex) continue;
        /* OpenMesh gives the normal of a repeated corner to the one before it. */
        if (corner.normal != UINT32_MAX) obj->corner_normals[obj->corner_count - 1] = corner.normal;
        return PSPLAT_OK;
    }
    face->vertices[face->distinct++] = corner.vertex;
    return psplat_obj_add_corner(obj, &corner, error);
}

static psplat_result check_face(psplat_source *source, obj_state *state, psplat_error *error) {
    char *line = state->lines.line;
    size_t length, corners_before = source->obj.corner_count;
    obj_face face;
    char *token;
    face.distinct = face.corners = 0;
    while ((token = psplat_lines_token(&state->lines, &length)) != NULL) {
        psplat_result result = add_corner(source, state, token, length, &face, error);
        if (result) return result;
    }
    if (face.corners < 3)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "the face has %zu corners", face.corners);
    if (face.distinct < 3) {
        ++source->dropped;
        source->obj.corner_count = corners_before;
        *line = '#';
        return PSPLAT_OK;
    }
    ++source->faces;
    return psplat_obj_face(&source->obj, error);
}

static psplat_result check_texcoord(psplat_source *source, obj_state *state, psplat_error *error) {
    double u, v = 0;
    size_t length;
    psplat_result result = psplat_lines_number(&state->lines, "the texture coordinate", &u, error);
    char *rest = state->lines.cursor;
    if (!result && psplat_lines_token(&state->lines, &length)) { /* v may be left out */
        state->lines.cursor = rest;
        result = psplat_lines_number(&state->lines, "the texture coordinate", &v, error);
    }
    ++state->texcoords;
    return result ? result : psplat_obj_texcoord(&source->obj, u, v, error);
}

/* Keeps a material statement for mtl.c and turns its line into a comment. */
static psplat_result check_material(psplat_source *source, obj_state *state, char *word,
                                    psplat_error *error) {
    int is_use = word[0] == 'u';
    *word = '#';
    if (!is_use) return psplat_obj_library(&source->obj, state->lines.cursor, error);
    psplat_result result = psplat_obj_material(&source->obj, state->lines.cursor, error);
    if (result != PSPLAT_ERROR_RANGE) return result;
    return psplat_lines_fail(&state->lines, error, result, "more than %d materials",
                             PSPLAT_MAX_OBJ_MATERIALS);
}

/* Returns whether a statement is a line, a curve or a surface of free form. */
static int is_other_element(const char *word, size_t length) {
    return is_word(word, length, "l") || is_word(word, length, "curv") ||
           is_word(word, length, "curv2") || is_word(word, length, "surf");
}

static psplat_result check_line(psplat_source *source, obj_state *state, psplat_error *error) {
    size_t length;
    char *word = psplat_lines_token(&state->lines, &length);
    if (is_word(word, length, "v")) return check_vertex(source, state, error);
    if (is_word(word, length, "vn")) return check_normal(source, state, error);
    if (is_word(word, length, "vt")) return check_texcoord(source, state, error);
    if (is_word(word, length, "f")) {
        state->lines.line = word;
        return check_face(source, state, error);
    }
    if (is_word(word, length, "mtllib") || is_word(word, length, "usemtl"))
        return check_material(source, state, word, error);
    state->others += (size_t)is_other_element(word, length);
    return PSPLAT_OK;
}

psplat_result psplat_check_obj(psplat_source *source, psplat_error *error) {
    if (strlen(source->data) < source->size)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, strlen(source->data),
                           "%s: byte %zu: a zero byte in an OBJ text", source->path,
                           strlen(source->data));
    join_continued_lines(source);
    obj_state state = {0};
    count_elements(source, &state);
    source->obj.has_texcoords = state.all_texcoords > 0;
    source->obj.has_normals = state.all_normals > 0;
    source->positions = malloc((state.all_vertices + 1) * 3 * sizeof(double));
    if (!source->positions)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    psplat_result result = PSPLAT_OK;
    state.lines = psplat_lines_begin(source);
    while (!result && psplat_lines_next(&state.lines)) result = check_line(source, &state, error);
    psplat_lines_end(&state.lines);
    source->has_colors = source->vertices > 0 && state.colored == source->vertices;
    source->normals = state.normals;
    source->is_point_set =
        source->vertices > 0 && source->faces + source->dropped + state.others == 0;
    if (!result && source->faces == 0 && !source->is_point_set)
        result = psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0,
                             "%s: end of file: no face with an area (%zu vertices)", source->path,
                             source->vertices);
    return result;
}
