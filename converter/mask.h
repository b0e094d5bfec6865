/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * mask.h - meshes without what their alpha masks hide. Internal, and for compare.
 */
#ifndef PSPLAT_MASK_H
#define PSPLAT_MASK_H

#include "paint.h"
#include "source.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Whether a triangle of the mesh has a material with a mask. */
int psplat_mask_is_needed(const psplat_mesh *mesh);
/* The part of a mesh that its masks show; triangles at their edges have edges no longer than the
 * step. Appearances stay where they are; shown is the caller's to free, and zero where it fails:
 * MEMORY, RANGE, NO_SPLATS (all is hidden). */
psplat_result psplat_mask_cut(const psplat_mesh *mesh, double step, psplat_mesh *shown,
                              psplat_error *error);

/* Replaces a mesh by what its masks show; triangles as above, the step in % of its diagonal. Stays
 * as it is where it fails. */
psplat_result psplat_mask_apply(psplat_mesh *mesh, double step_percent, psplat_error *error);
/* Diagonal of a mesh's bounding box. */
double psplat_mask_diagonal(const psplat_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif
