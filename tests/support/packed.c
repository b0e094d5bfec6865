/* SPDX-License-Identifier: MIT
 * Documents with attributes of any type; see packed.h. */
#include "packed.h"

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

/* Little-endian, whatever the machine is. */
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
    for (size_t i = 0; i < size; i += 3) { /* bytes go on, as zeros */
        uint32_t bits =
            (uint32_t)bytes[i] << 16 | (uint32_t)bytes[i + 1] << 8 | (uint32_t)bytes[i + 2];
        for (int k = 3; k >= 0; --k) *out++ = digits[bits >> (6 * k) & 63];
    }
    *out = 0;
}

static int is_standard(const char *name) {
    return !strcmp(name, "POSITION") || !strcmp(name, "NORMAL") || !strcmp(name, "COLOR_0");
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
                        p->count, types[a->components - 1]);
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

char *packed_text(const packed *p) {
    uint8_t *bytes = calloc(MAX_BYTES, 1);
    char *text = malloc(MAX_TEXT), *out = text, *end = text + MAX_TEXT;
    if (!bytes || !text) abort();
    size_t used = 0;
    out += sprintf(out, "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":"
                        "[\"PSPLAT_surface_splats\",\"KHR_mesh_quantization\"],"
                        "\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
                        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"mode\":0,"
                        "\"attributes\":{");
    out = put_attributes(p, out, end);
    out += snprintf(out, (size_t)(end - out),
                    "},\"extensions\":{\"PSPLAT_surface_splats\":{%s}}}]}],\"accessors\":[",
                    p->extension);
    out = put_accessors(p, out, end);
    out += sprintf(out, "],\"bufferViews\":[");
    for (size_t i = 0; i < PACKED_MAX_ATTRIBUTES && p->attributes[i].name; ++i) {
        const packed_attribute *a = &p->attributes[i];
        size_t size = p->count * stride_of(a);
        if (used + size + 3 > MAX_BYTES) abort();
        store_all(a, p->count, bytes + used);
        out += snprintf(out, (size_t)(end - out),
                        "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu}",
                        i ? "," : "", used, size, stride_of(a));
        used += size;
    }
    out += sprintf(out, "],\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:;base64,", used);
    put_base64(bytes, used, out);
    strcat(out, "\"}]}");
    free(bytes);
    return text;
}
