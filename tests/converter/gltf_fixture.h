/* SPDX-License-Identifier: MIT
 *
 * gltf_fixture.h - small glTF files as text, whose buffer is a data URI.
 */
#ifndef PHONGSPLAT_TESTS_GLTF_FIXTURE_H
#define PHONGSPLAT_TESTS_GLTF_FIXTURE_H

#include "mesh_fixture.h"

/* A buffer under construction, and the JSON around it. */
typedef struct gltf {
    unsigned char buffer[1024];
    size_t size;
    char views[1024], accessors[1024], text[16384];
    int count;
} gltf;

static inline void append(char *text, size_t capacity, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static inline void append(char *text, size_t capacity, const char *format, ...) {
    va_list arguments;
    size_t used = strlen(text);
    va_start(arguments, format);
    int length = vsnprintf(text + used, capacity - used, format, arguments);
    va_end(arguments);
    assert_in_range(length, 0, capacity - used - 1);
}

/* Adds an accessor with a buffer view of its own; `more` is JSON that goes into the accessor, such
 * as "\"normalized\":true". */
static inline void add(gltf *g, const void *data, size_t size, int component, const char *type,
                       size_t count, const char *more) {
    const char *comma = g->count++ ? "," : "";
    append(g->views, sizeof g->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}",
           comma, g->size, size);
    append(g->accessors, sizeof g->accessors,
           "%s{\"bufferView\":%d,\"componentType\":%d,\"type\":\"%s\",\"count\":%zu%s}", comma,
           g->count - 1, component, type, count, more);
    memcpy(g->buffer + g->size, data, size);
    g->size += (size + 3) / 4 * 4;
}

static inline const char *base64(const gltf *g) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    static char text[2048];
    size_t used = 0;
    for (size_t i = 0; i < g->size; i += 3) {
        unsigned bits =
            (unsigned)g->buffer[i] << 16 | (unsigned)g->buffer[i + 1] << 8 | g->buffer[i + 2];
        for (int k = 0; k < 4; ++k) text[used++] = digits[bits >> (18 - 6 * k) & 63];
        for (size_t k = g->size - i; k < 3; ++k) text[used - 3 + k] = '=';
    }
    text[used] = 0;
    return text;
}

/* Returns the document as text; `rest` is the JSON of nodes, meshes and whatever else the file has.
 */
static inline const char *finish(gltf *g, const char *rest) {
    g->text[0] = 0;
    append(
        g->text, sizeof g->text,
        "{\"asset\":{\"version\":\"2.0\"},%s,\"accessors\":[%s],\"bufferViews\":[%s],"
        "\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,%s\"}]}",
        rest, g->accessors, g->views, g->size, base64(g));
    return g->text;
}

enum { BYTE = 5120, UBYTE = 5121, SHORT = 5122, USHORT = 5123, UINT = 5125, FLOAT = 5126 };

static const float points[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const unsigned char faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

static inline gltf with_points(void) {
    gltf g = {0};
    add(&g, points, sizeof points, FLOAT, "VEC3", 4, "");
    return g;
}

#define SCENE "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
#define NODE SCENE "\"nodes\":[{\"mesh\":0}],"
#define INDEXED "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]"

static inline gltf tetrahedron(void) {
    gltf g = with_points();
    add(&g, faces, sizeof faces, UBYTE, "SCALAR", 12, "");
    return g;
}

#endif
