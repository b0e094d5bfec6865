/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * original.c - the mesh that is compared with: its creases, normals and triangles.
 */
#include "original.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

static const double degree = 3.141592653589793 / 180;
static const double default_crease_angle = 30; /* as psplat_convert_desc has it */

/* Around the middle of the box: not the smallest sphere, but one that depends on nothing but the
 * extremes. */
static void bound(psplat_original *original) {
    const psplat_mesh *mesh = original->mesh;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double middle[3], square = 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            double x = mesh->positions[3 * (size_t)mesh->triangles[i] + k];
            low[k] = min2(low[k], x);
            high[k] = max2(high[k], x);
        }
    for (int k = 0; k < 3; ++k) middle[k] = 0.5 * (low[k] + high[k]);
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        double d[3];
        sub3(d, mesh->positions + 3 * (size_t)mesh->triangles[i], middle);
        square = max2(square, dot3(d, d));
    }
    for (int k = 0; k < 3; ++k) original->center[k] = mesh->origin[k] + middle[k];
    original->radius = sqrt(square);
}

psplat_result psplat_original_create(const psplat_mesh *mesh, double crease_angle_degrees,
                                     psplat_original **original, psplat_error *error) {
    double angle = crease_angle_degrees > 0 ? crease_angle_degrees : default_crease_angle;
    psplat_original *o = calloc(1, sizeof *o);
    *original = NULL;
    if (!o) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a mesh");
    o->mesh = mesh;
    psplat_result result = psplat_surface_build(mesh, angle * degree, &o->surface, error);
    if (!result) {
        bound(o);
        o->distance = psplat_distance_create(mesh);
        if (!o->distance)
            result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu triangles",
                                 mesh->triangle_count);
    }
    if (result)
        psplat_original_destroy(o);
    else
        *original = o;
    return result;
}

void psplat_original_destroy(psplat_original *original) {
    if (!original) return;
    psplat_distance_destroy(original->distance);
    psplat_surface_free(&original->surface);
    free(original);
}
