/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * glb_writer.h - splats as a complete GLB.
 */
#ifndef PHONGSPLAT_EXPORT_GLB_WRITER_H
#define PHONGSPLAT_EXPORT_GLB_WRITER_H

#include <phongsplat/splat.h>

#include "export/meshopt_codec.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <stdint.h>

/* Zeros are the defaults. */
typedef struct psplat_write_desc {
    const psplat_codec *codec;                    /* NULL: not compressed */
    const struct psplat_fallback_mesh *fallbacks; /* by mesh (fallback_mesh.h); NULL: none */
    /* Of each splat of each mesh (khr_gaussians.h), written beside ours; NULL: none. */
    const struct psplat_gaussian *const *gaussians;
} psplat_write_desc;

/* Serialises splats as a complete GLB (spec 3) of one mesh and one node into *data, allocated with
 * malloc and owned by the caller. Pure: no file is touched. name (may be NULL) becomes the node's
 * and the mesh's name. desc as of psplat_scene_write, whose errors it has. */
psplat_result psplat_glb_write_as(const psplat_splats *splats, const char *name,
                                  const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                  psplat_error *error);

/* Serialises the scene's graph with splats (by mesh) where its meshes were as a complete GLB (spec
 * 3) into *data, allocated with malloc and owned by the caller, in the layout that takes the fewest
 * bytes. desc may be NULL. Pure: no file is touched. */
psplat_result psplat_scene_write(const psplat_scene *scene, const psplat_splats *splats,
                                 const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                 psplat_error *error);

#endif
