/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * materials.h - the materials of a file that is written.
 */
#ifndef PHONGSPLAT_MATERIALS_H
#define PHONGSPLAT_MATERIALS_H

#include "json_writer.h"
#include "scenes.h"

typedef struct psplat_named_material {
    psplat_material material;
    const char *name, *extras; /* the scene's; or NULL */
} psplat_named_material;

typedef struct psplat_materials {
    psplat_named_material *list;
    size_t count;
} psplat_materials;

/* Those that runs of the splats (by mesh of the scene) use, in the order of the scene's
 * appearances, each once; glTF's default is left out, unless it has a name. MEMORY is the only
 * failure. */
psplat_result psplat_materials_collect(const psplat_scene *scene, const psplat_splats *splats,
                                       psplat_materials *materials);
void psplat_materials_free(psplat_materials *materials);

/* Adds one that stands for an appearance of the scene. MEMORY. */
psplat_result psplat_materials_add(psplat_materials *materials, const psplat_scene *scene,
                                   const psplat_material *material, size_t appearance);

/* The index in the file of a material, which stands for an appearance, or PSPLAT_NO_INDEX: the
 * default. */
uint32_t psplat_materials_find(const psplat_materials *materials, const psplat_scene *scene,
                               const psplat_material *material, size_t appearance);
/* The index in the file of a mesh's material, or PSPLAT_NO_INDEX: the default. */
uint32_t psplat_materials_index(const psplat_materials *materials, const psplat_scene *scene,
                                const psplat_splats *splats, size_t material);

/* The names of the extensions that they use, into an array. */
void psplat_materials_write_extensions(psplat_writer *json, const psplat_materials *materials);
/* The member "materials" of the root, where there are any. */
void psplat_materials_write(psplat_writer *json, const psplat_materials *materials);

#endif
