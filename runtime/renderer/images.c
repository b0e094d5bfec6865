/* SPDX-License-Identifier: MIT
 *
 * images.c - asks the host for the pixels of images and uploads them with mipmaps. Colours and
 * other numbers of one image are two textures, since the former are decoded from sRGB where they
 * are sampled.
 */
#include "renderer/images.h"
#include "gl/gl_state.h"
#include "core/memory.h"

_Static_assert((int)PSPLAT_TEXTURE_SLOTS == PSPLAT_MAP_COUNT, "layout.h has a unit for each slot");

static int is_color(int slot) {
    return slot == PSPLAT_TEXTURE_BASE_COLOR || slot == PSPLAT_TEXTURE_EMISSIVE;
}

/* Returns the index in psplat_model.images of a slot's image, or image_count where it has none. */
static size_t image_of(const psplat_model *model, const psplat_batch *batch, int slot) {
    uint32_t image = batch->material.textures[slot].image;
    size_t count = model->image_count / 2;
    if (!batch->has_texcoord || image == 0 || image > count) return model->image_count;
    return 2 * (size_t)(image - 1) + (size_t)is_color(slot);
}

/* ---- upload ------------------------------------------------------------------------------- */

static int level_count(uint32_t width, uint32_t height) {
    int levels = 1;
    for (uint32_t size = width > height ? width : height; size > 1; size /= 2) ++levels;
    return levels;
}

static psplat_result make_texture(psplat_renderer *renderer, const psplat_pixels *pixels,
                                  int is_srgb, psplat_gl_texture *texture, psplat_error *error) {
    psplat_gl *gl = &renderer->gl;
    const psplat_gl_texture_desc desc = {.texel = is_srgb ? PSPLAT_TEXEL_SRGB8_ALPHA8
                                                          : PSPLAT_TEXEL_RGBA8,
                                         .width = (GLsizei)pixels->width,
                                         .height = (GLsizei)pixels->height,
                                         .levels = level_count(pixels->width, pixels->height),
                                         .is_linear = 1};
    psplat_gl_state state;
    psplat_result result = psplat_gl_state_take(&state, gl, PSPLAT_UNIT_COUNT, error);
    if (result != PSPLAT_OK) return result;
    psplat_gl_errors(gl, NULL);
    result = psplat_gl_texture_create(gl, &renderer->memory.models, &desc, texture, error);
    if (result == PSPLAT_OK) {
        gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, desc.width, desc.height, GL_RGBA,
                          GL_UNSIGNED_BYTE, pixels->rgba);
        gl->GenerateMipmap(GL_TEXTURE_2D);
        result = psplat_gl_errors(gl, error);
    }
    psplat_gl_state_restore(&state, gl);
    return result;
}

static psplat_result check_pixels(const psplat_gl *gl, const psplat_pixels *pixels, size_t index,
                                  psplat_error *error) {
    uint32_t most = (uint32_t)gl->max_texture_size;
    if (pixels->texture) return PSPLAT_OK;
    if (!pixels->rgba || pixels->width == 0 || pixels->height == 0)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "the loader of images returned no pixels for image %zu", index);
    if (pixels->width > most || pixels->height > most)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "image %zu has %u x %u pixels, this GL takes %u x %u", index,
                           pixels->width, pixels->height, most, most);
    return PSPLAT_OK;
}

static void release(const psplat_renderer *renderer, psplat_pixels *pixels) {
    if (renderer->images.release) renderer->images.release(renderer->images.user, pixels);
}

static psplat_result load_image(psplat_renderer *renderer, const psplat_asset *asset, size_t index,
                                int is_srgb, psplat_model_image *out, psplat_error *error) {
    const psplat_images *images = &renderer->images;
    psplat_pixels pixels = {0};
    psplat_error ours = {0}; /* which the host fills whether or not the caller wants to know */
    psplat_result result = images->load(images->user, psplat_asset_get_image(asset, index), is_srgb,
                                        &pixels, error ? error : &ours);
    if (result != PSPLAT_OK) return result;
    result = check_pixels(&renderer->gl, &pixels, index, error);
    if (result == PSPLAT_OK && pixels.texture) {
        out->host = pixels;
        return PSPLAT_OK;
    }
    if (result == PSPLAT_OK)
        result = make_texture(renderer, &pixels, is_srgb, &out->texture, error);
    release(renderer, &pixels);
    return result;
}

psplat_result psplat_model_load_images(psplat_renderer *renderer, const psplat_asset *asset,
                                       psplat_model *model, psplat_error *error) {
    size_t count = 2 * psplat_asset_image_count(asset);
    psplat_result result = PSPLAT_OK;
    if (!renderer->images.load || count == 0) return PSPLAT_OK;
    model->images = psplat_allocate(&renderer->allocator, count, sizeof *model->images);
    if (!model->images)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu images", count / 2);
    model->image_count = count;
    for (size_t i = 0; i < psplat_asset_all_batch_count(asset); ++i)
        for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS && result == PSPLAT_OK; ++slot) {
            size_t at = image_of(model, psplat_asset_batch(asset, i), slot);
            if (at == count || model->images[at].texture.id || model->images[at].host.texture)
                continue;
            result = load_image(renderer, asset, at / 2, is_color(slot), &model->images[at], error);
        }
    return result;
}

void psplat_model_drop_images(psplat_renderer *renderer, psplat_model *model) {
    for (size_t i = 0; i < model->image_count; ++i) {
        psplat_gl_texture_delete(&renderer->gl, &model->images[i].texture);
        if (model->images[i].host.texture) release(renderer, &model->images[i].host);
    }
    if (model->images)
        psplat_resize(&renderer->allocator, model->images,
                      model->image_count * sizeof *model->images, 0);
    model->images = NULL;
    model->image_count = 0;
}

/* ---- use ---------------------------------------------------------------------------------- */

/* Writes the identity where a transform is not given. Returns 1 where it is another one. */
static int complete_transform(float transform[6]) {
    static const float identity[6] = {1, 0, 0, 0, 1, 0};
    int is_given = 0, differs = 0;
    for (int i = 0; i < 6; ++i) is_given |= transform[i] != 0.0f;
    for (int i = 0; i < 6; ++i) {
        if (!is_given) transform[i] = identity[i];
        differs |= transform[i] != identity[i];
    }
    return differs;
}

void psplat_model_use_images(psplat_renderer *renderer, const psplat_model *model,
                             const psplat_batch *batch, psplat_model_batch *out) {
    unsigned textures = 0;
    for (int slot = 0; slot < PSPLAT_TEXTURE_SLOTS; ++slot) {
        size_t at = image_of(model, batch, slot);
        int is_moved = complete_transform(out->material.textures[slot].transform);
        if (at == model->image_count) continue;
        const psplat_model_image *image = &model->images[at];
        out->maps[slot] = image->texture.id ? image->texture.id : (GLuint)image->host.texture;
        out->samplers[slot] = psplat_gl_samplers_find(&renderer->samplers, &renderer->gl,
                                                      &batch->material.textures[slot]);
        textures |= (unsigned)PSPLAT_OPTION_BASE_MAP << slot;
        if (is_moved) textures |= PSPLAT_OPTION_MAP_TRANSFORM;
    }
    if (batch->has_texcoord && batch->material.alpha_cutoff > 0.0f) textures |= PSPLAT_OPTION_MASK;
    if (textures && batch->has_texcoord_bend) textures |= PSPLAT_OPTION_TEXCOORD_BEND;
    out->textures = textures;
}
