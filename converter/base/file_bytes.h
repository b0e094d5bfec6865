/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * file_bytes.h - reading a whole file into memory.
 */
#ifndef PHONGSPLAT_BASE_FILE_BYTES_H
#define PHONGSPLAT_BASE_FILE_BYTES_H

#include <phongsplat/splat.h>

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The greatest size of a file that is read, so that byte offsets fit into 32 bits. */
#define PSPLAT_MAX_SOURCE_BYTES 0xffffffffu

/* Reads a whole file: a source file or an external buffer of a .gltf. *data is malloc'ed, has a 0
 * byte after its *size bytes, and belongs to the caller. Errors: PSPLAT_ERROR_READ,
 * PSPLAT_ERROR_RANGE (larger than PSPLAT_MAX_SOURCE_BYTES), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_file_read(const char *path, char **data, size_t *size, psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
