/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * source_materials.c - the textures of the materials of a source file, and the release of both.
 */
#include "material/source_materials.h"

#include "material/image.h"

#include <stdlib.h>
#include <string.h>

const psplat_texture_info *psplat_source_texture(const psplat_source_material *material,
                                                 psplat_texture_slot slot) {
    const psplat_texture_info *const textures[PSPLAT_TEXTURE_SLOTS] = {
        [PSPLAT_TEXTURE_BASE_COLOR] = &material->base_color,
        [PSPLAT_TEXTURE_METALLIC_ROUGHNESS] = &material->metallic_roughness,
        [PSPLAT_TEXTURE_NORMAL] = &material->normal,
        [PSPLAT_TEXTURE_OCCLUSION] = &material->occlusion,
        [PSPLAT_TEXTURE_EMISSIVE] = &material->emissive};
    return textures[slot];
}

static psplat_texture describe_texture(const psplat_source_materials *materials,
                                       const psplat_texture_info *texture) {
    static const double identity[6] = {1, 0, 0, 0, 1, 0};
    psplat_texture out = {.wrap = {texture->wrap[0], texture->wrap[1]},
                          .nearest = texture->nearest,
                          .strength = texture->strength};
    if (!texture->image || !texture->image->pixels) return (psplat_texture){0};
    out.image = 1 + (uint32_t)(texture->image - materials->images);
    if (memcmp(texture->transform, identity, sizeof identity) != 0)
        for (int k = 0; k < 6; ++k) out.transform[k] = (float)texture->transform[k];
    return out;
}

void psplat_source_materials_describe_textures(psplat_source_materials *materials) {
    for (size_t i = 0; i < materials->source_material_count; ++i) {
        psplat_source_material *m = &materials->source_materials[i];
        for (psplat_texture_slot slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
            m->material.textures[slot] =
                describe_texture(materials, psplat_source_texture(m, slot));
    }
}

void psplat_source_materials_free(psplat_source_materials *materials) {
    if (!materials) return;
    for (size_t i = 0; i < materials->source_material_count; ++i) {
        free(materials->source_materials[i].name);
        free(materials->source_materials[i].extras);
    }
    for (size_t i = 0; i < materials->image_count; ++i) psplat_image_free(&materials->images[i]);
    free(materials->source_materials);
    free(materials->images);
    free(materials->problem);
    *materials = (psplat_source_materials){0};
}
