/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * ply_rows.c - the header of a binary PLY file, and its rows, read where they lie.
 */
#include "import/ply_rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const type_names[PSPLAT_PLY_TYPES][2] = {
    {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
    {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
static const size_t type_sizes[PSPLAT_PLY_TYPES] = {1, 1, 2, 2, 4, 4, 4, 8};

/* The words of a header line that count, and the most bytes of a line. */
enum { MAX_WORDS = 5, MAX_LINE = 200 };

/* The elements of the file in their order. */
typedef enum place { AT_START, AT_VERTICES, AT_FACES, BEYOND } place;

typedef struct header {
    psplat_ply_rows *rows;
    place at;
    int has_format, list_count;
    psplat_ply_type position_types[3];
} header;

size_t psplat_ply_size(psplat_ply_type type) {
    return type_sizes[type];
}

double psplat_ply_value(const psplat_ply_rows *rows, psplat_ply_type type, const char *data) {
    const unsigned char *bytes = (const unsigned char *)data;
    size_t size = type_sizes[type];
    uint64_t bits = 0;
    for (size_t i = 0; i < size; ++i) bits = bits << 8 | bytes[rows->is_big ? i : size - 1 - i];
    uint32_t half = (uint32_t)bits;
    float single;
    double value;
    memcpy(&single, &half, sizeof single);
    memcpy(&value, &bits, sizeof value);
    switch (type) {
    case PSPLAT_PLY_INT8:
        return (int8_t)bits;
    case PSPLAT_PLY_INT16:
        return (int16_t)bits;
    case PSPLAT_PLY_INT32:
        return (int32_t)bits;
    case PSPLAT_PLY_FLOAT32:
        return (double)single;
    case PSPLAT_PLY_FLOAT64:
        return value;
    default:
        return (double)bits;
    }
}

/* Returns the type of this name, or PSPLAT_PLY_TYPES. */
static psplat_ply_type type_of(const char *name) {
    int i = 0;
    while (i < PSPLAT_PLY_TYPES && strcmp(name, type_names[i][0]) && strcmp(name, type_names[i][1]))
        ++i;
    return (psplat_ply_type)i;
}

static int take_format(header *h, char *words[MAX_WORDS]) {
    h->rows->is_big = !strcmp(words[1], "binary_big_endian");
    h->has_format = 1;
    return h->rows->is_big || !strcmp(words[1], "binary_little_endian");
}

static int take_element(header *h, char *words[MAX_WORDS]) {
    char *end;
    size_t count = (size_t)strtoull(words[2], &end, 10);
    if (end == words[2] || *end) return 0;
    if (h->at == AT_START && !strcmp(words[1], "vertex")) {
        h->rows->vertices = count;
        h->at = AT_VERTICES;
        return 1;
    }
    if (h->at == AT_VERTICES && !strcmp(words[1], "face")) {
        h->rows->faces = count;
        h->at = AT_FACES;
        return 1;
    }
    int is_beyond = h->at == AT_FACES || h->at == BEYOND;
    h->at = BEYOND; /* what follows the faces is not read */
    return is_beyond;
}

/* Notes the place of a property of vertices if it is of use. */
static int take_vertex_property(header *h, psplat_ply_type type, const char *name) {
    static const char *const normals[3] = {"nx", "ny", "nz"};
    static const char *const colors[4] = {"red", "green", "blue", "alpha"};
    static const char *const others[3] = {"diffuse_red", "diffuse_green", "diffuse_blue"};
    psplat_ply_rows *rows = h->rows;
    int offset = (int)rows->vertex_size;
    rows->vertex_size += type_sizes[type];
    for (int k = 0; k < 4; ++k) {
        if (k < 3 && name[0] == 'x' + k && !name[1]) {
            rows->position[k] = offset;
            h->position_types[k] = type;
        }
        if (k < 3 && !strcmp(name, normals[k])) {
            rows->normal[k] = offset;
            if (type != PSPLAT_PLY_FLOAT32) return 0;
        }
        if (!strcmp(name, colors[k]) || (k < 3 && !strcmp(name, others[k]))) {
            rows->color[k] = offset;
            if (type != PSPLAT_PLY_UINT8) return 0;
        }
    }
    return rows->vertex_size < 4096;
}

static int take_face_property(header *h, const psplat_ply_property *property) {
    if (h->rows->property_count == PSPLAT_PLY_PROPERTIES) return 0;
    if (property->is_list && property->count_type >= PSPLAT_PLY_FLOAT32) return 0;
    if (property->is_corners && property->type >= PSPLAT_PLY_FLOAT32) return 0;
    h->list_count += property->is_corners;
    h->rows->properties[h->rows->property_count++] = *property;
    return 1;
}

static int take_property(header *h, char *words[MAX_WORDS]) {
    psplat_ply_property property = {0};
    if (h->at == BEYOND) return 1;
    property.is_list = !strcmp(words[1], "list");
    property.type = type_of(words[property.is_list ? 3 : 1]);
    property.count_type = property.is_list ? type_of(words[2]) : PSPLAT_PLY_INT8;
    const char *name = words[property.is_list ? 4 : 2];
    if (property.type == PSPLAT_PLY_TYPES || property.count_type == PSPLAT_PLY_TYPES || !*name)
        return 0;
    if (h->at == AT_VERTICES)
        return !property.is_list && take_vertex_property(h, property.type, name);
    property.is_corners =
        property.is_list && (!strcmp(name, "vertex_indices") || !strcmp(name, "vertex_index"));
    return h->at == AT_FACES && take_face_property(h, &property);
}

/* Splits a line, which is changed, into words; the rest of words become empty. */
static void split(char *line, char *words[MAX_WORDS]) {
    char *end = line + strlen(line);
    for (int i = 0; i < MAX_WORDS; ++i) {
        line += strspn(line, " \t\r");
        words[i] = line;
        line += strcspn(line, " \t\r");
        if (line < end) *line++ = 0;
    }
}

static int take_line(header *h, char *line) {
    char *words[MAX_WORDS];
    split(line, words);
    if (!strcmp(words[0], "format")) return take_format(h, words);
    if (!strcmp(words[0], "element")) return take_element(h, words);
    if (!strcmp(words[0], "property")) return take_property(h, words);
    return !*words[0] || !strcmp(words[0], "comment") || !strcmp(words[0], "obj_info");
}

/* Returns whether what the header promises can be read in place. */
static int is_whole(const header *h, size_t size) {
    const psplat_ply_rows *rows = h->rows;
    const psplat_ply_type type = h->position_types[0];
    int normals = 0, colors = 0;
    for (int k = 0; k < 3; ++k) {
        if (rows->position[k] < 0 || h->position_types[k] != type) return 0;
        normals += rows->normal[k] >= 0;
        colors += rows->color[k] >= 0;
    }
    if (!h->has_format || h->list_count != 1 || normals % 3 || colors % 3) return 0;
    if (!rows->faces || (type != PSPLAT_PLY_FLOAT32 && type != PSPLAT_PLY_FLOAT64)) return 0;
    return rows->vertices <= (size - rows->first_vertex) / rows->vertex_size;
}

int psplat_ply_rows_open(const char *data, size_t size, psplat_ply_rows *rows) {
    header h = {.rows = rows};
    char line[MAX_LINE];
    *rows = (psplat_ply_rows){
        .position = {-1, -1, -1}, .normal = {-1, -1, -1}, .color = {-1, -1, -1, -1}};
    for (size_t at = 0, number = 0; at < size; ++number) {
        size_t most = size - at < sizeof line ? size - at : sizeof line;
        const char *end = memchr(data + at, '\n', most);
        if (!end) return 0;
        size_t length = (size_t)(end - data) - at;
        memcpy(line, data + at, length);
        line[length] = 0;
        at += length + 1;
        if (!number) {
            if (strncmp(line, "ply", 3) != 0) return 0;
        } else if (!strncmp(line, "end_header", 10)) {
            rows->first_vertex = at;
            rows->scalars = h.position_types[0];
            return is_whole(&h, size);
        } else if (!take_line(&h, line)) {
            return 0;
        }
    }
    return 0;
}
