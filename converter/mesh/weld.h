/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * weld.h - vertex welding, and dropping of degenerate and repeated triangles.
 */
#ifndef PHONGSPLAT_MESH_WELD_H
#define PHONGSPLAT_MESH_WELD_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"

/* Merges vertices of exactly equal position, drops vertices that no triangle uses and triangles
 * that have less than three different vertices. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_weld(psplat_mesh *mesh, psplat_error *error);

/* Keeps the first of several triangles with the same vertices. Where others face the other way,
 * both sides of the one that is kept are visible: both_sides of its group and *turned are set. But
 * the first of either way is kept, and *two_sides set, where two look different, by their groups,
 * colours, or coordinates of textures, and, with has_material, in groups that have triangles which
 * exist one way only, too; not where a material is double-sided. has_material says that materials
 * of the file tell which sides are seen. Fails only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_mesh_drop_repeated(psplat_mesh *mesh, int has_material, int *turned,
                                        int *two_sides, psplat_error *error);

/* Drops triangles whose area is zero up to rounding. */
void psplat_mesh_drop_flat(psplat_mesh *mesh);

#endif
