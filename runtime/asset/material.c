/* SPDX-License-Identifier: MIT
 *
 * material.c - the factors of glTF materials (glTF 2.0 section 3.9). Textures are not read, because
 * splats have no texture coordinates.
 */
#include "asset/gltf.h"

static const psplat_material default_material = {
    .base_color = {1, 1, 1, 1}, .metallic = 1, .roughness = 1};

/* Reads up to four factors from 0 to 1. */
static psplat_result parse_factors(const psplat_gltf *gltf, psplat_json_value value,
                                   const char *what, size_t count, float *factors) {
    double numbers[4];
    if (!value) return PSPLAT_OK;
    psplat_result result = count == 1
                               ? psplat_json_number(&gltf->json, value, what, numbers)
                               : psplat_json_numbers(&gltf->json, value, what, count, numbers);
    if (result) return result;
    for (size_t i = 0; i < count; ++i) {
        if (numbers[i] < 0 || numbers[i] > 1)
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                               "%s must be from 0 to 1", what);
        factors[i] = (float)numbers[i];
    }
    return PSPLAT_OK;
}

static psplat_result parse_metallic_roughness(const psplat_gltf *gltf, psplat_json_value object,
                                              psplat_material *material) {
    static const char *const names[] = {"baseColorFactor", "metallicFactor", "roughnessFactor"};
    psplat_json_value members[3];
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 3, members);
    if (!result) result = parse_factors(gltf, members[0], names[0], 4, material->base_color);
    if (!result) result = parse_factors(gltf, members[1], names[1], 1, &material->metallic);
    if (!result) result = parse_factors(gltf, members[2], names[2], 1, &material->roughness);
    return result;
}

static psplat_result parse_emissive_strength(const psplat_gltf *gltf, psplat_json_value object,
                                             psplat_material *material) {
    static const char *const names[] = {"emissiveStrength"};
    psplat_json_value member = 0;
    double strength = 1;
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 1, &member);
    if (!result) result = psplat_json_number(&gltf->json, member, names[0], &strength);
    if (result) return result;
    if (strength < 0 || strength > 1e30)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, member),
                           "emissiveStrength must be from 0 to 1e30");
    for (int i = 0; i < 3; ++i) material->emissive[i] *= (float)strength;
    return PSPLAT_OK;
}

static psplat_result parse_extensions(const psplat_gltf *gltf, psplat_json_value object,
                                      psplat_material *material) {
    static const char *const names[] = {"KHR_materials_unlit", "KHR_materials_emissive_strength"};
    psplat_json_value members[2];
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 2, members);
    if (result) return result;
    material->unlit = members[0] != 0;
    return parse_emissive_strength(gltf, members[1], material);
}

static psplat_result parse_material(const psplat_gltf *gltf, psplat_json_value value,
                                    psplat_material *material) {
    static const char *const names[] = {"pbrMetallicRoughness", "emissiveFactor", "doubleSided",
                                        "extensions"};
    psplat_json_value members[4];
    *material = default_material;
    psplat_result result = psplat_json_members(&gltf->json, value, names, 4, members);
    if (!result) result = parse_metallic_roughness(gltf, members[0], material);
    if (!result) result = parse_factors(gltf, members[1], names[1], 3, material->emissive);
    if (!result)
        result = psplat_json_boolean(&gltf->json, members[2], names[2], &material->double_sided);
    if (!result) result = parse_extensions(gltf, members[3], material);
    return result;
}

psplat_result psplat_materials_parse(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_json_value array = gltf->json_materials, value = 0;
    psplat_result result = psplat_gltf_table(gltf, array, "materials", sizeof *gltf->materials,
                                             &table, &gltf->material_count);
    gltf->materials = table;
    for (size_t i = 0; i < gltf->material_count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        result = parse_material(gltf, value, &gltf->materials[i]);
    }
    return result;
}

psplat_result psplat_material_get(const psplat_gltf *gltf, psplat_json_value value,
                                  psplat_material *material) {
    size_t index = PSPLAT_NONE;
    psplat_result result = psplat_gltf_index(gltf, value, "material", gltf->material_count, &index);
    if (result) return result;
    *material = index == PSPLAT_NONE ? default_material : gltf->materials[index];
    return PSPLAT_OK;
}
