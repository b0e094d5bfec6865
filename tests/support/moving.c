/* SPDX-License-Identifier: MIT
 *
 * moving.c - makes animated documents; see moving.h.
 */
#include "moving.h"

#include "document.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int moving_add(moving *m, const void *data, size_t size, int component_type, size_t count,
               int components, const char *more) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    size_t used = strlen(m->accessors);
    if (m->size + size + 4 > sizeof m->bytes) abort();
    int length = snprintf(m->accessors + used, sizeof m->accessors - used,
                          ",{\"bufferView\":3,\"byteOffset\":%zu,\"componentType\":%d,"
                          "\"count\":%zu,\"type\":\"%s\"%s}",
                          m->size, component_type, count, types[components], more);
    if (length < 0 || (size_t)length >= sizeof m->accessors - used) abort();
    memcpy(m->bytes + m->size, data, size);
    m->size += (size + 3) / 4 * 4;
    return MOVING_FIRST + m->count++;
}

int moving_floats(moving *m, const float *values, size_t count, int components) {
    enum { FLOAT = 5126 };
    return moving_add(m, values, count * (size_t)components * sizeof *values, FLOAT, count,
                      components, "");
}

static void put_base64(const moving *m, char *out) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < m->size; i += 3) {
        unsigned bits = 0;
        for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < m->size ? m->bytes[i + k] : 0u);
        for (int k = 0; k < 4; ++k) *out++ = digits[bits >> (18 - 6 * k) & 63];
    }
    for (size_t k = m->size % 3; k && k < 3; ++k) out[k - 3] = '=';
    *out = 0;
}

char *moving_text(const moving *m, const char *source_dir, const char *nodes,
                  const char *animations) {
    char *text = document_minimal(source_dir);
    size_t room = sizeof m->accessors + 2 * sizeof m->bytes + strlen(animations) + 512;
    char *more = malloc(room);
    if (!more) abort();
    document_replace(&text, "{ \"mesh\": 0, \"name\": \"minimal\" }", nodes);
    snprintf(more, room, "%s\n  ],\n  \"bufferViews\"", m->accessors);
    document_replace(&text, "\n  ],\n  \"bufferViews\"", more);
    snprintf(more, room, ",{\"buffer\":1,\"byteLength\":%zu}\n  ],\n  \"buffers\"", m->size);
    document_replace(&text, "\n  ],\n  \"buffers\"", more);
    snprintf(more, room, ",{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,",
             m->size);
    put_base64(m, more + strlen(more));
    size_t used = strlen(more);
    snprintf(more + used, room - used, "\"}],\n  \"animations\":[%s]\n}", animations);
    *strrchr(text, ']') = '@'; /* the end of the buffers, in place of which the rest comes */
    text[strcspn(text, "@") + 1] = 0;
    document_replace(&text, "@", more);
    free(more);
    return text;
}
