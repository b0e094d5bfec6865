/* SPDX-License-Identifier: MIT
 *
 * packed.c - writes documents with attributes of any type; see packed.h.
 */
#include "packed.h"

#ifdef PSPLAT_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_BYTES = 1 << 16, MAX_TEXT = 1 << 18 };

packed packed_default(void) {
    static const double zero[3] = {0, 0, 0}, up[3] = {0, 0, 1}, one[2] = {1, 1};
    static const double identity[4] = {0, 0, 0, 1};
    return (packed){.count = 1,
                    .attributes = {{"POSITION", PACKED_FLOAT, 3, 0, zero},
                                   {"NORMAL", PACKED_FLOAT, 3, 0, up},
                                   {"ROTATION", PACKED_FLOAT, 4, 0, identity},
                                   {"SCALE", PACKED_FLOAT, 2, 0, one}},
                    .extension = "\"version\":2,\"clipLines\":0,\"depthTolerance\":0,"
                                 "\"positionExtent\":[0,0,0]"};
}

static size_t size_of(int component_type) {
    return component_type == PACKED_FLOAT ? 4 : component_type >= PACKED_SHORT ? 2 : 1;
}

/* Stores little-endian on every machine. */
static void store(double value, int component_type, uint8_t *out) {
    uint32_t bits = (uint32_t)(int32_t)value;
    if (component_type == PACKED_FLOAT) {
        float number = (float)value;
        memcpy(&bits, &number, sizeof bits);
    }
    for (size_t i = 0; i < size_of(component_type); ++i) out[i] = (uint8_t)(bits >> (8 * i));
}

/* Elements begin at multiples of four bytes, as glTF demands. */
static size_t stride_of(const packed_attribute *a) {
    return ((size_t)a->components * size_of(a->component_type) + 3) / 4 * 4;
}

static void store_all(const packed_attribute *a, size_t count, uint8_t *out) {
    size_t components = (size_t)a->components;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < components; ++k)
            store(a->values[i * components + k], a->component_type,
                  out + i * stride_of(a) + k * size_of(a->component_type));
}

static void put_base64(const uint8_t *bytes, size_t size, char *out) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) { /* goes past size, reading zeros there */
        uint32_t bits =
            (uint32_t)bytes[i] << 16 | (uint32_t)bytes[i + 1] << 8 | (uint32_t)bytes[i + 2];
        for (int k = 3; k >= 0; --k) *out++ = digits[bits >> (6 * k) & 63];
    }
    *out = 0;
}

static int is_standard(const char *name) {
    return !strcmp(name, "POSITION") || !strcmp(name, "NORMAL") || !strcmp(name, "COLOR_0") ||
           !strcmp(name, "TEXCOORD_0");
}

static char *put_accessors(const packed *p, char *out, char *end) {
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    for (size_t i = 0; i < PACKED_MAX_ATTRIBUTES && p->attributes[i].name; ++i) {
        const packed_attribute *a = &p->attributes[i];
        out += snprintf(out, (size_t)(end - out),
                        "%s{\"bufferView\":%zu,\"componentType\":%d,\"normalized\":%s,"
                        "\"count\":%zu,\"type\":\"%s\"}",
                        i ? "," : "", i, a->component_type,
                        a->component_type == PACKED_FLOAT || a->is_plain ? "false" : "true",
                        p->count * (p->repeat ? p->repeat : 1), types[a->components - 1]);
    }
    return out;
}

static char *put_attributes(const packed *p, char *out, char *end) {
    for (size_t i = 0; i < PACKED_MAX_ATTRIBUTES && p->attributes[i].name; ++i) {
        const char *name = p->attributes[i].name;
        out += snprintf(out, (size_t)(end - out), "%s\"%s%s\":%zu", i ? "," : "",
                        is_standard(name) ? "" : "_PSPLAT_surface_splats:", name, i);
    }
    return out;
}

/* ---- views ---------------------------------------------------------------------------------- */

#ifdef PSPLAT_MESHOPTIMIZER
/* Filters values with the library's encoders, which take four floats an element, or as many as it
 * has components. */
static void filter_all(const packed_attribute *a, packed_filter filter, size_t count,
                       uint8_t *out) {
    size_t components = (size_t)a->components;
    size_t width = filter == PACKED_EXPONENTIAL ? components : 4;
    int bits = a->component_type == PACKED_BYTE ? 8 : 16;
    float *values = calloc(count * width, sizeof *values);
    if (!values) abort();
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < components; ++k)
            values[i * width + k] = (float)a->values[i * components + k];
    if (filter == PACKED_OCTAHEDRAL)
        meshopt_encodeFilterOct(out, count, stride_of(a), bits, values);
    else if (filter == PACKED_QUATERNION)
        meshopt_encodeFilterQuat(out, count, stride_of(a), 16, values);
    else
        meshopt_encodeFilterExp(out, count, stride_of(a), 15, values);
    free(values);
}

static size_t compress(const uint8_t *bytes, size_t count, size_t stride, uint8_t *out) {
    meshopt_encodeVertexVersion(0);
    return meshopt_encodeVertexBuffer(out, MAX_BYTES, bytes, count, stride);
}
#else
static void filter_all(const packed_attribute *a, packed_filter filter, size_t count,
                       uint8_t *out) {
    (void)a, (void)filter, (void)count, (void)out;
    abort(); /* tests of compressed files first call packed_can_compress */
}

static size_t compress(const uint8_t *bytes, size_t count, size_t stride, uint8_t *out) {
    (void)bytes, (void)count, (void)stride, (void)out;
    abort();
}
#endif

int packed_can_compress(void) {
#ifdef PSPLAT_MESHOPTIMIZER
    return 1;
#else
    return 0;
#endif
}

/* The bytes that views take in the buffer, and in the fallback buffer where there is one. */
typedef struct layout {
    uint8_t *bytes;
    size_t used, fallback;
} layout;

static char *put_view(const packed *p, size_t index, layout *l, char *out, char *end) {
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    const packed_attribute *a = &p->attributes[index];
    packed_filter filter = p->filters[index];
    size_t times = p->repeat ? p->repeat : 1, stride = stride_of(a), size = p->count * stride;
    uint8_t *bytes = calloc(times, size);
    if (!bytes || l->used + times * size + 3 > MAX_BYTES) abort();
    if (filter)
        filter_all(a, filter, p->count, bytes);
    else
        store_all(a, p->count, bytes);
    for (size_t i = 1; i < times; ++i) memcpy(bytes + i * size, bytes, size);
    size_t taken = times * size;
    if (p->is_compressed)
        taken = compress(bytes, times * p->count, stride, l->bytes + l->used);
    else
        memcpy(l->bytes + l->used, bytes, taken);
    free(bytes);
    if (p->is_compressed)
        out += snprintf(out, (size_t)(end - out),
                        "{\"buffer\":1,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu,"
                        "\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,"
                        "\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu,"
                        "\"count\":%zu,\"mode\":\"ATTRIBUTES\",\"filter\":\"%s\"}}}",
                        l->fallback, times * size, stride, l->used, taken, stride, times * p->count,
                        filters[filter]);
    else
        out += snprintf(out, (size_t)(end - out),
                        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu}",
                        l->used, taken, stride);
    l->fallback += times * size;
    l->used = (l->used + taken + 3) / 4 * 4;
    return out;
}

static char *put_buffers(const packed *p, const layout *l, char *out, char *end) {
    out += snprintf(out, (size_t)(end - out),
                    "],\"buffers\":[{\"byteLength\":%zu,\"uri\":"
                    "\"data:;base64,",
                    l->used);
    put_base64(l->bytes, l->used, out);
    out += strlen(out);
    out += snprintf(out, (size_t)(end - out), "\"}");
    if (p->is_compressed)
        out += snprintf(out, (size_t)(end - out),
                        ",{\"byteLength\":%zu,\"extensions\":{\"EXT_meshopt_compression\":"
                        "{\"fallback\":true}}}",
                        l->fallback);
    return out;
}

/* ---- the document --------------------------------------------------------------------------- */

char *packed_text(const packed *p) {
    layout l = {.bytes = calloc(MAX_BYTES, 1)};
    char *text = malloc(MAX_TEXT), *out = text, *end = text + MAX_TEXT;
    const char *meshopt = p->is_compressed ? ",\"EXT_meshopt_compression\"" : "";
    if (!l.bytes || !text) abort();
    out += sprintf(out,
                   "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":"
                   "[\"PSPLAT_surface_splats\",\"KHR_mesh_quantization\"%s],"
                   "\"extensionsRequired\":[\"KHR_mesh_quantization\"%s],"
                   "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"mode\":0,"
                   "\"attributes\":{",
                   meshopt, meshopt);
    out = put_attributes(p, out, end);
    out += snprintf(out, (size_t)(end - out),
                    "}%s,\"extensions\":{\"PSPLAT_surface_splats\":{%s}}}]}],",
                    p->material ? ",\"material\":0" : "", p->extension);
    out += snprintf(out, (size_t)(end - out), "\"materials\":[%s],\"accessors\":[",
                    p->material ? p->material : "");
    out = put_accessors(p, out, end);
    out += sprintf(out, "],\"bufferViews\":[");
    for (size_t i = 0; i < PACKED_MAX_ATTRIBUTES && p->attributes[i].name; ++i) {
        if (i) *out++ = ',';
        out = put_view(p, i, &l, out, end);
    }
    out = put_buffers(p, &l, out, end);
    snprintf(out, (size_t)(end - out), "]%s%s}", p->members ? "," : "",
             p->members ? p->members : "");
    free(l.bytes);
    return text;
}
