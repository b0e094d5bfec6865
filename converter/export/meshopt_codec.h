/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * meshopt_codec.h - compression of buffer views by EXT_meshopt_compression.
 */
#ifndef PHONGSPLAT_EXPORT_MESHOPT_CODEC_H
#define PHONGSPLAT_EXPORT_MESHOPT_CODEC_H

#include <stddef.h>
#include <stdint.h>

/* Functions that compress a buffer view. */
typedef struct psplat_codec {
    /* Returns how many bytes encode needs at most. */
    size_t (*bound)(size_t rows, size_t stride);
    /* Compresses rows of equal size (mode ATTRIBUTES). Returns the bytes written, or 0 where it
     * fails. */
    size_t (*encode)(uint8_t *out, size_t capacity, const void *rows, size_t row_count,
                     size_t stride);
    /* Do the same for the indices of triangles (mode TRIANGLES). */
    size_t (*index_bound)(size_t index_count, size_t vertex_count);
    size_t (*index_encode)(uint8_t *out, size_t capacity, const uint32_t *indices,
                           size_t index_count);
} psplat_codec;

/* The codec of libmeshoptimizer. */
extern const psplat_codec psplat_meshopt_codec;

#endif
