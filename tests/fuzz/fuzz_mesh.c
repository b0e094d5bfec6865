/* SPDX-License-Identifier: MIT
 *
 * fuzz_mesh.c - reads any bytes as a mesh file: OBJ, PLY, OFF, STL, glTF and GLB.
 */
#include "mesh_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_mesh(data, size, NULL);
    return 0;
}
