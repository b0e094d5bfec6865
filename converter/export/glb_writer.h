/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * glb_writer.h - the glTF writer: splats, alone or in a scene, or a scene's meshes as a complete
 * GLB.
 */
#ifndef PHONGSPLAT_EXPORT_GLB_WRITER_H
#define PHONGSPLAT_EXPORT_GLB_WRITER_H

#include <phongsplat/splat.h>

#include "export/meshopt_codec.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <stdint.h>

/* What a file is to hold besides splats, and how it is compressed. Zeros are the defaults. */
typedef struct psplat_write_desc {
    const psplat_codec *codec; /* compresses the buffer views; NULL leaves them as they are */
    const struct psplat_fallback_mesh *fallbacks; /* one for each mesh of the scene; NULL: none */
    /* For each mesh of the scene a Gaussian for each splat, written beside it; NULL: none. */
    const struct psplat_gaussian *const *gaussians;
    /* Levels of detail of each mesh of the scene (mesh_levels.h), whose finest is in splats; NULL:
       none. */
    const struct psplat_mesh_levels *levels;
} psplat_write_desc;

/* Serialises the scene's graph with triangles alone, of psplat_scene_whole_meshes, as a GLB that
 * knows no splats into *data, allocated with malloc and owned by the caller. codec is required.
 * Errors: RANGE (more than 4 GiB), ARGUMENT (a texture whose image the scene has not), MEMORY. */
psplat_result psplat_scene_write_meshes(const psplat_scene *scene,
                                        const struct psplat_fallback_mesh *meshes,
                                        const psplat_codec *codec, uint8_t **data, size_t *size,
                                        psplat_error *error);

/* Serialises splats as a complete GLB (spec 3) of one mesh and one node into *data, allocated with
 * malloc and owned by the caller. It touches no file. name, which may be NULL, becomes the name of
 * the node and of the mesh. desc and the errors are those of psplat_scene_write. */
psplat_result psplat_glb_write(const psplat_splats *splats, const char *name,
                               const psplat_write_desc *desc, uint8_t **data, size_t *size,
                               psplat_error *error);

/* Serialises the scene's graph with splats (by mesh) where its meshes were as a complete GLB (spec
 * 3) into *data, allocated with malloc and owned by the caller, in the layout that takes the fewest
 * bytes. It touches no file. desc may be NULL. Errors: ARGUMENT (runs and splats that contradict
 * each other), RANGE (a value that is not finite, or more than 4 GiB), NO_SPLATS, MEMORY. */
psplat_result psplat_scene_write(const psplat_scene *scene, const psplat_splats *splats,
                                 const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                 psplat_error *error);

#endif
