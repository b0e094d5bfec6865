/* SPDX-License-Identifier: MIT
 *
 * level.h - the levels of detail of a document (spec 3.13).
 */
#ifndef PHONGSPLAT_ASSET_LEVEL_H
#define PHONGSPLAT_ASSET_LEVEL_H

#include "asset/gltf.h"

/* Remembers the list of levels in the extension object of a primitive, whose splats are not decoded
 * yet, if there is one. Errors: FORMAT where the mesh has splats already. */
psplat_result psplat_levels_note(const psplat_gltf *gltf, psplat_json_value extension,
                                 psplat_mesh_sets *sets);

/* Reads the lists, when all meshes have been decoded and stand-ins have been resolved. Errors:
 * FORMAT, RANGE, MEMORY. */
psplat_result psplat_levels_resolve(psplat_gltf *gltf);

/* Returns the number of levels of the mesh with the most that the scene shows, at least 1. */
size_t psplat_levels_count(const psplat_gltf *gltf);

/* Raises the errors of count levels, zeroed by the caller, to those of the scene's meshes. Errors:
 * RANGE. */
psplat_result psplat_levels_measure(const psplat_gltf *gltf, psplat_level *levels, size_t count);

#endif
