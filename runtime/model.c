/* SPDX-License-Identifier: MIT
 *
 * Models: an asset's splats packed into float textures (layout.h), from which the vertex shader
 * pulls them. 48 bytes a splat, 16 more where it has a colour or a gamma, 12 a clip line and for
 * each of what else varies.
 */
#include "gl_state.h"
#include "memory.h"
#include "renderer.h"

#include <math.h>

/* Rows packed before each upload: at most 0.5 MB in flight. */
enum { ROWS_PER_UPLOAD = 16, MAX_SPLAT_FLOATS = 4 * (PSPLAT_SPLAT_TEXELS + 1) };

static void pack_splat(const psplat_splat *splat, float *out) {
    const float *q = splat->rotation;
    double length2 = 0.0;
    for (int i = 0; i < 4; ++i) length2 += (double)q[i] * (double)q[i];
    double x = q[0], y = q[1], z = q[2], w = q[3], s = 2.0 / length2;
    const double axes[3][3] = {
        {1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
        {s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)},
        {s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)}};
    double local[3]; /* the normal in U, V, N (spec 3.5, eq. 3) */
    for (int i = 0; i < 3; ++i)
        local[i] = splat->normal[0] * axes[i][0] + splat->normal[1] * axes[i][1] +
                   splat->normal[2] * axes[i][2];

    double scale = sqrt((double)splat->radius[0] / length2);
    for (int i = 0; i < 3; ++i) out[i] = splat->center[i];
    out[3] = (float)((double)splat->radius[1] / (double)splat->radius[0]);
    for (int i = 0; i < 4; ++i) out[4 + i] = (float)(q[i] * scale);
    out[8] = (float)(local[0] / local[2]);
    out[9] = (float)(local[1] / local[2]);
    out[10] = splat->gradient[0];
    out[11] = splat->gradient[1];
}

/* What a texture holds of a batch's splats: floats of each, channels of each texel, and how splats
 * first ... end - 1 are written one after another. */
typedef struct packing {
    int floats, channels;
    void (*pack)(const psplat_batch *batch, size_t first, size_t end, float *out);
} packing;

static void pack_narrow(const psplat_batch *batch, size_t first, size_t end, float *out) {
    for (size_t i = first; i < end; ++i, out += 4 * PSPLAT_SPLAT_TEXELS)
        pack_splat(&batch->splats[i], out);
}

static void pack_wide(const psplat_batch *batch, size_t first, size_t end, float *out) {
    for (size_t i = first; i < end; ++i, out += MAX_SPLAT_FLOATS) {
        pack_splat(&batch->splats[i], out);
        for (int k = 0; k < 3; ++k) out[12 + k] = batch->splats[i].color[k];
        out[15] = batch->splats[i].gradient[2];
    }
}

static packing packing_of_splats(const psplat_batch *batch) {
    if (batch->has_color || batch->has_gamma) return (packing){MAX_SPLAT_FLOATS, 4, pack_wide};
    return (packing){4 * PSPLAT_SPLAT_TEXELS, 4, pack_narrow};
}

static void pack_clips(const psplat_batch *batch, size_t first, size_t end, float *out) {
    for (size_t i = first; i < end; ++i)
        for (uint32_t line = 0; line < batch->clip_count; ++line)
            for (int k = 0; k < 3; ++k) *out++ = batch->splats[i].clip[line][k];
}

static float *put_texel(float *out, const float texel[3]) {
    for (int i = 0; i < 3; ++i) out[i] = texel[i];
    return out + 3;
}

static void pack_finishes(const psplat_batch *batch, size_t first, size_t end, float *out) {
    for (size_t i = first; i < end; ++i) {
        const psplat_finish *finish = &batch->finishes[i];
        const float surface[3] = {finish->occlusion, finish->roughness, finish->metallic};
        if (batch->has_surface) out = put_texel(out, surface);
        if (batch->has_emissive) out = put_texel(out, finish->emissive);
        if (!batch->has_color_gradient) continue;
        out = put_texel(out, finish->color_u);
        out = put_texel(out, finish->color_v);
    }
}

/* Packs and uploads bands of rows to the bound texture. */
static void upload_rows(const psplat_gl *gl, const psplat_batch *batch, const packing *p,
                        GLsizei width, GLsizei height, float *staging) {
    GLenum format = p->channels == 4 ? GL_RGBA : GL_RGB;
    for (GLsizei row = 0; row < height; row += ROWS_PER_UPLOAD) {
        GLsizei rows = height - row < ROWS_PER_UPLOAD ? height - row : ROWS_PER_UPLOAD;
        size_t first = (size_t)row * PSPLAT_ROW_SPLATS;
        size_t end = first + (size_t)rows * PSPLAT_ROW_SPLATS;
        p->pack(batch, first, end < batch->splat_count ? end : batch->splat_count, staging);
        gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, row, width, rows, format, GL_FLOAT, staging);
    }
}

static psplat_result upload(psplat_renderer *renderer, const psplat_batch *batch, packing p,
                            float *staging, psplat_texture *texture, psplat_error *error) {
    psplat_texture_desc desc = {
        .texel = p.channels == 4 ? PSPLAT_TEXEL_RGBA32F : PSPLAT_TEXEL_RGB32F,
        .width = PSPLAT_ROW_SPLATS * p.floats / p.channels,
        .height = (GLsizei)((batch->splat_count + PSPLAT_ROW_SPLATS - 1) / PSPLAT_ROW_SPLATS)};
    psplat_result result =
        psplat_texture_create(&renderer->gl, &renderer->memory.models, &desc, texture, error);
    if (result == PSPLAT_OK)
        upload_rows(&renderer->gl, batch, &p, desc.width, desc.height, staging);
    return result;
}

static const psplat_model_batch *find_primitive(const psplat_model *model, size_t count,
                                                uint32_t primitive) {
    for (size_t i = 0; i < count; ++i)
        if (model->batches[i].primitive == primitive) return &model->batches[i];
    return NULL;
}

static void describe_batch(const psplat_batch *batch, psplat_model_batch *out) {
    out->primitive = batch->primitive;
    out->splat_count = (GLsizei)batch->splat_count;
    out->clip_count = batch->clip_count;
    out->has_color = batch->has_color;
    out->has_gamma = batch->has_gamma;
    out->finish = (batch->has_surface ? PSPLAT_FINISH_SURFACE : 0u) |
                  (batch->has_emissive ? PSPLAT_FINISH_EMISSIVE : 0u) |
                  (batch->has_color_gradient ? PSPLAT_FINISH_GRADIENT : 0u);
    out->kernel = batch->kernel;
    out->depth_tolerance = batch->depth_tolerance;
    out->material = batch->material;
    for (int i = 0; i < 16; ++i) out->model[i] = batch->model[i];
    for (int i = 0; i < 3; ++i) {
        out->bounds_min[i] = batch->bounds_min[i];
        out->bounds_max[i] = batch->bounds_max[i];
    }
}

static psplat_result upload_textures(psplat_renderer *renderer, const psplat_batch *batch,
                                     psplat_model_batch *out, float *staging, psplat_error *error) {
    const packing clips = {3 * (int)batch->clip_count, 3, pack_clips};
    const int texels = batch->has_surface + batch->has_emissive + 2 * batch->has_color_gradient;
    const packing finishes = {3 * texels, 3, pack_finishes};
    psplat_result result =
        upload(renderer, batch, packing_of_splats(batch), staging, &out->splats, error);
    if (result == PSPLAT_OK && clips.floats)
        result = upload(renderer, batch, clips, staging, &out->clips, error);
    if (result == PSPLAT_OK && finishes.floats)
        result = upload(renderer, batch, finishes, staging, &out->finishes, error);
    return result;
}

static psplat_result upload_batch(psplat_renderer *renderer, psplat_model *model, size_t index,
                                  const psplat_batch *batch, float *staging, psplat_error *error) {
    const psplat_model_batch *twin = find_primitive(model, index, batch->primitive);
    psplat_model_batch *out = &model->batches[index];
    describe_batch(batch, out);
    if (twin) {
        out->splats = twin->splats;
        out->clips = twin->clips;
        out->finishes = twin->finishes;
        out->chunks = twin->chunks;
        return PSPLAT_OK;
    }
    out->is_owner = 1;
    size_t chunk_count = psplat_chunk_count(batch->splat_count);
    out->chunks = psplat_allocate(&renderer->allocator, chunk_count, sizeof *out->chunks);
    if (!out->chunks)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu chunks", chunk_count);
    psplat_chunks_find(batch->splats, batch->splat_count, out->chunks);
    return upload_textures(renderer, batch, out, staging, error);
}

static psplat_result check_sizes(const psplat_gl *gl, const psplat_asset *asset,
                                 psplat_error *error) {
    size_t most = (size_t)gl->max_texture_size * PSPLAT_ROW_SPLATS;
    for (size_t i = 0; i < psplat_asset_batch_count(asset); ++i) {
        size_t count = psplat_asset_batch(asset, i)->splat_count;
        if (count > most)
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                               "a primitive has %zu splats, this GL takes %zu", count, most);
    }
    return PSPLAT_OK;
}

static psplat_result upload_batches(psplat_renderer *renderer, const psplat_asset *asset,
                                    psplat_model *model, float *staging, psplat_error *error) {
    psplat_gl *gl = &renderer->gl;
    psplat_gl_state state;
    psplat_result result = psplat_gl_state_take(&state, gl, error);
    if (result != PSPLAT_OK) return result;
    psplat_gl_errors(gl, NULL);
    for (size_t i = 0; i < model->batch_count && result == PSPLAT_OK; ++i)
        result = upload_batch(renderer, model, i, psplat_asset_batch(asset, i), staging, error);
    if (result == PSPLAT_OK) result = psplat_gl_errors(gl, error);
    psplat_gl_state_restore(&state, gl);
    return result;
}

static psplat_result upload_all(psplat_renderer *renderer, const psplat_asset *asset,
                                psplat_model *model, psplat_error *error) {
    size_t size = sizeof(float) * MAX_SPLAT_FLOATS * PSPLAT_ROW_SPLATS * ROWS_PER_UPLOAD;
    float *staging = psplat_allocate(&renderer->allocator, 1, size);
    if (!staging) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to pack splats");
    psplat_result result = upload_batches(renderer, asset, model, staging, error);
    psplat_resize(&renderer->allocator, staging, size, 0);
    return psplat_gl_finish(&renderer->gl, result, error);
}

psplat_result psplat_model_create(psplat_renderer *renderer, const psplat_asset *asset,
                                  psplat_model **model, psplat_error *error) {
    if (model) *model = NULL;
    if (!renderer || !asset || !model)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "renderer, asset and model must not be NULL");
    psplat_result result = check_sizes(&renderer->gl, asset, error);
    if (result != PSPLAT_OK) return result;

    size_t count = psplat_asset_batch_count(asset);
    psplat_model *made = psplat_allocate(&renderer->allocator, 1, sizeof *made);
    psplat_model_batch *batches =
        made ? psplat_allocate(&renderer->allocator, count, sizeof *batches) : NULL;
    if (!batches) {
        if (made) psplat_resize(&renderer->allocator, made, sizeof *made, 0);
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu batches", count);
    }
    made->batches = batches;
    made->batch_count = count;
    result = upload_all(renderer, asset, made, error);
    if (result != PSPLAT_OK) {
        psplat_model_destroy(renderer, made);
        return result;
    }
    *model = made;
    return PSPLAT_OK;
}

void psplat_model_destroy(psplat_renderer *renderer, psplat_model *model) {
    if (!renderer || !model) return;
    for (size_t i = 0; i < model->batch_count; ++i) {
        psplat_model_batch *batch = &model->batches[i];
        if (!batch->is_owner) continue;
        psplat_texture_delete(&renderer->gl, &batch->splats);
        psplat_texture_delete(&renderer->gl, &batch->clips);
        psplat_texture_delete(&renderer->gl, &batch->finishes);
        size_t chunk_count = psplat_chunk_count((size_t)batch->splat_count);
        if (batch->chunks)
            psplat_resize(&renderer->allocator, batch->chunks, chunk_count * sizeof(psplat_chunk),
                          0);
    }
    size_t size = model->batch_count * sizeof *model->batches;
    psplat_resize(&renderer->allocator, model->batches, size ? size : 1, 0);
    psplat_resize(&renderer->allocator, model, sizeof *model, 0);
}

psplat_model_info psplat_model_describe(const psplat_model *model) {
    psplat_model_info info = {0};
    for (size_t i = 0; model && i < model->batch_count; ++i) {
        const psplat_model_batch *batch = &model->batches[i];
        info.splat_count += (size_t)batch->splat_count;
        info.batch_count += 1;
        if (batch->is_owner)
            info.bytes += batch->splats.bytes + batch->clips.bytes + batch->finishes.bytes;
    }
    return info;
}
