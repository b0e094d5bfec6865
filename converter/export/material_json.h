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

/* The materials of a file and their textures, each once. A texture in a file is an image with a
 * sampler; transform and strength belong to its use. */
typedef struct psplat_materials {
    psplat_named_material *list;
    size_t count;
    psplat_texture *textures; /* of which image, wrap and nearest count */
    size_t texture_count;
    psplat_texture *samplers; /* of which wrap and nearest count; glTF's default is none of them */
    size_t sampler_count;
    uint32_t *images; /* indices of the scene's images */
    size_t image_count;
    int has_splats; /* 0: the file holds triangles alone, whose normal textures are glTF's own */
} psplat_materials;

/* Collects the materials that runs of splats use, each once, in the order of the scene's
 * source_materials; those of runs without texture coordinates without textures. splats has one
 * element for each mesh of the scene. glTF's default material is left out unless it has a name or
 * extras. The caller frees *materials with psplat_materials_free. Errors: MEMORY. */
psplat_result psplat_materials_collect(const psplat_scene *scene, const psplat_splats *splats,
                                       psplat_materials *materials);
void psplat_materials_free(psplat_materials *materials);

/* Adds a material and its textures unless it is there or is glTF's default; name and extras are
 * those of the scene's source_material of this index. Errors: MEMORY. */
psplat_result psplat_materials_add(psplat_materials *materials, const psplat_scene *scene,
                                   const psplat_material *material, size_t source_material);

/* Returns the index in the file of a material added with this source_material, or PSPLAT_NO_INDEX
 * for glTF's default. */
uint32_t psplat_materials_find(const psplat_materials *materials, const psplat_scene *scene,
                               const psplat_material *material, size_t source_material);
/* Returns the index in the file of one of the splats' materials, or PSPLAT_NO_INDEX for glTF's
 * default. It has textures where the splats have texture coordinates. */
uint32_t psplat_materials_index(const psplat_materials *materials, const psplat_scene *scene,
                                const psplat_splats *splats, size_t material, int has_texcoord);

/* Writes the names of the extensions that the materials use as elements of an array. */
void psplat_materials_write_extensions(psplat_writer *json, const psplat_materials *materials);
/* Writes the members "materials", "textures", "samplers" and "images" of the root, those that there
 * are. The images lie in consecutive buffer views from first_view on. */
void psplat_materials_write(psplat_writer *json, const psplat_materials *materials,
                            const psplat_scene *scene, size_t first_view);

#endif
