/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_mesh.c - the source mesh of a comparison, with its creases, normals, triangle tree and
 * bounding sphere.
 */
#include "compare/source_mesh.h"

#include "base/angle.h"
#include "base/vector.h"
#include "compare/source_mesh_parts.h"
#include "features/surface.h"
#include "features/surface_build.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"

#include <math.h>
#include <stdlib.h>

static const double default_crease_degrees = 30; /* the default of psplat_convert_desc */

/* Finds a bounding sphere around the centre of the bounding box. It is not the smallest one, but it
 * depends only on the extreme points. */
static void bound(psplat_source_mesh *source) {
    const psplat_mesh *mesh = source->mesh;
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
    for (int k = 0; k < 3; ++k) source->center[k] = mesh->origin[k] + middle[k];
    source->radius = sqrt(square);
}

psplat_result psplat_source_mesh_create(const psplat_mesh *mesh, double crease_angle_degrees,
                                        psplat_source_mesh **source, psplat_error *error) {
    double angle = crease_angle_degrees > 0 ? crease_angle_degrees : default_crease_degrees;
    psplat_source_mesh *o = calloc(1, sizeof *o);
    *source = NULL;
    if (!o) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a mesh");
    o->mesh = mesh;
    psplat_result result = psplat_surface_build(mesh, angle * PSPLAT_DEGREE, &o->surface, error);
    if (!result) {
        bound(o);
        o->distance = psplat_distance_create_cgal(mesh);
        if (!o->distance)
            result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu triangles",
                                 mesh->triangle_count);
    }
    if (result)
        psplat_source_mesh_destroy(o);
    else
        *source = o;
    return result;
}

void psplat_source_mesh_destroy(psplat_source_mesh *source) {
    if (!source) return;
    psplat_distance_destroy(source->distance);
    psplat_surface_free(&source->surface);
    free(source);
}
