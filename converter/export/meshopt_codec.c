/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * meshopt_codec.c - compression of buffer views by libmeshoptimizer. EXT_meshopt_compression fixes
 * version 0 of the library's format for vertices and version 1 of that for indices.
 */
#include "export/meshopt_codec.h"

#include <meshoptimizer.h>

static size_t bound(size_t rows, size_t stride) {
    return meshopt_encodeVertexBufferBound(rows, stride);
}

static size_t encode(uint8_t *out, size_t capacity, const void *rows, size_t row_count,
                     size_t stride) {
    meshopt_encodeVertexVersion(0);
    return meshopt_encodeVertexBuffer(out, capacity, rows, row_count, stride);
}

static size_t index_encode(uint8_t *out, size_t capacity, const uint32_t *indices,
                           size_t index_count) {
    meshopt_encodeIndexVersion(1);
    return meshopt_encodeIndexBuffer(out, capacity, indices, index_count);
}

const psplat_codec psplat_meshopt_codec = {bound, encode, meshopt_encodeIndexBufferBound,
                                           index_encode};
