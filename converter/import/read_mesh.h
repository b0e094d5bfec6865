/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * read_mesh.h - the mesh import: a file of any supported format as one clean mesh.
 */
#ifndef PHONGSPLAT_IMPORT_READ_MESH_H
#define PHONGSPLAT_IMPORT_READ_MESH_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "source/source_file.h"

/* Reads a file whose format is found by its content first and its extension second (.obj .ply .off
 * .stl .gltf .glb .xyz .pts .asc). Checks indices and that every used coordinate is finite, welds
 * vertices of equal position, orients triangles consistently, drops those without area, and
 * recentres. XYZ files, and PLY and OFF files without faces, are point sets, through which a
 * surface is reconstructed. The caller frees *mesh with psplat_mesh_free; after an error it is
 * empty. Error texts name the place. Errors: ARGUMENT, READ, FORMAT, RANGE, UNSUPPORTED, NO_SPLATS
 * (no triangle with area, or no surface through the points), MEMORY. */
psplat_result psplat_mesh_read(const char *path, psplat_mesh *mesh, psplat_error *error);

/* Does the same for a loaded file; *mesh must be zero-initialised. The caller frees the mesh, also
 * after an error. */
psplat_result psplat_mesh_from_source(psplat_source *source, psplat_mesh *mesh,
                                      psplat_error *error);

#endif
