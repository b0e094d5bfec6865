/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * shells.h - closed shells that face inwards are turned outwards.
 */
#ifndef PHONGSPLAT_MESH_SHELLS_H
#define PHONGSPLAT_MESH_SHELLS_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Turns closed components whose signed volume is negative, with the normals of their corners, and
 * counts them in turned_shells and turned_triangles of the mesh. Two kinds stay as they are: a
 * cavity, which lies inside a closed component that faces outwards, and a room, which holds parts
 * that are open or face outwards, or other meshes (mesh->holds_parts); rooms are counted in
 * kept_rooms. The mesh is oriented (psplat_mesh_orient). Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_turn_shells(psplat_mesh *mesh, psplat_error *error);

#endif
