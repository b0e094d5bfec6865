/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * check_ply.c - the strict validation of a PLY file, text or binary of either byte order, before
 * OpenMesh reads it. OpenMesh misreads rows with lists beside the corners, some integer types and
 * headers that end in a comment. So the file is rewritten in memory: vertices keep their
 * properties, faces keep only the list of their corners.
 */
#include "base/polygon.h"
#include "import/check.h"
#include "source/source_file.h"
#include "source/source_rewrite.h"
#include "source/text_lines.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_PROPERTIES 64

typedef enum scalar { INT8, UINT8, INT16, UINT16, INT32, UINT32, FLOAT32, FLOAT64, SCALARS } scalar;

static const char *const scalar_names[SCALARS][2] = {
    {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
    {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
static const size_t scalar_sizes[SCALARS] = {1, 1, 2, 2, 4, 4, 4, 8};

typedef struct ply_property {
    char name[32];
    scalar type;
    int is_list;
    scalar count_type; /* of a list */
} ply_property;

typedef struct ply_element {
    int present;
    size_t count;
    size_t property_count;
    ply_property properties[MAX_PROPERTIES];
} ply_element;

typedef struct ply_state {
    psplat_source *source;
    psplat_lines lines;
    enum { TEXT, LITTLE, BIG } encoding;
    ply_element vertex, face;
    int beyond_faces; /* the header has reached an element after the faces, which is not read */
    size_t offset;    /* of the next binary byte */
    psplat_rewrite out;
} ply_state;

static psplat_result write_header(ply_state *state, psplat_error *error) {
    static const char *const encodings[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    psplat_result result =
        psplat_rewrite_text(&state->out, error, "ply\nformat %s 1.0\nelement vertex %zu\n",
                            encodings[state->encoding], state->vertex.count);
    for (size_t i = 0; i < state->vertex.property_count && !result; ++i) {
        const ply_property *property = &state->vertex.properties[i];
        result = psplat_rewrite_text(&state->out, error, "property %s %s\n",
                                     scalar_names[property->type][0], property->name);
    }
    if (result) return result;
    return psplat_rewrite_text(
        &state->out, error, "element face %zu\nproperty list int int vertex_indices\nend_header\n",
        state->face.count);
}

/* ---- header ------------------------------------------------------------------------------- */

static int is_word(const char *token, size_t length, const char *word) {
    return token && strlen(word) == length && memcmp(token, word, length) == 0;
}

static psplat_result read_type(ply_state *state, scalar *type, psplat_error *error) {
    size_t length;
    char *token = psplat_lines_token(&state->lines, &length);
    for (int i = 0; i < SCALARS; ++i)
        if (is_word(token, length, scalar_names[i][0]) ||
            is_word(token, length, scalar_names[i][1])) {
            *type = (scalar)i;
            return PSPLAT_OK;
        }
    return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT, "'%.*s' is not a PLY type",
                             (int)(length < 40 ? length : 40), token ? token : "");
}

static psplat_result read_property(ply_state *state, ply_element *element, psplat_error *error) {
    if (element->property_count == MAX_PROPERTIES)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_UNSUPPORTED,
                                 "more than %d properties", MAX_PROPERTIES);
    ply_property *property = &element->properties[element->property_count++];
    *property = (ply_property){{0}, INT8, 0, INT8};
    size_t length;
    char *before = state->lines.cursor;
    char *word = psplat_lines_token(&state->lines, &length);
    property->is_list = is_word(word, length, "list");
    if (!property->is_list) state->lines.cursor = before;
    psplat_result result = PSPLAT_OK;
    if (property->is_list) result = read_type(state, &property->count_type, error);
    if (!result) result = read_type(state, &property->type, error);
    if (result) return result;
    char *name = psplat_lines_token(&state->lines, &length);
    if (!name || length >= sizeof property->name)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "the property has no name or a very long one");
    memcpy(property->name, name, length);
    return PSPLAT_OK;
}

static psplat_result read_element(ply_state *state, ply_element **element, psplat_error *error) {
    size_t length;
    char *name = psplat_lines_token(&state->lines, &length);
    *element = NULL;
    if (is_word(name, length, "vertex") && !state->face.present) *element = &state->vertex;
    if (is_word(name, length, "face") && state->vertex.present && !state->beyond_faces)
        *element = &state->face;
    /* Elements after the faces, or after the vertices of a point set, are not read. */
    int is_face = is_word(name, length, "face") && !state->face.present;
    if (!*element && state->vertex.present && !is_face) {
        state->beyond_faces = 1;
        return PSPLAT_OK;
    }
    if (!*element || (*element)->present)
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_UNSUPPORTED,
                                 "element '%.*s' here; 'vertex', then 'face' are read",
                                 (int)(length < 40 ? length : 40), name ? name : "");
    (*element)->present = 1;
    return psplat_lines_count(&state->lines, "the number of elements", &(*element)->count, error);
}

static psplat_result read_format(ply_state *state, psplat_error *error) {
    size_t length;
    char *word = psplat_lines_token(&state->lines, &length);
    if (is_word(word, length, "ascii")) {
        state->encoding = TEXT;
    } else if (is_word(word, length, "binary_little_endian")) {
        state->encoding = LITTLE;
    } else if (is_word(word, length, "binary_big_endian")) {
        state->encoding = BIG;
    } else {
        return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                                 "'%.*s' is not a PLY encoding", (int)(length < 40 ? length : 40),
                                 word ? word : "");
    }
    return PSPLAT_OK;
}

static psplat_result read_header_line(ply_state *state, ply_element **element,
                                      psplat_error *error) {
    size_t length;
    char *word = psplat_lines_token(&state->lines, &length);
    if (!word || is_word(word, length, "comment") || is_word(word, length, "obj_info"))
        return PSPLAT_OK;
    if (is_word(word, length, "format")) return read_format(state, error);
    if (is_word(word, length, "element")) return read_element(state, element, error);
    if (is_word(word, length, "property")) {
        if (state->beyond_faces) return PSPLAT_OK;
        if (*element) return read_property(state, *element, error);
    }
    return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                             "'%.*s' does not belong here", (int)(length < 40 ? length : 40), word);
}

static psplat_result read_header(ply_state *state, psplat_error *error) {
    ply_element *element = NULL;
    psplat_lines_next(&state->lines);
    while (psplat_lines_next(&state->lines)) {
        if (strncmp(state->lines.line, "end_header", 10) == 0) {
            state->offset = (size_t)(state->lines.next - state->source->data);
            return PSPLAT_OK;
        }
        psplat_result result = read_header_line(state, &element, error);
        if (result) return result;
    }
    return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                             "the file ends before 'end_header'");
}

/* ---- meaning of the header ---------------------------------------------------------------- */

static const ply_property *find(const ply_element *element, const char *name) {
    for (size_t i = 0; i < element->property_count; ++i)
        if (strcmp(element->properties[i].name, name) == 0) return &element->properties[i];
    return NULL;
}

static int is_corners(const ply_property *property) {
    return property->is_list && (strcmp(property->name, "vertex_indices") == 0 ||
                                 strcmp(property->name, "vertex_index") == 0);
}

/* Returns 0 for a property that OpenMesh knows by its name but not with this type. */
static int openmesh_reads(const ply_property *property) {
    static const char *const reals[] = {"x", "y", "z", "nx", "ny", "nz", "u", "v", "s", "t"};
    static const char *const colors[] = {"red",         "green",         "blue",        "alpha",
                                         "diffuse_red", "diffuse_green", "diffuse_blue"};
    if (property->is_list) return 0;
    for (size_t i = 0; i < sizeof reals / sizeof *reals; ++i)
        if (strcmp(property->name, reals[i]) == 0) return property->type >= FLOAT32;
    for (size_t i = 0; i < sizeof colors / sizeof *colors; ++i)
        if (strcmp(property->name, colors[i]) == 0)
            return property->type == UINT8 || property->type == FLOAT32;
    return 1;
}

static psplat_result check_properties(ply_state *state, psplat_error *error) {
    const char *path = state->source->path;
    for (size_t i = 0; i < state->vertex.property_count; ++i)
        if (!openmesh_reads(&state->vertex.properties[i]))
            return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 0,
                               "%s: header: vertex property '%s' has a type that is not read", path,
                               state->vertex.properties[i].name);
    if (!find(&state->vertex, "x") || !find(&state->vertex, "y") || !find(&state->vertex, "z"))
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                           "%s: header: the vertices have no x, y and z", path);
    size_t lists = 0;
    for (size_t i = 0; i < state->face.property_count; ++i) {
        const ply_property *property = &state->face.properties[i];
        lists += (size_t)is_corners(property);
        if (property->is_list && (property->count_type >= FLOAT32 ||
                                  (is_corners(property) && property->type >= FLOAT32)))
            return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                               "%s: header: face property '%s' counts in floats", path,
                               property->name);
    }
    state->source->is_point_set = state->face.count == 0;
    if (state->face.count && lists == 0)
        return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%s: header: faces without corners",
                           path);
    if (lists > 1)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "%s: header: two lists of corners", path);
    /* Each row takes at least one byte, so larger counts are false and would only waste memory. */
    if (state->vertex.count > state->source->size || state->face.count > state->source->size)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%s: header: %zu vertices and %zu faces do not fit into %zu bytes", path,
                           state->vertex.count, state->face.count, state->source->size);
    state->source->has_colors = find(&state->vertex, "red") || find(&state->vertex, "diffuse_red");
    return PSPLAT_OK;
}

/* ---- rows ------------------------------------------------------------------------------- */

static psplat_result fail_row(const ply_state *state, const char *row, size_t index,
                              psplat_result code, const char *cause, psplat_error *error) {
    if (state->encoding == TEXT)
        return psplat_lines_fail(&state->lines, error, code, "%s %zu: %s", row, index, cause);
    return psplat_fail(error, code, state->offset, "%s: byte %zu: %s %zu: %s", state->source->path,
                       state->offset, row, index, cause);
}

/* Reads one value, from a token or from bytes. A double holds counts and indices exactly. */
static psplat_result read_value(ply_state *state, scalar type, double *value, psplat_error *error) {
    if (state->encoding == TEXT) return psplat_lines_number(&state->lines, "a value", value, error);
    size_t size = scalar_sizes[type];
    if (state->source->size - state->offset < size)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, state->offset,
                           "%s: byte %zu: the file ends before the last row", state->source->path,
                           state->offset);
    const unsigned char *bytes = (const unsigned char *)state->source->data + state->offset;
    uint64_t bits = 0;
    for (size_t i = 0; i < size; ++i)
        bits = bits << 8 | bytes[state->encoding == BIG ? i : size - 1 - i];
    state->offset += size;
    uint32_t half = (uint32_t)bits;
    float single;
    memcpy(&single, &half, sizeof single);
    switch (type) {
    case INT8:
        *value = (int8_t)bits;
        break;
    case INT16:
        *value = (int16_t)bits;
        break;
    case INT32:
        *value = (int32_t)bits;
        break;
    case FLOAT32:
        *value = (double)single;
        break;
    case FLOAT64:
        memcpy(value, &bits, sizeof *value);
        break;
    default:
        *value = (double)bits;
        break;
    }
    return PSPLAT_OK;
}

static psplat_result next_row(ply_state *state, const char *row, size_t index,
                              psplat_error *error) {
    if (state->encoding != TEXT) return PSPLAT_OK;
    while (psplat_lines_next(&state->lines))
        if (state->lines.line[strspn(state->lines.line, " \t\r")]) return PSPLAT_OK;
    return psplat_lines_fail(&state->lines, error, PSPLAT_ERROR_FORMAT,
                             "the file ends before %s %zu", row, index);
}

/* Ends a text row and refuses further values, which OpenMesh would take for the next row. */
static psplat_result end_row(ply_state *state, const char *row, size_t index, psplat_error *error) {
    size_t length;
    if (state->encoding != TEXT) return PSPLAT_OK;
    if (psplat_lines_token(&state->lines, &length))
        return fail_row(state, row, index, PSPLAT_ERROR_FORMAT, "more values than properties",
                        error);
    return psplat_rewrite_bytes(&state->out, "\n", 1, error);
}

/* Writes a value of a text row anew: OpenMesh would read a "1.5" in place of an integer as two
 * values. */
static psplat_result write_value(ply_state *state, const ply_property *property, double value,
                                 size_t index, psplat_error *error) {
    if (state->encoding != TEXT) return PSPLAT_OK;
    if (property->type >= FLOAT32) return psplat_rewrite_text(&state->out, error, "%.9g ", value);
    if (value != floor(value) || fabs(value) > 4294967295.0)
        return fail_row(state, "vertex", index, PSPLAT_ERROR_FORMAT,
                        "an integer property has another value", error);
    return psplat_rewrite_text(&state->out, error, "%.0f ", value);
}

static psplat_result check_vertex(ply_state *state, size_t index, psplat_error *error) {
    size_t begin = state->offset;
    psplat_result result = next_row(state, "vertex", index, error);
    for (size_t i = 0; i < state->vertex.property_count && !result; ++i) {
        const ply_property *property = &state->vertex.properties[i];
        double value;
        result = read_value(state, property->type, &value, error);
        if (!result) result = write_value(state, property, value, index, error);
        char name = property->name[1] ? 0 : property->name[0];
        if (result || name < 'x' || name > 'z') continue;
        if (!isfinite(value) || fabs(value) > (double)FLT_MAX)
            return fail_row(state, "vertex", index, PSPLAT_ERROR_RANGE,
                            "a coordinate is not finite", error);
        state->source->positions[index * 3 + (size_t)(name - 'x')] = value;
    }
    if (result) return result;
    if (state->encoding != TEXT)
        return psplat_rewrite_bytes(&state->out, state->source->data + begin, state->offset - begin,
                                    error);
    return end_row(state, "vertex", index, error);
}

static psplat_result write_integer(ply_state *state, uint32_t value, psplat_error *error) {
    if (state->encoding == TEXT) return psplat_rewrite_text(&state->out, error, "%u ", value);
    unsigned char bytes[4];
    for (int i = 0; i < 4; ++i)
        bytes[state->encoding == BIG ? 3 - i : i] = (unsigned char)(value >> (8 * i));
    return psplat_rewrite_bytes(&state->out, bytes, sizeof bytes, error);
}

static psplat_result check_corners(ply_state *state, const ply_property *property, size_t index,
                                   double count, psplat_error *error) {
    if (!(count >= 3) || count > (double)PSPLAT_MAX_CORNERS || count != floor(count))
        return fail_row(state, "face", index, PSPLAT_ERROR_RANGE,
                        "fewer than 3 or more than 4096 corners", error);
    psplat_result result = write_integer(state, (uint32_t)count, error);
    for (double i = 0; i < count && !result; ++i) {
        double vertex;
        result = read_value(state, property->type, &vertex, error);
        if (result) return result;
        if (!(vertex >= 0) || vertex >= (double)state->vertex.count || vertex != floor(vertex))
            return fail_row(state, "face", index, PSPLAT_ERROR_RANGE,
                            "a corner is not the index of a vertex", error);
        result = write_integer(state, (uint32_t)vertex, error);
    }
    return result;
}

static psplat_result check_face(ply_state *state, size_t index, psplat_error *error) {
    psplat_result result = next_row(state, "face", index, error);
    for (size_t i = 0; i < state->face.property_count && !result; ++i) {
        const ply_property *property = &state->face.properties[i];
        double value, count = 1;
        if (property->is_list) result = read_value(state, property->count_type, &count, error);
        if (!result && is_corners(property)) {
            result = check_corners(state, property, index, count, error);
            continue;
        }
        for (double k = 0; k < count && !result; ++k)
            result = read_value(state, property->type, &value, error);
    }
    return result ? result : end_row(state, "face", index, error);
}

static psplat_result check_rows(ply_state *state, psplat_error *error) {
    psplat_source *source = state->source;
    source->vertices = state->vertex.count;
    source->faces = state->face.count;
    source->positions = malloc((source->vertices + 1) * 3 * sizeof(double));
    if (!source->positions)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "%s: out of memory", source->path);
    psplat_result result = write_header(state, error);
    for (size_t i = 0; i < source->vertices && !result; ++i) result = check_vertex(state, i, error);
    for (size_t i = 0; i < source->faces && !result; ++i) result = check_face(state, i, error);
    return result;
}

psplat_result psplat_check_ply(psplat_source *source, psplat_error *error) {
    ply_state state = {.source = source, .lines = psplat_lines_begin(source)};
    psplat_result result = read_header(&state, error);
    if (!result) result = check_properties(&state, error);
    if (!result) result = check_rows(&state, error);
    psplat_lines_end(&state.lines);
    if (result) {
        free(state.out.data);
        return result;
    }
    psplat_rewrite_replace(&state.out, source);
    return PSPLAT_OK;
}
