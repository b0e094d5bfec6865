/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * material_json.h - the materials of a glTF file of splats: those that are used, and their JSON.
 */
#ifndef PHONGSPLAT_EXPORT_MATERIAL_JSON_H
#define PHONGSPLAT_EXPORT_MATERIAL_JSON_H

#include "base/json_writer.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <phongsplat/splat.h>

typedef struct psplat_named_material {
    psplat_material material;
    const char *name, *extras; /* owned by the scene, or NULL */
} psplat_named_material;

typedef struct psplat_materials {
    psplat_named_material *list;
    size_t count;
} psplat_materials;

/* Collects the materials that runs of splats use, each once, in the order of the scene's
 * source_materials. splats has one element for each mesh of the scene. glTF's default material is
 * left out unless it has a name or extras. The caller frees *materials with psplat_materials_free.
 * Errors: MEMORY. */
psplat_result psplat_materials_collect(const psplat_scene *scene, const psplat_splats *splats,
                                       psplat_materials *materials);
void psplat_materials_free(psplat_materials *materials);

/* Adds a material unless it is there or is glTF's default; name and extras are those of the scene's
 * source_material of this index. Errors: MEMORY. */
psplat_result psplat_materials_add(psplat_materials *materials, const psplat_scene *scene,
                                   const psplat_material *material, size_t source_material);

/* Returns the index in the file of a material added with this source_material, or PSPLAT_NO_INDEX
 * for glTF's default. */
uint32_t psplat_materials_find(const psplat_materials *materials, const psplat_scene *scene,
                               const psplat_material *material, size_t source_material);
/* Returns the index in the file of one of the splats' materials, or PSPLAT_NO_INDEX for glTF's
 * default. */
uint32_t psplat_materials_index(const psplat_materials *materials, const psplat_scene *scene,
                                const psplat_splats *splats, size_t material);

/* Writes the names of the extensions that the materials use as elements of an array. */
void psplat_materials_write_extensions(psplat_writer *json, const psplat_materials *materials);
/* Writes the member "materials" of the root, if there are any. */
void psplat_materials_write(psplat_writer *json, const psplat_materials *materials);

#endif
