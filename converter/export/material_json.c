/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * material_json.c - the materials of a glTF file of splats (glTF 2.0 section 3.9), without values
 * that are glTF's defaults.
 */
#include "export/material_json.h"

#include "base/json_writer.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int is_emissive(const psplat_material *m) {
    /* Unlit materials show their base colour alone (spec 5.6). */
    return !m->unlit &&
           (m->emissive[0] != 0.0f || m->emissive[1] != 0.0f || m->emissive[2] != 0.0f);
}

/* Returns the factor beyond 1, the most that glTF's emissiveFactor can be; it is written by
 * KHR_materials_emissive_strength. */
static float emissive_strength(const psplat_material *m) {
    if (!is_emissive(m)) return 1.0f;
    return fmaxf(1.0f, fmaxf(fmaxf(m->emissive[0], m->emissive[1]), m->emissive[2]));
}

static int is_white(const float color[4]) {
    return color[0] == 1.0f && color[1] == 1.0f && color[2] == 1.0f && color[3] == 1.0f;
}

static int is_default_material(const psplat_material *m) {
    return is_white(m->base_color) && m->metallic == 1.0f && m->roughness == 1.0f &&
           !is_emissive(m) && !m->double_sided && !m->unlit;
}

/* ---- materials in use ------------------------------------------------------------------------ */

static int is_same(const psplat_material *a, const psplat_material *b) {
    return !memcmp(a->base_color, b->base_color, sizeof a->base_color) &&
           !memcmp(a->emissive, b->emissive, sizeof a->emissive) && a->metallic == b->metallic &&
           a->roughness == b->roughness && a->double_sided == b->double_sided &&
           a->unlit == b->unlit;
}

static psplat_named_material named(const psplat_scene *scene, const psplat_material *material,
                                   size_t source_material) {
    psplat_named_material out = {.material = *material};
    if (source_material < scene->materials.source_material_count) {
        out.name = scene->materials.source_materials[source_material].name;
        out.extras = scene->materials.source_materials[source_material].extras;
    }
    return out;
}

static uint32_t find(const psplat_materials *materials, const psplat_named_material *one) {
    for (size_t i = 0; i < materials->count; ++i)
        if (materials->list[i].name == one->name && materials->list[i].extras == one->extras &&
            is_same(&materials->list[i].material, &one->material))
            return (uint32_t)i;
    return PSPLAT_NO_INDEX;
}

static int is_used(const psplat_splats *splats, size_t material) {
    for (size_t i = 0; i < splats->run_count; ++i)
        if (splats->runs[i].material == material) return 1;
    return 0;
}

static psplat_result add(psplat_materials *materials, const psplat_named_material *one) {
    if (!one->name && !one->extras && is_default_material(&one->material)) return PSPLAT_OK;
    if (find(materials, one) != PSPLAT_NO_INDEX) return PSPLAT_OK;
    psplat_named_material *list =
        realloc(materials->list, (materials->count + 1) * sizeof *materials->list);
    if (!list) return PSPLAT_ERROR_MEMORY;
    materials->list = list;
    list[materials->count++] = *one;
    return PSPLAT_OK;
}

psplat_result psplat_materials_add(psplat_materials *materials, const psplat_scene *scene,
                                   const psplat_material *material, size_t source_material) {
    const psplat_named_material one = named(scene, material, source_material);
    return add(materials, &one);
}

psplat_result psplat_materials_collect(const psplat_scene *scene, const psplat_splats *splats,
                                       psplat_materials *materials) {
    size_t most = 0;
    psplat_result result = PSPLAT_OK;
    *materials = (psplat_materials){0};
    for (size_t i = 0; i < scene->mesh_count; ++i)
        most = splats[i].material_count > most ? splats[i].material_count : most;
    for (size_t k = 0; k < most; ++k)
        for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
            if (k >= splats[i].material_count || !is_used(&splats[i], k)) continue;
            result = psplat_materials_add(materials, scene, &splats[i].materials[k], k);
        }
    return result;
}

void psplat_materials_free(psplat_materials *materials) {
    free(materials->list);
    *materials = (psplat_materials){0};
}

uint32_t psplat_materials_find(const psplat_materials *materials, const psplat_scene *scene,
                               const psplat_material *material, size_t source_material) {
    const psplat_named_material one = named(scene, material, source_material);
    return find(materials, &one);
}

uint32_t psplat_materials_index(const psplat_materials *materials, const psplat_scene *scene,
                                const psplat_splats *splats, size_t material) {
    return psplat_materials_find(materials, scene, &splats->materials[material], material);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static void add_emissive(psplat_writer *json, const psplat_material *m) {
    float strength = emissive_strength(m), factor[3];
    for (size_t i = 0; i < 3; ++i) factor[i] = m->emissive[i] / strength;
    psplat_writer_floats(json, "emissiveFactor", factor, 3);
    if (strength <= 1.0f) return;
    psplat_writer_open(json, "extensions", '{');
    psplat_writer_open(json, "KHR_materials_emissive_strength", '{');
    psplat_writer_float(json, "emissiveStrength", strength);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

static void add_material(psplat_writer *json, const psplat_named_material *named_material) {
    const psplat_material *m = &named_material->material;
    psplat_writer_open(json, NULL, '{');
    if (named_material->name) psplat_writer_string(json, "name", named_material->name);
    psplat_writer_open(json, "pbrMetallicRoughness", '{');
    if (!is_white(m->base_color)) psplat_writer_floats(json, "baseColorFactor", m->base_color, 4);
    if (m->metallic != 1.0f) psplat_writer_float(json, "metallicFactor", m->metallic);
    if (m->roughness != 1.0f) psplat_writer_float(json, "roughnessFactor", m->roughness);
    psplat_writer_close(json, '}');
    if (m->double_sided) psplat_writer_boolean(json, "doubleSided", 1);
    if (is_emissive(m)) add_emissive(json, m);
    if (m->unlit) {
        psplat_writer_open(json, "extensions", '{');
        psplat_writer_open(json, "KHR_materials_unlit", '{');
        psplat_writer_close(json, '}');
        psplat_writer_close(json, '}');
    }
    if (named_material->extras) psplat_writer_raw(json, "extras", named_material->extras);
    psplat_writer_close(json, '}');
}

void psplat_materials_write_extensions(psplat_writer *json, const psplat_materials *materials) {
    int unlit = 0, strength = 0;
    for (size_t i = 0; i < materials->count; ++i) {
        unlit |= materials->list[i].material.unlit;
        strength |= emissive_strength(&materials->list[i].material) > 1.0f;
    }
    if (unlit) psplat_writer_string(json, NULL, "KHR_materials_unlit");
    if (strength) psplat_writer_string(json, NULL, "KHR_materials_emissive_strength");
}

void psplat_materials_write(psplat_writer *json, const psplat_materials *materials) {
    if (!materials->count) return;
    psplat_writer_open(json, "materials", '[');
    for (size_t i = 0; i < materials->count; ++i) add_material(json, &materials->list[i]);
    psplat_writer_close(json, ']');
}
