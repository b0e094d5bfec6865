/* SPDX-License-Identifier: MIT
 *
 * table_rows.c - a sphere of splats as integers; see table_rows.h.
 */
#include "table_rows.h"

#include <math.h>
#ifdef PSPLAT_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RADIUS = 32767, HEAD = 4096 };

typedef struct row {
    uint16_t position[4]; /* the fourth is padding */
    int8_t normal[3];
    uint8_t turn;
    uint8_t scale[2];
    int8_t tilt[2];
    int8_t field[4]; /* the fourth is padding */
} row;

static void *allocate(size_t size) {
    void *memory = calloc(1, size);
    if (memory) return memory;
    fprintf(stderr, "rows: out of memory\n");
    abort();
}

/* ---- splats ---------------------------------------------------------------------------------- */

/* Places splats as scene_sphere does. Every third is larger or tilted by a step, because no two
 * splats of a conversion are alike. */
static row row_of(size_t i, size_t count) {
    const double golden_angle = 2.399963229728653;
    double z = 1 - (2 * (double)i + 1) / (double)count, ring = sqrt(1 - z * z);
    const double n[3] = {ring * cos(golden_angle * (double)i), ring * sin(golden_angle * (double)i),
                         z};
    row r = {.turn = (uint8_t)(i % 3), .scale = {255, (uint8_t)(255 - i % 3)}, .field = {120, 120}};
    for (int k = 0; k < 3; ++k) {
        r.position[k] = (uint16_t)lrint(RADIUS + RADIUS * n[k]);
        r.normal[k] = (int8_t)lrint(127 * n[k]);
    }
    r.tilt[i % 2] = (int8_t)(i % 3);
    return r;
}

/* Interleaves the bits of x, y and z, the highest first (Morton order). */
static uint64_t place_of(const row *r) {
    uint64_t place = 0;
    for (int bit = 15; bit >= 0; --bit)
        for (int k = 0; k < 3; ++k) place = place << 1 | (r->position[k] >> bit & 1u);
    return place;
}

static int by_place(const void *a, const void *b) {
    uint64_t first = place_of(a), second = place_of(b);
    return (first > second) - (first < second);
}

static row *make_rows(size_t count, int extent[3]) {
    row *rows = allocate(count * sizeof *rows);
    int low[3] = {65535, 65535, 65535}, high[3] = {0, 0, 0};
    for (size_t i = 0; i < count; ++i) {
        rows[i] = row_of(i, count);
        for (int k = 0; k < 3; ++k) {
            low[k] = rows[i].position[k] < low[k] ? rows[i].position[k] : low[k];
            high[k] = rows[i].position[k] > high[k] ? rows[i].position[k] : high[k];
            extent[k] = high[k] - low[k];
        }
    }
    qsort(rows, count, sizeof *rows, by_place);
    return rows;
}

/* ---- the document ---------------------------------------------------------------------------- */

static char *put_accessors(char *out, size_t count) {
    static const struct {
        unsigned offset, type;
        const char *shape;
    } accessors[] = {{0, 5123, "VEC3"},  {8, 5120, "VEC3"},  {11, 5121, "SCALAR"},
                     {12, 5121, "VEC2"}, {14, 5120, "VEC2"}, {16, 5120, "VEC2"}};
    for (size_t i = 0; i < sizeof accessors / sizeof *accessors; ++i)
        out += sprintf(out,
                       "%s{\"bufferView\":0,\"byteOffset\":%u,\"componentType\":%u,\"normalized\":"
                       "%s,\"count\":%zu,\"type\":\"%s\"}",
                       i ? "," : "", accessors[i].offset, accessors[i].type, i ? "true" : "false",
                       count, accessors[i].shape);
    return out;
}

/* size is the number of bytes that the view takes in the file. */
static char *put_view(char *out, size_t count, size_t size, int is_compressed) {
    size_t all = count * sizeof(row);
    if (!is_compressed)
        return out + sprintf(out,
                             "],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu,\"byteStride\":"
                             "20}],\"buffers\":[{\"byteLength\":%zu}]}",
                             all, all);
    return out + sprintf(out,
                         "],\"bufferViews\":[{\"buffer\":1,\"byteLength\":%zu,\"byteStride\":20,"
                         "\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,"
                         "\"byteLength\":%zu,\"byteStride\":20,\"count\":%zu,\"mode\":"
                         "\"ATTRIBUTES\"}}}],\"buffers\":[{\"byteLength\":%zu},{\"byteLength\":%zu,"
                         "\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}]}",
                         all, size, count, size, all);
}

/* Writes the JSON, padded to four bytes. */
static size_t put_head(char *out, size_t count, const int extent[3], size_t size,
                       int is_compressed) {
    char *start = out;
    double radius = 0.9 * sqrt(4 * 3.14159265358979323846 / (double)count) * RADIUS;
    out +=
        sprintf(out,
                "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":"
                "[\"PSPLAT_surface_splats\",\"KHR_mesh_quantization\"],\"extensionsRequired\":"
                "[\"KHR_mesh_quantization\"],\"nodes\":[{\"mesh\":0,\"scale\":[3e-5,3e-5,3e-5],"
                "\"translation\":[-1,-1,-1]}],\"meshes\":[{\"primitives\":[{\"mode\":0,"
                "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"_PSPLAT_surface_splats:TURN\":2,"
                "\"_PSPLAT_surface_splats:SCALE\":3,\"_PSPLAT_surface_splats:TILT\":4,"
                "\"_PSPLAT_surface_splats:NORMAL_FIELD\":5},\"extensions\":"
                "{\"PSPLAT_surface_splats\":{\"version\":2,\"clipLines\":0,\"depthTolerance\":"
                "600,\"positionExtent\":[%d,%d,%d],\"scaleRange\":[%.9g,%.9g],\"tiltRange\":%.9g,"
                "\"fieldRange\":%.9g}}}]}],\"accessors\":[",
                extent[0], extent[1], extent[2], 0.5 * radius, radius, 0.01, radius / RADIUS);
    out = put_accessors(out, count);
    out = put_view(out, count, size, is_compressed);
    while ((out - start) % 4) *out++ = ' ';
    return (size_t)(out - start);
}

static void put_u32(uint8_t *out, size_t value) {
    for (int i = 0; i < 4; ++i) out[i] = (uint8_t)(value >> (8 * i));
}

static void put_chunk(uint8_t *out, uint32_t type, const void *bytes, size_t size) {
    put_u32(out, (size + 3) / 4 * 4);
    put_u32(out + 4, type);
    memcpy(out + 8, bytes, size);
}

static size_t compress(const row *rows, size_t count, uint8_t **out) {
#ifdef PSPLAT_MESHOPTIMIZER
    size_t room = meshopt_encodeVertexBufferBound(count, sizeof *rows);
    *out = allocate(room);
    meshopt_encodeVertexVersion(0);
    return meshopt_encodeVertexBuffer(*out, room, rows, count, sizeof *rows);
#else
    (void)rows, (void)count;
    *out = NULL;
    return 0;
#endif
}

uint8_t *rows_glb(size_t splat_count, int is_compressed, size_t *size) {
    int extent[3] = {0, 0, 0};
    row *rows = make_rows(splat_count, extent);
    uint8_t *bytes = (uint8_t *)rows, *compressed = NULL, *glb = NULL;
    size_t bytes_size = splat_count * sizeof *rows;
    if (is_compressed) {
        bytes_size = compress(rows, splat_count, &compressed);
        bytes = compressed;
    }
    if (bytes) {
        char *head = allocate(HEAD);
        size_t head_size = put_head(head, splat_count, extent, bytes_size, is_compressed);
        *size = 12 + 8 + head_size + 8 + (bytes_size + 3) / 4 * 4;
        glb = allocate(*size);
        memcpy(glb, "glTF\2\0\0\0", 8);
        put_u32(glb + 8, *size);
        put_chunk(glb + 12, 0x4e4f534a, head, head_size);
        put_chunk(glb + 20 + head_size, 0x004e4942, bytes, bytes_size);
        free(head);
    }
    free(compressed);
    free(rows);
    return glb;
}
