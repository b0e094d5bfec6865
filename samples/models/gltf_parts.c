/* SPDX-License-Identifier: MIT
 *
 * gltf_parts.c - the pieces that glTF files are put together from; see gltf_parts.h.
 */
#include "gltf_parts.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void put(bytes *b, const void *data, size_t size) {
    b->data = resize(b->data, b->size + size + 4);
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void put_u32(bytes *b, uint32_t value) {
    uint8_t data[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16),
                       (uint8_t)(value >> 24)};
    put(b, data, sizeof data);
}

static void put_float(bytes *b, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_u32(b, bits);
}

void pad(bytes *b, char with) {
    while (b->size % 4) put(b, &with, 1);
}

void print(bytes *b, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    put(b, text, (size_t)length);
}

/* ---- buffer with its views and accessors ---------------------------------------------------- */

int add_view(scene *g, size_t begin, int target) {
    print(&g->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu",
          g->view_count ? "," : "", begin, g->buffer.size - begin);
    if (target) print(&g->views, ",\"target\":%d", target);
    print(&g->views, "}");
    pad(&g->buffer, 0);
    return g->view_count++;
}

static int add_accessor(scene *g, size_t begin, int target, int component, const char *type,
                        size_t count, const char *more) {
    int view = add_view(g, begin, target);
    print(&g->accessors,
          "%s{\"bufferView\":%d,\"componentType\":%d,\"type\":\"%s\",\"count\":%zu%s}",
          g->accessor_count ? "," : "", view, component, type, count, more);
    return g->accessor_count++;
}

enum { UNSIGNED_BYTE = 5121, UNSIGNED_SHORT = 5123, FLOAT = 5126 };
enum { VERTICES = 34962, INDICES = 34963 };

int add_positions(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    float low[3], high[3];
    char more[256];
    for (size_t i = 0; i < s->vertex_count; ++i)
        for (int k = 0; k < 3; ++k) {
            float x = (float)s->positions[i][k];
            if (i == 0 || x < low[k]) low[k] = x;
            if (i == 0 || x > high[k]) high[k] = x;
            put_float(&g->buffer, x);
        }
    snprintf(more, sizeof more, ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]",
             (double)low[0], (double)low[1], (double)low[2], (double)high[0], (double)high[1],
             (double)high[2]);
    return add_accessor(g, begin, VERTICES, FLOAT, "VEC3", s->vertex_count, more);
}

int add_normals(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    for (size_t i = 0; i < s->vertex_count * 3; ++i)
        put_float(&g->buffer, s->normals[i / 3][i % 3]);
    return add_accessor(g, begin, VERTICES, FLOAT, "VEC3", s->vertex_count, "");
}

int add_texcoords(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    for (size_t i = 0; i < s->vertex_count * 2; ++i)
        put_float(&g->buffer, s->texcoords[i / 2][i % 2]);
    return add_accessor(g, begin, VERTICES, FLOAT, "VEC2", s->vertex_count, "");
}

int add_colors(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    put(&g->buffer, s->colors, s->vertex_count * 4);
    return add_accessor(g, begin, VERTICES, UNSIGNED_BYTE, "VEC4", s->vertex_count,
                        ",\"normalized\":true");
}

int add_indices(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    for (size_t i = 0; i < s->triangle_count * 3; ++i) {
        uint32_t index = s->triangles[i / 3][i % 3];
        uint8_t data[2] = {(uint8_t)index, (uint8_t)(index >> 8)};
        put(&g->buffer, data, sizeof data);
    }
    return add_accessor(g, begin, INDICES, UNSIGNED_SHORT, "SCALAR", s->triangle_count * 3, "");
}

int add_numbers(scene *g, const double *values, size_t count, int components) {
    static const char *const types[] = {"", "SCALAR", "", "VEC3", "VEC4"};
    size_t begin = g->buffer.size, last = count * (size_t)components - 1;
    char more[128] = "";
    for (size_t i = 0; i <= last; ++i) put_float(&g->buffer, (float)values[i]);
    if (components == 1)
        snprintf(more, sizeof more, ",\"min\":[%.9g],\"max\":[%.9g]", (double)(float)values[0],
                 (double)(float)values[last]);
    return add_accessor(g, begin, 0, FLOAT, types[components], count, more);
}

void print_tables(bytes *json, const scene *g) {
    put(json, ",\"accessors\":[", 14);
    put(json, g->accessors.data, g->accessors.size);
    put(json, "],\"bufferViews\":[", 17);
    put(json, g->views.data, g->views.size);
    print(json, "],\"buffers\":[{\"byteLength\":%zu", g->buffer.size);
}

void free_scene(scene *g, bytes *json) {
    free(g->buffer.data);
    free(g->views.data);
    free(g->accessors.data);
    free(json->data);
}

int write_file(const char *path, const bytes *b) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    size_t written = fwrite(b->data, 1, b->size, file);
    return fclose(file) || written != b->size ? -1 : 0;
}

int write_glb(const char *path, bytes *json, const scene *g) {
    bytes file = {0};
    pad(json, ' ');
    put_u32(&file, 0x46546c67); /* "glTF" */
    put_u32(&file, 2);
    put_u32(&file, (uint32_t)(12 + 8 + json->size + 8 + g->buffer.size));
    put_u32(&file, (uint32_t)json->size);
    put_u32(&file, 0x4e4f534a); /* "JSON" */
    put(&file, json->data, json->size);
    put_u32(&file, (uint32_t)g->buffer.size);
    put_u32(&file, 0x004e4942); /* "BIN" */
    put(&file, g->buffer.data, g->buffer.size);
    int result = write_file(path, &file);
    free(file.data);
    return result;
}
