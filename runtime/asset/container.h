/* SPDX-License-Identifier: MIT
 * container.h - the two parts of a glTF file: JSON and binary, from a GLB or from a bare .gltf. */
#ifndef PHONGSPLAT_ASSET_CONTAINER_H
#define PHONGSPLAT_ASSET_CONTAINER_H

#include <phongsplat/phongsplat.h>

/* Ranges of the file's bytes. */
typedef struct psplat_container {
    size_t json_offset, json_size;
    size_t bin_offset, bin_size; /* bin_size 0: no BIN chunk */
} psplat_container;

/* Fails with FORMAT where the bytes are neither a GLB nor the beginning of a JSON object, with
 * RANGE where a chunk leaves the file, and with UNSUPPORTED for a GLB version other than 2. */
psplat_result psplat_container_parse(const uint8_t *data, size_t size, psplat_container *container,
                                     psplat_error *error);

#endif
