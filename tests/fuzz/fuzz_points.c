/* SPDX-License-Identifier: MIT
 *
 * fuzz_points.c - reads any bytes as a file of points: XYZ, and PLY and OFF without faces.
 */
#include "mesh_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_mesh(data, size, NULL);
    return 0;
}
