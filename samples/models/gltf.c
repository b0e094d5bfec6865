/* SPDX-License-Identifier: MIT
 *
 * gltf.c - two files as glTF 2.0: the bracket as .gltf with its buffer as a data URI, and the
 * painted piece as .glb with texture, vertex colours and a tree of nodes, one of them mirroring.
 */
#include "generate.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bytes {
    uint8_t *data;
    size_t size;
} bytes;

static void put(bytes *b, const void *data, size_t size) {
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

static void pad(bytes *b, char with) {
    while (b->size % 4) put(b, &with, 1);
}

static void print(bytes *b, const char *format, ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    put(b, text, (size_t)length);
}

/* ---- buffer with its views and accessors ---------------------------------------------------- */

typedef struct scene {
    bytes buffer, views, accessors;
    int view_count, accessor_count;
} scene;

static int add_view(scene *g, size_t begin, int target) {
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

static int add_positions(scene *g, const solid *s) {
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

static int add_texcoords(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    for (size_t i = 0; i < s->vertex_count * 2; ++i)
        put_float(&g->buffer, s->texcoords[i / 2][i % 2]);
    return add_accessor(g, begin, VERTICES, FLOAT, "VEC2", s->vertex_count, "");
}

static int add_colors(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    put(&g->buffer, s->colors, s->vertex_count * 4);
    return add_accessor(g, begin, VERTICES, UNSIGNED_BYTE, "VEC4", s->vertex_count,
                        ",\"normalized\":true");
}

static int add_indices(scene *g, const solid *s) {
    size_t begin = g->buffer.size;
    for (size_t i = 0; i < s->triangle_count * 3; ++i) {
        uint32_t index = s->triangles[i / 3][i % 3];
        uint8_t data[2] = {(uint8_t)index, (uint8_t)(index >> 8)};
        put(&g->buffer, data, sizeof data);
    }
    return add_accessor(g, begin, INDICES, UNSIGNED_SHORT, "SCALAR", s->triangle_count * 3, "");
}

static void print_tables(bytes *json, const scene *g) {
    put(json, ",\"accessors\":[", 14);
    put(json, g->accessors.data, g->accessors.size);
    put(json, "],\"bufferViews\":[", 17);
    put(json, g->views.data, g->views.size);
    print(json, "],\"buffers\":[{\"byteLength\":%zu", g->buffer.size);
}

static void free_scene(scene *g, bytes *json) {
    free(g->buffer.data);
    free(g->views.data);
    free(g->accessors.data);
    free(json->data);
}

static int write_file(const char *path, const bytes *b) {
    FILE *file = fopen(path, "wb");
    if (!file) return -1;
    size_t written = fwrite(b->data, 1, b->size, file);
    return fclose(file) || written != b->size ? -1 : 0;
}

/* ---- .gltf with a data URI ------------------------------------------------------------------- */

static void print_base64(bytes *json, const bytes *b) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < b->size; i += 3) {
        uint32_t bits = 0;
        char text[4];
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < b->size ? b->data[i + k] : 0u);
        for (int k = 0; k < 4; ++k) text[k] = digits[bits >> (18 - 6 * k) & 63];
        for (size_t k = b->size - i; k < 3; ++k) text[k + 1] = '=';
        put(json, text, 4);
    }
}

int write_gltf(const char *path, const solid *s) {
    scene g = {0};
    bytes json = {0};
    int positions = add_positions(&g, s), indices = add_indices(&g, s);
    print(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\"}");
    print(&json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]");
    print(&json, ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.9,0.55,0.2,1],"
                 "\"metallicFactor\":0.1,\"roughnessFactor\":0.6}}]");
    print(&json,
          ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d},\"indices\":%d,"
          "\"material\":0}]}]",
          positions, indices);
    print_tables(&json, &g);
    print(&json, ",\"uri\":\"data:application/octet-stream;base64,");
    print_base64(&json, &g.buffer);
    print(&json, "\"}]}\n");
    int result = write_file(path, &json);
    free_scene(&g, &json);
    return result;
}

/* ---- .glb ----------------------------------------------------------------------------------- */

/* A checkerboard whose squares change colour across the picture. */
static int add_texture(scene *g) {
    enum { SIZE = 64 };
    static uint8_t rgb[SIZE][SIZE][3];
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            int dark = (x / 8 + y / 8) % 2;
            rgb[y][x][0] = (uint8_t)(dark ? 30 : 250);
            rgb[y][x][1] = (uint8_t)(dark ? 60 + x : 240 - y);
            rgb[y][x][2] = (uint8_t)(dark ? 120 : 200 - x);
        }
    size_t size, begin = g->buffer.size;
    uint8_t *png = make_png(&rgb[0][0][0], SIZE, SIZE, &size);
    put(&g->buffer, png, size);
    free(png);
    return add_view(g, begin, 0);
}

static void print_painted(bytes *json, int view) {
    print(json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat generate_models\"}");
    print(json, ",\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":["
                "{\"name\":\"piece\",\"rotation\":[0,0.3826834,0,0.9238795],\"children\":[1,2]},"
                "{\"name\":\"vase\",\"mesh\":0,\"translation\":[0,-0.8,0]},"
                "{\"name\":\"rings\",\"translation\":[0,0.1,0],\"children\":[3,4]},"
                "{\"name\":\"ring\",\"mesh\":1,\"rotation\":[0.7071068,0,0,0.7071068],"
                "\"translation\":[0,0.35,0]},"
                "{\"name\":\"mirrored ring\",\"mesh\":1,"
                "\"matrix\":[1.1,0,0,0, 0,0.3,1,0, 0,1,-0.3,0, 0,-0.45,0,1]}]");
    print(json,
          ",\"images\":[{\"bufferView\":%d,\"mimeType\":\"image/png\"}],"
          "\"textures\":[{\"source\":0}],\"materials\":["
          "{\"name\":\"checked\",\"doubleSided\":true,\"pbrMetallicRoughness\":{"
          "\"baseColorTexture\":{\"index\":0},\"metallicFactor\":0,\"roughnessFactor\":0.4}},"
          "{\"name\":\"painted\",\"pbrMetallicRoughness\":{"
          "\"baseColorFactor\":[0.9,0.9,0.9,1],\"metallicFactor\":0,\"roughnessFactor\":0.4}}]",
          view);
}

static int write_glb(const char *path, bytes *json, scene *g) {
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

int write_painted_glb(const char *path, const solid *vase, const solid *ribbon) {
    scene g = {0};
    bytes json = {0};
    int vase_positions = add_positions(&g, vase), vase_texcoords = add_texcoords(&g, vase);
    int vase_indices = add_indices(&g, vase);
    int positions = add_positions(&g, ribbon), colors = add_colors(&g, ribbon);
    int indices = add_indices(&g, ribbon);
    print_painted(&json, add_texture(&g));
    print(&json,
          ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,"
          "\"TEXCOORD_0\":%d},\"indices\":%d,\"material\":0}]},"
          "{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"COLOR_0\":%d},"
          "\"indices\":%d,\"material\":1}]}]",
          vase_positions, vase_texcoords, vase_indices, positions, colors, indices);
    print_tables(&json, &g);
    print(&json, "}]}");
    int result = write_glb(path, &json, &g);
    free_scene(&g, &json);
    return result;
}
