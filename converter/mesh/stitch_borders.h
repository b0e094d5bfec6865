/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * stitch_borders.h - stitching of borders that differ by rounding alone.
 */
#ifndef PHONGSPLAT_MESH_STITCH_BORDERS_H
#define PHONGSPLAT_MESH_STITCH_BORDERS_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Merges border vertices that differ by rounding alone. *closed is set if every edge belongs to
 * exactly two triangles afterwards. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_stitch_borders(psplat_mesh *mesh, int *closed, psplat_error *error);

#endif
