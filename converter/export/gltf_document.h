/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gltf_document.h - the JSON of a glTF file of splats, made from a buffer layout (buffer_layout.h).
 */
#ifndef PHONGSPLAT_EXPORT_GLTF_DOCUMENT_H
#define PHONGSPLAT_EXPORT_GLTF_DOCUMENT_H

#include "base/json_writer.h"
#include "export/buffer_layout.h"
#include "export/material_json.h"
#include "material/image.h"
#include "scene/scene.h"

/* The buffer views of a file are those of the splats, those of the fallback meshes and those of
 * animations, which these functions count and return, and then one for each image. */
size_t psplat_document_view_count(const psplat_buffer_layout *layout);
const psplat_buffer_view *psplat_document_view(const psplat_buffer_layout *layout, size_t index);
/* Returns the bytes of the binary chunk that a view takes, with its padding. */
size_t psplat_buffer_view_bytes(const psplat_buffer_view *view);
size_t psplat_image_view_bytes(const psplat_image *image);

/* Collects the materials of the splats of layout's attribute tables, which must lie one after
 * another in one array, and of its fallback meshes. The caller frees *materials with
 * psplat_materials_free, also after an error. Errors: MEMORY, ARGUMENT (a texture whose image the
 * scene has not). */
psplat_result psplat_document_materials(const psplat_scene *scene,
                                        const psplat_buffer_layout *layout,
                                        psplat_materials *materials, psplat_error *error);
/* Writes the whole document and finishes it. Returns 0 where memory ran out. */
int psplat_document_write(psplat_writer *json, const psplat_scene *scene,
                          const psplat_buffer_layout *layout, const psplat_materials *materials);

#endif
