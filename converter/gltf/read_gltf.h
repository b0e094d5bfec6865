/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * read_gltf.h - the reader of glTF and GLB files, through tinygltf.
 */
#ifndef PHONGSPLAT_GLTF_READ_GLTF_H
#define PHONGSPLAT_GLTF_READ_GLTF_H

#include <phongsplat/splat.h>

#include "mesh/mesh.h"
#include "scene/scene.h"
#include "source/source_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the triangles of the default scene as one raw mesh, with the transforms of its nodes
 * applied: neither welded nor recentred, every index in range. The caller frees the mesh, also
 * after an error. Errors: FORMAT, RANGE, UNSUPPORTED, NO_SPLATS (no triangles), MEMORY. */
psplat_result psplat_mesh_read_gltf(const psplat_source *source, psplat_mesh *mesh,
                                    psplat_error *error);

/* Reads the whole scene: each mesh raw, in its own coordinates, and nodes, scenes, cameras, lights,
 * materials and warnings of what is dropped. *scene must be zero-initialised; the caller frees it,
 * also after an error. Errors: FORMAT, RANGE, UNSUPPORTED, MEMORY. */
psplat_result psplat_scene_read_gltf(const psplat_source *source, psplat_scene *scene,
                                     psplat_error *error);

#ifdef __cplusplus
}
#endif
#endif
