/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * openmesh.h - the reader of OBJ, PLY, OFF and STL files, through OpenMesh.
 */
#ifndef PHONGSPLAT_IMPORT_OPENMESH_H
#define PHONGSPLAT_IMPORT_OPENMESH_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "points/points.h"
#include "source/source_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a file that the checks (check.h) have passed as a raw mesh: neither welded nor recentred,
 * every index in range, polygons triangulated. mesh->dropped counts the faces that were left out.
 * The caller frees the mesh, also after an error. Errors: FORMAT, RANGE, MEMORY. */
psplat_result psplat_mesh_read_openmesh(const psplat_source *source, psplat_mesh *mesh,
                                        psplat_error *error);

/* Reads a PLY or OFF without faces, which the checks have passed, as a point set. The caller frees
 * the points, also after an error. Errors: FORMAT, MEMORY. */
psplat_result psplat_points_read_openmesh(const psplat_source *source, psplat_points *points,
                                          psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
