/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_mesh_parts.h - the members of psplat_source_mesh, for code that measures or draws it.
 */
#ifndef PHONGSPLAT_COMPARE_SOURCE_MESH_PARTS_H
#define PHONGSPLAT_COMPARE_SOURCE_MESH_PARTS_H

#include "compare/source_mesh.h"
#include "features/surface.h"
#include "mesh/distance.h"
#include "mesh/mesh.h"

struct psplat_source_mesh {
    const psplat_mesh *mesh; /* owned by the caller */
    psplat_surface surface;
    psplat_distance *distance;
    double center[3], radius; /* of a bounding sphere, in the coordinates of the file */
};

#endif
