/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * alpha_mask.h - alpha masks (glTF alphaMode MASK) as geometry: the hidden part is cut away.
 */
#ifndef PHONGSPLAT_APPEARANCE_ALPHA_MASK_H
#define PHONGSPLAT_APPEARANCE_ALPHA_MASK_H

#include "mesh/mesh.h"

#include <phongsplat/splat.h>

/* Returns whether a triangle of the mesh has a material with a mask. */
int psplat_alpha_mask_is_needed(const psplat_mesh *mesh);

/* Stores in *shown the part of a mesh that its masks show. Triangles that the edge of a mask
 * crosses are first refined until their edges are no longer than step, in units of the mesh. The
 * materials keep their owner. The caller frees *shown, which is zero on failure. Errors:
 * PSPLAT_ERROR_RANGE, PSPLAT_ERROR_NO_SPLATS (all is hidden), PSPLAT_ERROR_MEMORY. */
psplat_result psplat_alpha_mask_cut(const psplat_mesh *mesh, double step, psplat_mesh *shown,
                                    psplat_error *error);

/* Replaces a mesh by the part that its masks show, with a step in % of its diagonal. The mesh stays
 * as it is on failure, with the errors above. */
psplat_result psplat_alpha_mask_apply(psplat_mesh *mesh, double step_percent, psplat_error *error);

/* Returns the diagonal of a mesh's bounding box, or 0 without vertices. */
double psplat_mesh_diagonal(const psplat_mesh *mesh);

#endif
