/* SPDX-License-Identifier: MIT
 *
 * material.c - glTF materials (glTF 2.0 section 3.9). Their factors are read at once; their
 * textures where splats with texture coordinates use the material (spec 3.11).
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
                                              psplat_material *material,
                                              psplat_texture_infos *infos) {
    static const char *const names[] = {"baseColorFactor", "metallicFactor", "roughnessFactor",
                                        "baseColorTexture", "metallicRoughnessTexture"};
    psplat_json_value members[5];
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 5, members);
    if (!result) result = parse_factors(gltf, members[0], names[0], 4, material->base_color);
    if (!result) result = parse_factors(gltf, members[1], names[1], 1, &material->metallic);
    if (!result) result = parse_factors(gltf, members[2], names[2], 1, &material->roughness);
    infos->of[PSPLAT_TEXTURE_BASE_COLOR] = members[3];
    infos->of[PSPLAT_TEXTURE_METALLIC_ROUGHNESS] = members[4];
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

/* The normal texture of splats lies in an object of this extension, since glTF wants tangents
 * beside one of the material's own (spec 3.11). */
static psplat_result parse_extensions(const psplat_gltf *gltf, psplat_json_value object,
                                      psplat_material *material, psplat_texture_infos *infos) {
    static const char *const names[] = {"KHR_materials_unlit", "KHR_materials_emissive_strength",
                                        PSPLAT_EXTENSION};
    static const char *const ours[] = {"normalTexture"};
    psplat_json_value members[3], *normal = &infos->of[PSPLAT_TEXTURE_NORMAL];
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 3, members);
    if (result) return result;
    material->unlit = members[0] != 0;
    result = parse_emissive_strength(gltf, members[1], material);
    if (result || !members[2]) return result;
    result = psplat_json_members(&gltf->json, members[2], ours, 1, normal);
    return result ? result : psplat_gltf_require(gltf, members[2], *normal, ours[0]);
}

/* Reads how opaque a point must be to be there. */
static psplat_result parse_alpha(const psplat_gltf *gltf, psplat_json_value mode,
                                 psplat_json_value cutoff, psplat_material *material) {
    double number = 0.5;
    psplat_result result = psplat_json_expect(&gltf->json, mode, PSPLAT_JSON_STRING, "alphaMode");
    if (!result) result = psplat_json_number(&gltf->json, cutoff, "alphaCutoff", &number);
    if (result) return result;
    if (number < 0 || number > 1e30)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, cutoff),
                           "alphaCutoff must be from 0 to 1e30");
    if (mode && psplat_json_equals(&gltf->json, mode, "MASK"))
        material->alpha_cutoff = (float)number;
    return PSPLAT_OK;
}

static psplat_result parse_material(const psplat_gltf *gltf, psplat_json_value value,
                                    psplat_material *material, psplat_texture_infos *infos) {
    static const char *const names[] = {"pbrMetallicRoughness", "emissiveFactor",  "doubleSided",
                                        "extensions",           "alphaMode",       "alphaCutoff",
                                        "occlusionTexture",     "emissiveTexture", "normalTexture"};
    psplat_json_value members[9];
    *material = default_material;
    *infos = (psplat_texture_infos){{0}};
    psplat_result result = psplat_json_members(&gltf->json, value, names, 9, members);
    if (!result) result = parse_metallic_roughness(gltf, members[0], material, infos);
    if (!result) result = parse_factors(gltf, members[1], names[1], 3, material->emissive);
    if (!result)
        result = psplat_json_boolean(&gltf->json, members[2], names[2], &material->double_sided);
    if (!result) result = parse_alpha(gltf, members[4], members[5], material);
    if (result) return result;
    infos->of[PSPLAT_TEXTURE_OCCLUSION] = members[6];
    infos->of[PSPLAT_TEXTURE_EMISSIVE] = members[7];
    infos->of[PSPLAT_TEXTURE_NORMAL] = members[8];
    return parse_extensions(gltf, members[3], material, infos);
}

/* The factors of all materials are checked, used or not. */
psplat_result psplat_materials_parse(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_material material;
    psplat_texture_infos infos;
    psplat_json_value array = gltf->json_materials, value = 0;
    psplat_result result = psplat_gltf_table(gltf, array, "materials", sizeof *gltf->materials,
                                             &table, &gltf->material_count);
    gltf->materials = table;
    for (size_t i = 0; i < gltf->material_count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        gltf->materials[i].json = value;
        result = parse_material(gltf, value, &material, &infos);
    }
    return result;
}

/* Makes a material and its textures, or makes it without: then nothing of it is masked either. */
static psplat_result make_material(psplat_gltf *gltf, psplat_json_value json, int is_textured,
                                   psplat_material *material) {
    psplat_texture_infos infos;
    psplat_result result = parse_material(gltf, json, material, &infos);
    if (result) return result;
    if (is_textured) return psplat_textures_get(gltf, &infos, material);
    material->alpha_cutoff = 0;
    return PSPLAT_OK;
}

psplat_result psplat_material_get(psplat_gltf *gltf, psplat_json_value value, int is_textured,
                                  const psplat_material **material) {
    size_t index = PSPLAT_NONE;
    psplat_result result = psplat_gltf_index(gltf, value, "material", gltf->material_count, &index);
    *material = &default_material;
    if (result || index == PSPLAT_NONE) return result;
    psplat_material_entry *entry = &gltf->materials[index];
    if (!entry->made[is_textured]) {
        psplat_material *made = psplat_arena_take(gltf->scratch, 1, sizeof *made);
        if (!made)
            return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY,
                               psplat_gltf_offset(gltf, entry->json), "no memory for a material");
        result = make_material(gltf, entry->json, is_textured, made);
        if (result) return result;
        entry->made[is_textured] = made;
    }
    *material = entry->made[is_textured];
    return PSPLAT_OK;
}
