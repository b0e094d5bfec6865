/* SPDX-License-Identifier: MIT
 *
 * container.c - the GLB container (glTF 2.0 section 4.4): a header of 12 bytes, then chunks that
 * consist of length, type and bytes.
 */
#include "asset/container.h"

#include <string.h>

enum { HEADER = 12, CHUNK_HEADER = 8, JSON = 0x4e4f534a, BIN = 0x004e4942 };

static uint32_t read_u32(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static psplat_result check_header(const uint8_t *data, size_t size, psplat_error *error) {
    if (size < HEADER)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, size, "the file ends within the GLB header");
    if (read_u32(data + 4) != 2)
        return psplat_fail(error, PSPLAT_ERROR_UNSUPPORTED, 4, "GLB version %lu is not 2",
                           (unsigned long)read_u32(data + 4));
    if (read_u32(data + 8) != size)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 8,
                           "the GLB header announces %lu bytes, the file has %zu",
                           (unsigned long)read_u32(data + 8), size);
    return PSPLAT_OK;
}

static psplat_result check_chunk(const uint8_t *data, size_t size, size_t at, size_t *length,
                                 psplat_error *error) {
    if (size - at < CHUNK_HEADER)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, at, "the file ends within a chunk header");
    *length = read_u32(data + at);
    if (*length > size - at - CHUNK_HEADER)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, at,
                           "a chunk announces %zu bytes, %zu are left", *length,
                           size - at - CHUNK_HEADER);
    if (*length % 4)
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, at,
                           "a chunk's length of %zu bytes is not a multiple of 4", *length);
    return PSPLAT_OK;
}

/* The JSON chunk comes first, the BIN chunk second. Chunks of other types may follow and are
 * skipped. */
static psplat_result parse_glb(const uint8_t *data, size_t size, psplat_container *container,
                               psplat_error *error) {
    psplat_result result = check_header(data, size, error);
    size_t index = 0, length = 0;
    for (size_t at = HEADER; !result && (at < size || !index);
         at += CHUNK_HEADER + length, ++index) {
        result = check_chunk(data, size, at, &length, error);
        if (result) break;
        uint32_t type = read_u32(data + at + 4);
        if ((type == JSON) != (index == 0) || (type == BIN && index != 1))
            return psplat_fail(error, PSPLAT_ERROR_FORMAT, at + 4,
                               "chunk %zu has a type that belongs elsewhere", index);
        if (type == JSON) {
            container->json_offset = at + CHUNK_HEADER;
            container->json_size = length;
        } else if (type == BIN) {
            container->bin_offset = at + CHUNK_HEADER;
            container->bin_size = length;
        }
    }
    return result;
}

psplat_result psplat_container_parse(const uint8_t *data, size_t size, psplat_container *container,
                                     psplat_error *error) {
    *container = (psplat_container){0};
    if (size == 0) return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0, "the file is empty");
    if (size >= 4 && !memcmp(data, "glTF", 4)) return parse_glb(data, size, container, error);
    size_t at = 0;
    while (at < size && data[at] && strchr(" \t\r\n", data[at])) ++at;
    if (at == size || data[at] != '{')
        return psplat_fail(error, PSPLAT_ERROR_FORMAT, 0,
                           "the file is neither a GLB nor a glTF document");
    container->json_size = size;
    return PSPLAT_OK;
}
