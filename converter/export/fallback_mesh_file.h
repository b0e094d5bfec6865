/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * fallback_mesh_file.h - fallback meshes in a glTF file: buffer views, accessors, meshes
 * (spec 6.1).
 *
 * They lie behind the splats: gltf_document.c writes the views, accessors and meshes of splats
 * first.
 */
#ifndef PHONGSPLAT_EXPORT_FALLBACK_MESH_FILE_H
#define PHONGSPLAT_EXPORT_FALLBACK_MESH_FILE_H

#include "base/json_writer.h"
#include "export/buffer_layout.h"
#include "export/fallback_mesh.h"
#include "export/material_json.h"
#include "export/meshopt_codec.h"
#include "export/splat_attributes.h"
#include "scene/scene.h"

#include <phongsplat/splat.h>

/* One fallback mesh as stored. Its views follow one another: positions, normals, colours and
 * texture coordinates if it has any, indices. Its accessors follow one another in the same order,
 * with one accessor for the indices of each primitive. */
typedef struct psplat_fallback_table {
    const psplat_fallback_mesh *fallback; /* NULL if the mesh has no fallback mesh */
    psplat_attribute_format position, normal, texcoord;
    float low[3], high[3];             /* bounds of the positions as written */
    size_t first_view, first_accessor; /* among those of all fallback meshes */
} psplat_fallback_table;

/* All fallback meshes of a file. A zero-initialised struct has none. */
typedef struct psplat_fallback_file {
    psplat_fallback_table *tables; /* mesh_count of them, as there are attribute tables */
    psplat_buffer_view *views;
    size_t mesh_count, view_count, accessor_count;
} psplat_fallback_file;

/* Stores the fallback meshes in the coordinates of the splats of their meshes, and in their units
 * if the splats are quantized; those of meshes without splats only where no mesh has any. A codec
 * of NULL leaves the views uncompressed. fallbacks must outlive *file. The caller frees *file with
 * psplat_fallback_file_free, also after an error. Errors: MEMORY. */
psplat_result psplat_fallback_file_make(const psplat_fallback_mesh *fallbacks,
                                        const psplat_attribute_table *tables, size_t mesh_count,
                                        const psplat_codec *codec, psplat_fallback_file *file,
                                        psplat_error *error);
void psplat_fallback_file_free(psplat_fallback_file *file);

/* Adds the materials of the fallback meshes. Errors: MEMORY. */
psplat_result psplat_fallback_file_collect(const psplat_fallback_file *file,
                                           const psplat_scene *scene, psplat_materials *materials);

/* Writes the members of an element of "meshes". first_accessor is the index in the file of the
 * first accessor of all fallback meshes, splat_mesh that of the mesh with the splats, or
 * PSPLAT_NO_INDEX. */
void psplat_fallback_file_write_mesh(psplat_writer *json, const psplat_fallback_table *table,
                                     const psplat_scene *scene, const psplat_materials *materials,
                                     size_t first_accessor, size_t splat_mesh);
/* Writes elements of "accessors". first_view is the index in the file of the first view of all
 * fallback meshes. */
void psplat_fallback_file_write_accessors(psplat_writer *json, const psplat_fallback_file *file,
                                          size_t first_view);

#endif
