/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_materials.h - the materials of a source file, with their textures.
 */
#ifndef PHONGSPLAT_MATERIAL_SOURCE_MATERIALS_H
#define PHONGSPLAT_MATERIAL_SOURCE_MATERIALS_H

#include <phongsplat/splat.h>

#include "material/image.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The sets of texture coordinates that are read (TEXCOORD_0, TEXCOORD_1). */
#define PSPLAT_TEXCOORDS 2

/* The use of an image by a material. All zeros mean no texture. */
typedef struct psplat_texture_info {
    const psplat_image *image; /* owned by the scene, or NULL: no texture */
    psplat_wrap wrap[2];       /* of s and t */
    int nearest;               /* the magnification filter is NEAREST */
    uint32_t texcoord;         /* which texture coordinates of the mesh, below PSPLAT_TEXCOORDS */
    double transform[6];       /* KHR_texture_transform: rows of a 2 x 3 matrix of (s, t, 1) */
    float strength;            /* normal scale or occlusion strength */
} psplat_texture_info;

/* A material of the source file. Textures are baked relative to the factors, which stay factors. */
typedef struct psplat_source_material {
    psplat_material material; /* factors, and what its textures are once they are kept */
    psplat_texture_info base_color, metallic_roughness, normal, occlusion, emissive;
    int is_masked; /* alphaMode MASK */
    float alpha_cutoff;
    int is_blended; /* alphaMode BLEND; drawn opaque */
    char *name;     /* malloc'ed, or NULL */
    char *extras;   /* JSON, malloc'ed, or NULL */
} psplat_source_material;

/* All materials of a file. */
typedef struct psplat_source_materials {
    psplat_source_material *source_materials;
    size_t source_material_count;
    psplat_image *images; /* the textures of source_materials point to them */
    size_t image_count;
    char *problem; /* why a material library (.mtl) could not be read, malloc'ed; or NULL */
} psplat_source_materials;

/* Returns the texture of a slot; its image is NULL where the material has none there. */
const psplat_texture_info *psplat_source_texture(const psplat_source_material *material,
                                                 psplat_texture_slot slot);

/* Fills the textures of every psplat_source_material.material from the uses of images that baking
 * reads: those whose image has pixels. Its texture coordinates are those of psplat_texture_info,
 * which psplat_texture does not name. */
void psplat_source_materials_describe_textures(psplat_source_materials *materials);

/* Frees what materials holds and makes it zero. */
void psplat_source_materials_free(psplat_source_materials *materials);

#ifdef __cplusplus
}
#endif
#endif
