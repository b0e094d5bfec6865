/* SPDX-License-Identifier: MIT
 *
 * fuzz_points.c - any bytes as a file of points: XYZ, and PLY and OFF without faces. Points that
 * are read are checked and go no further, since connecting them takes a hundred times as long; see
 * fuzz_cloud.c.
 */
#include "mesh_input.h"

#include <math.h>

/* The linker's name (--wrap). */
psplat_result __wrap_psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                             psplat_error *error);

psplat_result __wrap_psplat_mesh_from_points(const psplat_points *points, psplat_mesh *mesh,
                                             psplat_error *error) {
    *mesh = (psplat_mesh){0};
    for (size_t i = 0; i < 3 * points->count; ++i) FUZZ_DEMAND(isfinite(points->positions[i]));
    for (size_t i = 0; i < 4 * points->count && points->colors; ++i)
        FUZZ_DEMAND(points->colors[i] >= 0 && points->colors[i] <= 1);
    /* Of any length or none, but there. */
    float sum = 0;
    for (size_t i = 0; i < 3 * points->count && points->normals; ++i) sum += points->normals[i];
    return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "%zu points of sum %g", points->count,
                       (double)sum);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_mesh(data, size, NULL);
    return 0;
}
