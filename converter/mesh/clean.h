/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * clean.h - mesh cleaning: checked, welded, oriented, without degenerate triangles.
 */
#ifndef PHONGSPLAT_MESH_CLEAN_H
#define PHONGSPLAT_MESH_CLEAN_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Turns a raw mesh into what psplat_mesh_read promises. label names the mesh in errors. Unless
 * has_material is set, the mesh gets the default material, which depends on its colours and on
 * whether it is closed. Errors: PSPLAT_ERROR_RANGE (an index or a coordinate),
 * PSPLAT_ERROR_NO_SPLATS (no triangle has an area), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_clean(psplat_mesh *mesh, const char *label, int has_material,
                                psplat_error *error);

/* Returns the default material of a mesh whose file has none: light grey with a soft highlight, or
 * white if the corners have colours, since the colours are multiplied by it. */
psplat_material psplat_mesh_usual_material(const psplat_mesh *mesh);

/* Gives the mesh the default material, double-sided unless the mesh is closed. */
void psplat_mesh_set_usual_material(psplat_mesh *mesh, int closed);

/* Replaces equal colours of all corners by a factor of the base colour, so that splats need no
 * colours of their own. Does nothing if the mesh refers to materials of its file. */
void psplat_mesh_hoist_uniform_color(psplat_mesh *mesh);

#endif
