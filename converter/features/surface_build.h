/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_build.h - the analysis of a mesh: it becomes a surface.
 */
#ifndef PHONGSPLAT_FEATURES_SURFACE_BUILD_H
#define PHONGSPLAT_FEATURES_SURFACE_BUILD_H

#include <phongsplat/splat.h>

#include "appearance/appearance.h"
#include "features/surface.h"
#include "mesh/mesh.h"

#include <math.h>

/* The crease angle with which only edges without a neighbour bound patches. */
#define PSPLAT_NO_CREASES HUGE_VAL

/* Builds the surface of a mesh, which must live as long. crease_angle, in radians, is the angle
 * between the normals of two triangles from which the edge between them is a crease.
 * psplat_surface_free releases *surface. Errors: PSPLAT_ERROR_NO_SPLATS (no triangles),
 * PSPLAT_ERROR_RANGE (too many), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_surface_build(const psplat_mesh *mesh, double crease_angle,
                                   psplat_surface *surface, psplat_error *error);

/* What bounds patches besides borders. */
typedef struct psplat_patch_bounds {
    double crease_angle; /* as above */
    /* Of the mesh; must live as long; or NULL. Where it keeps textures, the borders of their charts
     * bound patches too, whatever the crease angle is. */
    const psplat_appearance *appearance;
    /* The greatest distance of splats from the surface, a length: tangent edges over which they
     * would reach bound patches too (tangent_edges.h). 0: none do. */
    double tolerance;
} psplat_patch_bounds;

/* The same with these bounds. */
psplat_result psplat_surface_build_bounded(const psplat_mesh *mesh,
                                           const psplat_patch_bounds *bounds,
                                           psplat_surface *surface, psplat_error *error);

#endif
