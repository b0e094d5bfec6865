/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * surface_build.h - the analysis of a mesh: it becomes a surface.
 */
#ifndef PHONGSPLAT_FEATURES_SURFACE_BUILD_H
#define PHONGSPLAT_FEATURES_SURFACE_BUILD_H

#include <phongsplat/splat.h>

#include "features/crease.h"
#include "features/surface.h"
#include "mesh/mesh.h"

/* Builds the surface of a mesh, which must live as long. crease_angle, in radians, is the angle
 * between the normals of two triangles from which the edge between them is a crease.
 * psplat_surface_free releases *surface. Errors: PSPLAT_ERROR_NO_SPLATS (no triangles),
 * PSPLAT_ERROR_RANGE (too many), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_surface_build(const psplat_mesh *mesh, double crease_angle,
                                   psplat_surface *surface, psplat_error *error);

/* The same with these bounds. */
psplat_result psplat_surface_build_bounded(const psplat_mesh *mesh,
                                           const psplat_patch_bounds *bounds,
                                           psplat_surface *surface, psplat_error *error);

#endif
