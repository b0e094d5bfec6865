/* SPDX-License-Identifier: MIT
 *
 * texture.c - the textures of materials: which image they show, how it goes on beyond its edges,
 * and KHR_texture_transform (glTF 2.0 section 3.8, spec 3.11).
 */
#include "asset/gltf.h"

#include <float.h>
#include <math.h>

/* ---- samplers ----------------------------------------------------------------------------- */

static psplat_result parse_wrap(const psplat_gltf *gltf, psplat_json_value value, const char *what,
                                psplat_wrap *wrap) {
    enum { CLAMP = 33071, MIRROR = 33648, REPEAT = 10497 };
    size_t mode = REPEAT;
    psplat_result result = psplat_json_integer(&gltf->json, value, what, UINT32_MAX, &mode);
    if (result) return result;
    *wrap = mode == CLAMP    ? PSPLAT_WRAP_CLAMP
            : mode == MIRROR ? PSPLAT_WRAP_MIRROR
                             : PSPLAT_WRAP_REPEAT;
    if (mode == CLAMP || mode == MIRROR || mode == REPEAT) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                       "%s must be %d, %d or %d", what, REPEAT, CLAMP, MIRROR);
}

/* Of filters, only whether texels show as squares matters: mipmaps are always used. */
static psplat_result parse_sampler(const psplat_gltf *gltf, psplat_sampler *sampler) {
    enum { NEAREST = 9728, LINEAR = 9729 };
    static const char *const names[] = {"wrapS", "wrapT", "magFilter"};
    psplat_json_value members[3];
    size_t filter = LINEAR;
    psplat_result result = psplat_json_members(&gltf->json, sampler->json, names, 3, members);
    for (size_t i = 0; i < 2 && !result; ++i)
        result = parse_wrap(gltf, members[i], names[i], &sampler->wrap[i]);
    if (!result)
        result = psplat_json_integer(&gltf->json, members[2], names[2], UINT32_MAX, &filter);
    if (result) return result;
    sampler->nearest = filter == NEAREST;
    if (filter == NEAREST || filter == LINEAR) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, members[2]),
                       "magFilter must be %d or %d", NEAREST, LINEAR);
}

/* ---- textures ----------------------------------------------------------------------------- */

/* Finds the image of a texture that has none of the kinds that glTF knows. *source is 0 where no
 * extension names one either. */
static psplat_result find_other_source(const psplat_gltf *gltf, psplat_json_value extensions,
                                       psplat_json_value *source) {
    static const char *const names[] = {"EXT_texture_webp", "KHR_texture_basisu",
                                        "MSFT_texture_dds"};
    static const char *const member[] = {"source"};
    psplat_json_value found[3];
    if (!extensions) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, extensions, names, 3, found);
    for (size_t i = 0; i < 3 && !result && !*source; ++i)
        if (found[i]) result = psplat_json_members(&gltf->json, found[i], member, 1, source);
    return result;
}

static psplat_result parse_texture(const psplat_gltf *gltf, psplat_texture_entry *texture) {
    static const char *const names[] = {"source", "sampler", "extensions"};
    psplat_json_value members[3];
    psplat_result result = psplat_json_members(&gltf->json, texture->json, names, 3, members);
    if (!result && !members[0]) result = find_other_source(gltf, members[2], &members[0]);
    if (!result)
        result = psplat_gltf_index(gltf, members[0], names[0], gltf->image_count, &texture->image);
    if (!result)
        result =
            psplat_gltf_index(gltf, members[1], names[1], gltf->sampler_count, &texture->sampler);
    return result;
}

static psplat_result parse_samplers(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_json_value array = gltf->json_samplers, value = 0;
    psplat_result result = psplat_gltf_table(gltf, array, "samplers", sizeof *gltf->samplers,
                                             &table, &gltf->sampler_count);
    gltf->samplers = table;
    for (size_t i = 0; i < gltf->sampler_count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        gltf->samplers[i].json = value;
        result = parse_sampler(gltf, &gltf->samplers[i]);
    }
    return result;
}

static psplat_result list_images(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_json_value array = gltf->json_images, value = 0;
    psplat_result result =
        psplat_gltf_table(gltf, array, "images", sizeof *gltf->images, &table, &gltf->image_count);
    gltf->images = table;
    for (size_t i = 0; i < gltf->image_count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        gltf->images[i].json = value;
    }
    return result;
}

/* Fills the tables of samplers, images and textures, once. */
static psplat_result parse_tables(psplat_gltf *gltf) {
    void *table = NULL;
    psplat_json_value array = gltf->json_textures, value = 0;
    if (gltf->textures) return PSPLAT_OK;
    psplat_result result = parse_samplers(gltf);
    if (!result) result = list_images(gltf);
    if (!result)
        result = psplat_gltf_table(gltf, array, "textures", sizeof *gltf->textures, &table,
                                   &gltf->texture_count);
    gltf->textures = table;
    for (size_t i = 0; i < gltf->texture_count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        gltf->textures[i].json = value;
        result = parse_texture(gltf, &gltf->textures[i]);
    }
    return result;
}

/* ---- their use by a material -------------------------------------------------------------- */

/* Reads KHR_texture_transform as the rows of translation x rotation x scale. */
static psplat_result parse_transform(const psplat_gltf *gltf, psplat_json_value object,
                                     size_t *texcoord, float rows[6]) {
    static const char *const names[] = {"offset", "rotation", "scale", "texCoord"};
    psplat_json_value members[4];
    double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 4, members);
    if (!result) result = psplat_json_numbers(&gltf->json, members[0], names[0], 2, offset);
    if (!result) result = psplat_json_number(&gltf->json, members[1], names[1], &rotation);
    if (!result) result = psplat_json_numbers(&gltf->json, members[2], names[2], 2, scale);
    if (!result)
        result = psplat_json_integer(&gltf->json, members[3], names[3], UINT32_MAX, texcoord);
    if (result) return result;
    double c = cos(rotation), s = sin(rotation);
    int is_zero = 1;
    const double exact[6] = {c * scale[0],  s * scale[1], offset[0],
                             -s * scale[0], c * scale[1], offset[1]};
    for (size_t i = 0; i < 6; ++i) {
        rows[i] = (float)exact[i];
        if (!isfinite(rows[i]))
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, object),
                               "KHR_texture_transform moves a texture beyond what a float can "
                               "hold");
        is_zero &= rows[i] == 0.0f;
    }
    /* All zeros mean the identity (psplat_texture); the least scale shows the same one point. */
    if (is_zero) rows[0] = FLT_MIN;
    return PSPLAT_OK;
}

static psplat_result parse_strength(const psplat_gltf *gltf, psplat_texture_slot slot,
                                    psplat_json_value scale, psplat_json_value strength,
                                    float *out) {
    int is_normal = slot == PSPLAT_TEXTURE_NORMAL;
    psplat_json_value value = is_normal ? scale : strength;
    const char *what = is_normal ? "scale" : "strength";
    double number = 1;
    if (!is_normal && slot != PSPLAT_TEXTURE_OCCLUSION) return PSPLAT_OK;
    psplat_result result = psplat_json_number(&gltf->json, value, what, &number);
    *out = (float)number;
    if (result || (is_normal ? isfinite(*out) : number >= 0 && number <= 1)) return result;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                       is_normal ? "%s must be a float" : "%s must be from 0 to 1", what);
}

/* Fills what a texture of the document says and keeps its image. A texture of a kind that is not
 * known has no image and stays away. */
static psplat_result use_texture(psplat_gltf *gltf, size_t index, psplat_texture *texture) {
    const psplat_texture_entry *entry = &gltf->textures[index];
    if (entry->image == PSPLAT_NONE) return PSPLAT_OK;
    psplat_image_entry *image = &gltf->images[entry->image];
    psplat_result result = psplat_image_keep(gltf, image);
    if (result) return result;
    texture->image = image->kept;
    if (entry->sampler == PSPLAT_NONE) return PSPLAT_OK;
    const psplat_sampler *sampler = &gltf->samplers[entry->sampler];
    for (size_t i = 0; i < 2; ++i) texture->wrap[i] = sampler->wrap[i];
    texture->nearest = sampler->nearest;
    return PSPLAT_OK;
}

/* Reads the textureInfo object of a slot. */
static psplat_result parse_info(psplat_gltf *gltf, psplat_json_value object,
                                psplat_texture_slot slot, psplat_texture *texture) {
    static const char *const names[] = {"index", "texCoord", "extensions", "scale", "strength"};
    static const char *const transform[] = {"KHR_texture_transform"};
    psplat_json_value members[5], moved = 0;
    psplat_texture found = {0};
    size_t index = 0, texcoord = 0;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 5, members);
    if (!result) result = psplat_gltf_require(gltf, object, members[0], names[0]);
    if (!result)
        result =
            psplat_gltf_index(gltf, members[0], "a texture's index", gltf->texture_count, &index);
    if (!result)
        result = psplat_json_integer(&gltf->json, members[1], names[1], UINT32_MAX, &texcoord);
    if (!result) result = parse_strength(gltf, slot, members[3], members[4], &found.strength);
    if (!result && members[2])
        result = psplat_json_members(&gltf->json, members[2], transform, 1, &moved);
    if (!result && moved) result = parse_transform(gltf, moved, &texcoord, found.transform);
    if (result || texcoord != 0) return result;
    result = use_texture(gltf, index, &found);
    if (found.image) *texture = found;
    return result;
}

psplat_result psplat_textures_get(psplat_gltf *gltf, const psplat_texture_infos *infos,
                                  psplat_material *material) {
    psplat_result result = parse_tables(gltf);
    for (size_t i = 0; i < PSPLAT_TEXTURE_SLOTS && !result; ++i)
        if (infos->of[i])
            result = parse_info(gltf, infos->of[i], (psplat_texture_slot)i, &material->textures[i]);
    return result;
}
