/* SPDX-License-Identifier: MIT
 *
 * Models: an asset's splats packed into float textures (layout.h), from which the vertex shader
 * pulls them. 48 bytes a splat, 16 more where it has a colour or a gamma, 12 a clip line.
 */
#include "gl_state.h"
#include "memory.h"
#include "renderer.h"

#include <math.h>

/* Rows packed before each upload: at most 0.5 MB in flight. */
enum { ROWS_PER_UPLOAD = 16, MAX_SPLAT_FLOATS = 4 * (PSPLAT_SPLAT_TEXELS + 1) };

static void pack_splat(const psplat_splat *splat, int texels, float *out) {
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
    if (texels == PSPLAT_SPLAT_TEXELS) return;
    for (int i = 0; i < 3; ++i) out[12 + i] = splat->color[i];
    out[15] = splat->gradient[2];
}

static void pack_clips(const psplat_splat *splat, uint32_t clip_count, float *out) {
    for (uint32_t line = 0; line < clip_count; ++line)
        for (int i = 0; i < 3; ++i) *out++ = splat->clip[line][i];
}

/* Packs and uploads bands of rows to the bound texture. floats is what one splat takes, channels
 * what one texel takes; clips are packed where channels is 3, splats where it is 4. */
static void upload_rows(const psplat_gl *gl, const psplat_batch *batch, int floats, int channels,
                        GLsizei width, GLsizei height, float *staging) {
    GLenum format = channels == 4 ? GL_RGBA : GL_RGB;
    for (GLsizei row = 0; row < height; row += ROWS_PER_UPLOAD) {
        GLsizei rows = height - row < ROWS_PER_UPLOAD ? height - row : ROWS_PER_UPLOAD;
        size_t first = (size_t)row * PSPLAT_ROW_SPLATS;
        size_t end = first + (size_t)rows * PSPLAT_ROW_SPLATS;
        if (end > batch->splat_count) end = batch->splat_count;
        for (size_t i = first; i < end; ++i) {
            float *out = staging + (i - first) * (size_t)floats;
            if (channels == 4)
                pack_splat(&batch->splats[i], floats / 4, out);
            else
                pack_clips(&batch->splats[i], batch->clip_count, out);
        }
        gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, row, width, rows, format, GL_FLOAT, staging);
    }
}

static psplat_result upload(psplat_renderer *renderer, const psplat_batch *batch, int floats,
                            int channels, float *staging, psplat_texture *texture,
                            psplat_error *error) {
    psplat_texture_desc desc = {
        .texel = channels == 4 ? PSPLAT_TEXEL_RGBA32F : PSPLAT_TEXEL_RGB32F,
        .width = PSPLAT_ROW_SPLATS * floats / channels,
        .height = (GLsizei)((batch->splat_count + PSPLAT_ROW_SPLATS - 1) / PSPLAT_ROW_SPLATS)};
    psplat_result result =
        psplat_texture_create(&renderer->gl, &renderer->memory.models, &desc, texture, error);
    if (result == PSPLAT_OK)
        upload_rows(&renderer->gl, batch, floats, channels, desc.width, desc.height, staging);
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
    out->kernel = batch->kernel;
    out->depth_tolerance = batch->depth_tolerance;
    out->material = batch->material;
    for (int i = 0; i < 16; ++i) out->model[i] = batch->model[i];
    for (int i = 0; i < 3; ++i) {
        out->bounds_min[i] = batch->bounds_min[i];
        out->bounds_max[i] = batch->bounds_max[i];
    }
}

static psplat_result upload_batch(psplat_renderer *renderer, psplat_model *model, size_t index,
                                  const psplat_batch *batch, float *staging, psplat_error *error) {
    const psplat_model_batch *twin = find_primitive(model, index, batch->primitive);
    psplat_model_batch *out = &model->batches[index];
    describe_batch(batch, out);
    if (twin) {
        out->splats = twin->splats;
        out->clips = twin->clips;
        out->chunks = twin->chunks;
        return PSPLAT_OK;
    }
    out->is_owner = 1;
    size_t chunk_count = psplat_chunk_count(batch->splat_count);
    out->chunks = psplat_allocate(&renderer->allocator, chunk_count, sizeof *out->chunks);
    if (!out->chunks)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu chunks", chunk_count);
    psplat_chunks_find(batch->splats, batch->splat_count, out->chunks);
    int texels = PSPLAT_SPLAT_TEXELS + (out->has_color || out->has_gamma);
    psplat_result result = upload(renderer, batch, 4 * texels, 4, staging, &out->splats, error);
    if (result == PSPLAT_OK && batch->clip_count)
        result =
            upload(renderer, batch, 3 * (int)batch->clip_count, 3, staging, &out->clips, error);
    return result;
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
        if (batch->is_owner) info.bytes += batch->splats.bytes + batch->clips.bytes;
    }
    return info;
}
