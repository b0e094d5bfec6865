/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * obj_mesh.h - the mesh of an OBJ file from what its check has kept.
 */
#ifndef PHONGSPLAT_IMPORT_OBJ_MESH_H
#define PHONGSPLAT_IMPORT_OBJ_MESH_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "source/source_file.h"

/* Makes a raw mesh of a source that psplat_check_obj has accepted: its polygons as triangles, with
 * normals, and with groups and texture coordinates if it names materials. Colours of vertices are
 * left out. The positions move from the source to the mesh. Errors: PSPLAT_ERROR_RANGE (too many
 * triangles), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_read_obj(psplat_source *source, psplat_mesh *mesh, psplat_error *error);

#endif
