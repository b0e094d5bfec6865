/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * gltf_document.h - the JSON of a glTF file of splats, made from a buffer layout (buffer_layout.h).
 */
#ifndef PHONGSPLAT_EXPORT_GLTF_DOCUMENT_H
#define PHONGSPLAT_EXPORT_GLTF_DOCUMENT_H

#include "base/json_writer.h"
#include "export/buffer_layout.h"
#include "scene/scene.h"

/* The buffer views of a file are those of the splats, then those of the fallback meshes. */
size_t psplat_document_view_count(const psplat_buffer_layout *layout);
const psplat_buffer_view *psplat_document_view(const psplat_buffer_layout *layout, size_t index);
/* Returns the bytes of the binary chunk that a view takes, with its padding. */
size_t psplat_buffer_view_bytes(const psplat_buffer_view *view);
/* Writes the whole document and finishes it. The splats of layout's attribute tables must lie one
 * after another in one array. Returns 0 where memory ran out. */
int psplat_document_write(psplat_writer *json, const psplat_scene *scene,
                          const psplat_buffer_layout *layout);

#endif
