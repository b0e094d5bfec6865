/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * curvature.h - signed dihedral angles of edges, and noise and roughness of the surface around
 * them.
 */
#ifndef PHONGSPLAT_FEATURES_CURVATURE_H
#define PHONGSPLAT_FEATURES_CURVATURE_H

#include <phongsplat/splat.h>

#include "features/surface.h"

/* Angles in radians. The dihedral angle of an edge is the angle between the normals of its
 * triangles: 0 if the surface is flat, positive if it is convex, and 0 also without a neighbour. */
typedef struct psplat_curvature {
    float *angles; /* triangle_count x 3: of the mesh as it is */
    float *noise;  /* triangle_count: root mean square of the angles that noise makes */
    /* After noise has been removed from the normals: */
    double *smooth_normals; /* triangle_count x 3, unit */
    float *smooth_angles;   /* triangle_count x 3 */
    float *roughness;       /* triangle_count: root mean square of angles below the crease angle */
} psplat_curvature;

/* Measures a surface whose neighbours are known. Angles of crease_angle or more, in radians, count
 * neither as noise nor as roughness. Fails only with PSPLAT_ERROR_MEMORY; call
 * psplat_curvature_free also then. */
psplat_result psplat_curvature_measure(const psplat_surface *surface, double crease_angle,
                                       psplat_curvature *curvature);

void psplat_curvature_free(psplat_curvature *curvature);

#endif
