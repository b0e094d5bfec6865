/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * material_json.c - the materials of a glTF file of splats (glTF 2.0 section 3.9) with their
 * textures, samplers and images, without values that are glTF's defaults.
 */
#include "export/material_json.h"

#include "base/json_writer.h"
#include "material/image.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char transform_name[] = "KHR_texture_transform";

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

static int has_textures(const psplat_material *m) {
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        if (m->textures[slot].image) return 1;
    return 0;
}

static int is_default_material(const psplat_material *m) {
    return !has_textures(m) && is_white(m->base_color) && m->metallic == 1.0f &&
           m->roughness == 1.0f && !is_emissive(m) && !m->double_sided && !m->unlit;
}

/* ---- materials in use ------------------------------------------------------------------------ */

static int is_same_sampler(const psplat_texture *a, const psplat_texture *b) {
    return a->wrap[0] == b->wrap[0] && a->wrap[1] == b->wrap[1] && !a->nearest == !b->nearest;
}

static int is_same_use(const psplat_texture *a, const psplat_texture *b) {
    if (!a->image || !b->image) return a->image == b->image;
    return a->image == b->image && is_same_sampler(a, b) && a->strength == b->strength &&
           !memcmp(a->transform, b->transform, sizeof a->transform);
}

static int is_same(const psplat_material *a, const psplat_material *b) {
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        if (!is_same_use(&a->textures[slot], &b->textures[slot])) return 0;
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

/* Returns whether a run with texture coordinates, or one without, uses a material. */
static int is_used(const psplat_splats *splats, size_t material, int has_texcoord) {
    for (size_t i = 0; i < splats->run_count; ++i)
        if (splats->runs[i].material == material && !splats->runs[i].has_texcoord == !has_texcoord)
            return 1;
    return 0;
}

/* Returns a material as splats show it that have texture coordinates, or have none. */
static psplat_material shown(const psplat_splats *splats, size_t material, int has_texcoord) {
    psplat_material m = splats->materials[material];
    if (!has_texcoord) memset(m.textures, 0, sizeof m.textures);
    return m;
}

/* ---- textures in use ------------------------------------------------------------------------- */

/* Returns the index of a file's texture: an image with a sampler. */
static size_t find_texture(const psplat_materials *materials, const psplat_texture *texture) {
    size_t i = 0;
    while (i < materials->texture_count && (materials->textures[i].image != texture->image ||
                                            !is_same_sampler(&materials->textures[i], texture)))
        ++i;
    return i;
}

static size_t find_sampler(const psplat_materials *materials, const psplat_texture *texture) {
    size_t i = 0;
    while (i < materials->sampler_count && !is_same_sampler(&materials->samplers[i], texture)) ++i;
    return i;
}

static size_t find_image(const psplat_materials *materials, uint32_t image) {
    size_t i = 0;
    while (i < materials->image_count && materials->images[i] != image) ++i;
    return i;
}

/* Appends an element to a list. Returns 0 where memory ran out. */
static int append(void **list, size_t *count, const void *element, size_t size) {
    char *longer = realloc(*list, (*count + 1) * size);
    if (!longer) return 0;
    memcpy(longer + *count * size, element, size);
    *list = longer;
    ++*count;
    return 1;
}

static int append_texture(psplat_texture **list, size_t *count, const psplat_texture *texture) {
    void *longer = *list;
    int ok = append(&longer, count, texture, sizeof *texture);
    *list = longer;
    return ok;
}

static int append_image(psplat_materials *materials, uint32_t image) {
    void *longer = materials->images;
    int ok = append(&longer, &materials->image_count, &image, sizeof image);
    materials->images = longer;
    return ok;
}

/* Adds what the texture of a material needs in the file, unless it is there. */
static int add_texture(psplat_materials *m, const psplat_texture *texture) {
    static const psplat_texture plain; /* glTF's default: repeated, interpolated */
    int ok = 1;
    if (!texture->image) return 1;
    if (find_image(m, texture->image - 1) == m->image_count)
        ok = append_image(m, texture->image - 1);
    if (ok && !is_same_sampler(texture, &plain) && find_sampler(m, texture) == m->sampler_count)
        ok = append_texture(&m->samplers, &m->sampler_count, texture);
    if (ok && find_texture(m, texture) == m->texture_count)
        ok = append_texture(&m->textures, &m->texture_count, texture);
    return ok;
}

static psplat_result add(psplat_materials *materials, const psplat_named_material *one) {
    if (!one->name && !one->extras && is_default_material(&one->material)) return PSPLAT_OK;
    if (find(materials, one) != PSPLAT_NO_INDEX) return PSPLAT_OK;
    psplat_named_material *list =
        realloc(materials->list, (materials->count + 1) * sizeof *materials->list);
    if (!list) return PSPLAT_ERROR_MEMORY;
    materials->list = list;
    list[materials->count++] = *one;
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
        if (!add_texture(materials, &one->material.textures[slot])) return PSPLAT_ERROR_MEMORY;
    return PSPLAT_OK;
}

/* ---- collecting ------------------------------------------------------------------------------ */

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
    for (size_t k = 0; k < 2 * most; ++k)
        for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
            int has_texcoord = !(k % 2);
            if (k / 2 >= splats[i].material_count || !is_used(&splats[i], k / 2, has_texcoord))
                continue;
            psplat_material m = shown(&splats[i], k / 2, has_texcoord);
            result = psplat_materials_add(materials, scene, &m, k / 2);
        }
    return result;
}

void psplat_materials_free(psplat_materials *materials) {
    free(materials->list);
    free(materials->textures);
    free(materials->samplers);
    free(materials->images);
    *materials = (psplat_materials){0};
}

uint32_t psplat_materials_find(const psplat_materials *materials, const psplat_scene *scene,
                               const psplat_material *material, size_t source_material) {
    const psplat_named_material one = named(scene, material, source_material);
    return find(materials, &one);
}

uint32_t psplat_materials_index(const psplat_materials *materials, const psplat_scene *scene,
                                const psplat_splats *splats, size_t material, int has_texcoord) {
    const psplat_material m = shown(splats, material, has_texcoord);
    return psplat_materials_find(materials, scene, &m, material);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* Writes KHR_texture_transform, of which the rows are those of translation x rotation x scale. */
static void add_transform(psplat_writer *json, const float rows[6]) {
    const double m[4] = {(double)rows[0], (double)rows[1], (double)rows[3], (double)rows[4]};
    float scale[2] = {(float)hypot(m[0], m[2]), 0};
    double determinant = m[0] * m[3] - m[1] * m[2];
    double rotation = scale[0] > 0 ? atan2(-m[2], m[0]) : atan2(m[1], m[3]);
    scale[1] = (float)(scale[0] > 0 ? determinant / hypot(m[0], m[2]) : hypot(m[1], m[3]));
    const float offset[2] = {rows[2], rows[5]};
    psplat_writer_open(json, "extensions", '{');
    psplat_writer_open(json, transform_name, '{');
    if (offset[0] != 0 || offset[1] != 0) psplat_writer_floats(json, "offset", offset, 2);
    if (rotation != 0) psplat_writer_float(json, "rotation", (float)rotation);
    if (scale[0] != 1 || scale[1] != 1) psplat_writer_floats(json, "scale", scale, 2);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

static int is_transformed(const psplat_texture *texture) {
    static const float none[6];
    return texture->image && memcmp(texture->transform, none, sizeof none) != 0;
}

/* Writes a texture of a material where there is one. strength names its number, or is NULL. */
static void add_texture_info(psplat_writer *json, const psplat_materials *materials,
                             const char *name, const psplat_texture *texture,
                             const char *strength) {
    if (!texture->image) return;
    psplat_writer_open(json, name, '{');
    psplat_writer_count(json, "index", find_texture(materials, texture));
    if (strength && texture->strength != 1.0f)
        psplat_writer_float(json, strength, texture->strength);
    if (is_transformed(texture)) add_transform(json, texture->transform);
    psplat_writer_close(json, '}');
}

/* Writes the members of a material that glTF itself has, but for the normal texture. */
static void add_core(psplat_writer *json, const psplat_materials *materials,
                     const psplat_material *m) {
    const psplat_texture *textures = m->textures;
    psplat_writer_open(json, "pbrMetallicRoughness", '{');
    if (!is_white(m->base_color)) psplat_writer_floats(json, "baseColorFactor", m->base_color, 4);
    add_texture_info(json, materials, "baseColorTexture", &textures[PSPLAT_TEXTURE_BASE_COLOR],
                     NULL);
    if (m->metallic != 1.0f) psplat_writer_float(json, "metallicFactor", m->metallic);
    if (m->roughness != 1.0f) psplat_writer_float(json, "roughnessFactor", m->roughness);
    add_texture_info(json, materials, "metallicRoughnessTexture",
                     &textures[PSPLAT_TEXTURE_METALLIC_ROUGHNESS], NULL);
    psplat_writer_close(json, '}');
    if (!materials->has_splats)
        add_texture_info(json, materials, "normalTexture", &textures[PSPLAT_TEXTURE_NORMAL],
                         "scale");
    add_texture_info(json, materials, "occlusionTexture", &textures[PSPLAT_TEXTURE_OCCLUSION],
                     "strength");
    add_texture_info(json, materials, "emissiveTexture", &textures[PSPLAT_TEXTURE_EMISSIVE], NULL);
    if (m->double_sided) psplat_writer_boolean(json, "doubleSided", 1);
    if (is_emissive(m)) {
        float strength = emissive_strength(m), factor[3];
        for (size_t i = 0; i < 3; ++i) factor[i] = m->emissive[i] / strength;
        psplat_writer_floats(json, "emissiveFactor", factor, 3);
    }
}

/* Writes the extensions of a material. glTF wants tangents where a material has a normal texture,
 * and splats have none, so that texture stands in the extension's own object (spec 3.11), where
 * there are splats. */
static void add_extensions(psplat_writer *json, const psplat_materials *materials,
                           const psplat_material *m) {
    const psplat_texture *normal = &m->textures[PSPLAT_TEXTURE_NORMAL];
    int is_ours = materials->has_splats && normal->image;
    float strength = emissive_strength(m);
    if (!m->unlit && strength <= 1.0f && !is_ours) return;
    psplat_writer_open(json, "extensions", '{');
    if (strength > 1.0f) {
        psplat_writer_open(json, "KHR_materials_emissive_strength", '{');
        psplat_writer_float(json, "emissiveStrength", strength);
        psplat_writer_close(json, '}');
    }
    if (m->unlit) {
        psplat_writer_open(json, "KHR_materials_unlit", '{');
        psplat_writer_close(json, '}');
    }
    if (is_ours) {
        psplat_writer_open(json, "PSPLAT_surface_splats", '{');
        add_texture_info(json, materials, "normalTexture", normal, "scale");
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, '}');
}

static void add_material(psplat_writer *json, const psplat_materials *materials,
                         const psplat_named_material *named_material) {
    psplat_writer_open(json, NULL, '{');
    if (named_material->name) psplat_writer_string(json, "name", named_material->name);
    add_core(json, materials, &named_material->material);
    add_extensions(json, materials, &named_material->material);
    if (named_material->extras) psplat_writer_raw(json, "extras", named_material->extras);
    psplat_writer_close(json, '}');
}

void psplat_materials_write_extensions(psplat_writer *json, const psplat_materials *materials) {
    int unlit = 0, strength = 0, transform = 0;
    for (size_t i = 0; i < materials->count; ++i) {
        const psplat_material *m = &materials->list[i].material;
        unlit |= m->unlit;
        strength |= emissive_strength(m) > 1.0f;
        for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot)
            transform |= is_transformed(&m->textures[slot]);
    }
    if (unlit) psplat_writer_string(json, NULL, "KHR_materials_unlit");
    if (strength) psplat_writer_string(json, NULL, "KHR_materials_emissive_strength");
    if (transform) psplat_writer_string(json, NULL, transform_name);
}

static void add_textures(psplat_writer *json, const psplat_materials *materials) {
    static const psplat_texture plain;
    psplat_writer_open(json, "textures", '[');
    for (size_t i = 0; i < materials->texture_count; ++i) {
        const psplat_texture *texture = &materials->textures[i];
        psplat_writer_open(json, NULL, '{');
        if (!is_same_sampler(texture, &plain))
            psplat_writer_count(json, "sampler", find_sampler(materials, texture));
        psplat_writer_count(json, "source", find_image(materials, texture->image - 1));
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void add_samplers(psplat_writer *json, const psplat_materials *materials) {
    enum { REPEAT = 10497, CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648, NEAREST = 9728 };
    static const size_t wraps[] = {[PSPLAT_WRAP_REPEAT] = REPEAT,
                                   [PSPLAT_WRAP_CLAMP] = CLAMP_TO_EDGE,
                                   [PSPLAT_WRAP_MIRROR] = MIRRORED_REPEAT};
    static const char *const names[] = {"wrapS", "wrapT"};
    psplat_writer_open(json, "samplers", '[');
    for (size_t i = 0; i < materials->sampler_count; ++i) {
        const psplat_texture *sampler = &materials->samplers[i];
        psplat_writer_open(json, NULL, '{');
        if (sampler->nearest) psplat_writer_count(json, "magFilter", NEAREST);
        for (int k = 0; k < 2; ++k)
            if (sampler->wrap[k]) psplat_writer_count(json, names[k], wraps[sampler->wrap[k]]);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

static void add_images(psplat_writer *json, const psplat_materials *materials,
                       const psplat_scene *scene, size_t first_view) {
    psplat_writer_open(json, "images", '[');
    for (size_t i = 0; i < materials->image_count; ++i) {
        const psplat_image *image = &scene->materials.images[materials->images[i]];
        psplat_writer_open(json, NULL, '{');
        if (image->name) psplat_writer_string(json, "name", image->name);
        psplat_writer_count(json, "bufferView", first_view + i);
        psplat_writer_string(json, "mimeType", image->mime_type);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}

void psplat_materials_write(psplat_writer *json, const psplat_materials *materials,
                            const psplat_scene *scene, size_t first_view) {
    if (!materials->count) return;
    psplat_writer_open(json, "materials", '[');
    for (size_t i = 0; i < materials->count; ++i)
        add_material(json, materials, &materials->list[i]);
    psplat_writer_close(json, ']');
    if (!materials->image_count) return;
    add_textures(json, materials);
    if (materials->sampler_count) add_samplers(json, materials);
    add_images(json, materials, scene, first_view);
}
