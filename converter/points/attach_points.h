/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * attach_points.h - the mesh of a reconstructed point set, with a triangle for every point.
 */
#ifndef PHONGSPLAT_POINTS_ATTACH_POINTS_H
#define PHONGSPLAT_POINTS_ATTACH_POINTS_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "points/point_cloud.h"

/* Makes the mesh of a cloud whose front is known, and assigns every point the triangle that it
 * belongs to. Points that are too far from the front get a small disc of triangles of their own.
 * Errors: PSPLAT_ERROR_RANGE (too many triangles), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_points_attach(const psplat_point_cloud *cloud, psplat_mesh *mesh,
                                   psplat_error *error);

#endif
