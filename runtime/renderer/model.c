/* SPDX-License-Identifier: MIT
 *
 * model.c - uploads an asset: its splats are packed into float textures (layout.h), from which the
 * vertex shader pulls them. A splat takes 48 bytes, 16 more where it has a colour or a gamma and
 * where it has a shape of its own, 12 for each clip line (16 for bent ones), 12 for each texel
 * of its finish and 24 or more for texture coordinates. The images of materials come first.
 */
#include "gl/gl_state.h"
#include "core/memory.h"
#include "asset/pack.h"
#include "renderer/images.h"

#include <math.h>
#include <string.h>

/* The most splats of a batch that have spheres of their own: 256 pixels for each at 2048². */
enum { MOST_SPHERES = 16384 };

/* Rows of texels that are packed before each upload, and the most floats of a row. */
enum { ROWS_PER_UPLOAD = 16, MAX_ROW_FLOATS = 4 * 512 * 4 };

/* The source of one of a batch's textures: splats that the asset has packed already, or ones to be
 * packed. */
typedef struct source {
    psplat_packing packing;
    const psplat_batch *batch;
    int floats;           /* of each splat; 0 where the batch has no such texture */
    int channels;         /* of each texel */
    const float *packed;  /* splat_count * floats; NULL where pack has to be called */
    psplat_chunk *chunks; /* found by pack_splats */
    float *sagitta;       /* raised by pack_splats */
    GLsizei *uncut_count; /* raised by pack_clips */
    float *spheres;       /* found by pack_splats where there is room for them */
    void (*pack)(const struct source *source, size_t first, size_t count, float *out);
} source;

/* Packs splats and finds their chunks, one chunk at a time while it is in the cache. */
static void pack_splats(const source *s, size_t first, size_t count, float *out) {
    for (size_t i = 0; i < count; i += PSPLAT_CHUNK_SPLATS) {
        const psplat_splat *splats = s->batch->splats + first + i;
        size_t here = count - i < PSPLAT_CHUNK_SPLATS ? count - i : PSPLAT_CHUNK_SPLATS;
        psplat_chunks_find(splats, here, s->chunks + (first + i) / PSPLAT_CHUNK_SPLATS);
        psplat_pack_splats(&s->packing, splats, here, out + i * (size_t)s->floats);
    }
    if (s->spheres) psplat_packed_spheres(&s->packing, out, count, s->spheres + 4 * first);
    *s->sagitta = fmaxf(*s->sagitta, psplat_packed_sagitta(&s->packing, out, count));
}

static void pack_clips(const source *s, size_t first, size_t count, float *out) {
    psplat_pack_clips(&s->packing, s->batch->splats + first, count, out);
    *s->uncut_count += (GLsizei)psplat_packed_uncut(&s->packing, out, count);
}

static void pack_finishes(const source *s, size_t first, size_t count, float *out) {
    psplat_pack_finishes(&s->packing, s->batch->finishes + first, count, out);
}

static void pack_texcoords(const source *s, size_t first, size_t count, float *out) {
    psplat_pack_texcoords(&s->packing, s->batch->splats + first, s->batch->texcoords + first, count,
                          out);
}

/* Uploads rows of width texels to the bound texture, from the given row on. */
static void put_rows(const psplat_gl *gl, const source *s, GLsizei row, GLsizei rows, GLsizei width,
                     const float *texels) {
    gl->TexSubImage2D(GL_TEXTURE_2D, 0, 0, row, width, rows, s->channels == 4 ? GL_RGBA : GL_RGB,
                      GL_FLOAT, texels);
}

/* Uploads splats from the asset's own memory; the last row only as far as there are splats. */
static void upload_packed(const psplat_gl *gl, const source *s) {
    size_t row = (size_t)s->packing.row_splats;
    GLsizei texels = s->floats / s->channels, width = s->packing.row_splats * texels;
    GLsizei rows = (GLsizei)(s->batch->splat_count / row);
    GLsizei rest = (GLsizei)(s->batch->splat_count % row);
    if (rows) put_rows(gl, s, 0, rows, width, s->packed);
    if (rest)
        put_rows(gl, s, rows, 1, rest * texels, s->packed + (size_t)rows * row * (size_t)s->floats);
}

/* Packs and uploads splats in bands of ROWS_PER_UPLOAD rows. */
static void upload_splats(const psplat_gl *gl, const source *s, GLsizei height, float *staging) {
    size_t splats = (size_t)s->packing.row_splats;
    GLsizei width = s->packing.row_splats * s->floats / s->channels;
    for (GLsizei row = 0; row < height; row += ROWS_PER_UPLOAD) {
        GLsizei rows = height - row < ROWS_PER_UPLOAD ? height - row : ROWS_PER_UPLOAD;
        size_t first = (size_t)row * splats, count = (size_t)rows * splats;
        if (count > s->batch->splat_count - first) count = s->batch->splat_count - first;
        s->pack(s, first, count, staging);
        put_rows(gl, s, row, rows, width, staging);
    }
}

/* Makes one texture of a batch and fills it. */
static psplat_result upload(psplat_renderer *renderer, const source *s, float *staging,
                            psplat_gl_texture *texture, psplat_error *error) {
    size_t row = (size_t)s->packing.row_splats;
    psplat_gl_texture_desc desc = {.texel = s->channels == 4 ? PSPLAT_TEXEL_RGBA32F
                                                             : PSPLAT_TEXEL_RGB32F,
                                   .width = s->packing.row_splats * s->floats / s->channels,
                                   .height = (GLsizei)((s->batch->splat_count + row - 1) / row)};
    if (!s->floats) return PSPLAT_OK;
    psplat_result result =
        psplat_gl_texture_create(&renderer->gl, &renderer->memory.models, &desc, texture, error);
    if (result == PSPLAT_OK && s->packed)
        upload_packed(&renderer->gl, s);
    else if (result == PSPLAT_OK)
        upload_splats(&renderer->gl, s, desc.height, staging);
    return result;
}

/* Returns the first of count batches that has this primitive, or NULL. */
static const psplat_model_batch *find_primitive(const psplat_model *model, size_t count,
                                                uint32_t primitive) {
    for (size_t i = 0; i < count; ++i)
        if (model->batches[i].primitive == primitive) return &model->batches[i];
    return NULL;
}

static void describe_batch(const psplat_batch *batch, psplat_model_batch *out) {
    out->primitive = batch->primitive;
    out->level = batch->level;
    out->last_level = batch->last_level;
    out->splat_count = (GLsizei)batch->splat_count;
    out->clip_count = batch->clip_count;
    out->seam_lines = batch->seam_lines;
    out->has_color = batch->has_color;
    out->has_gamma = batch->has_gamma;
    out->is_curved = batch->is_curved;
    out->has_shape = batch->is_curved && batch->has_shape;
    out->has_bends = batch->has_bends;
    out->finish = psplat_packing_of(batch).finish;
    out->kernel = batch->kernel;
    out->depth_tolerance = batch->depth_tolerance;
    out->wall = batch->is_curved ? (float)PSPLAT_WALL * batch->depth_tolerance : 0.0f;
    out->material = batch->material;
    for (int i = 0; i < 16; ++i) out->model[i] = batch->model[i];
    for (int i = 0; i < 3; ++i) {
        out->bounds_min[i] = batch->bounds_min[i];
        out->bounds_max[i] = batch->bounds_max[i];
    }
}

/* Finds what packing splats finds otherwise. */
static void describe_packed(const psplat_packing *p, const psplat_batch *batch,
                            const psplat_packed *packed, psplat_model_batch *out) {
    size_t count = batch->splat_count;
    out->sagitta = psplat_packed_sagitta(p, packed->splats, count);
    if (packed->clips) out->uncut_count = (GLsizei)psplat_packed_uncut(p, packed->clips, count);
    if (out->spheres) psplat_packed_spheres(p, packed->splats, count, out->spheres);
    memcpy(out->chunks, packed->chunks, psplat_chunk_count(count) * sizeof *out->chunks);
}

static psplat_result upload_textures(psplat_renderer *renderer, const psplat_batch *batch,
                                     const psplat_packed *packed, psplat_model_batch *out,
                                     float *staging, psplat_error *error) {
    psplat_packing p = psplat_packing_of(batch);
    const psplat_packed none = {0}, *from = packed ? packed : &none;
    const source sources[] = {{.packing = p,
                               .batch = batch,
                               .floats = p.splat_floats,
                               .channels = 4,
                               .packed = from->splats,
                               .chunks = out->chunks,
                               .sagitta = &out->sagitta,
                               .spheres = out->spheres,
                               .pack = pack_splats},
                              {.packing = p,
                               .batch = batch,
                               .floats = p.clip_floats,
                               .channels = p.line_floats,
                               .packed = from->clips,
                               .uncut_count = &out->uncut_count,
                               .pack = pack_clips},
                              {.packing = p,
                               .batch = batch,
                               .floats = p.finish_floats,
                               .channels = 3,
                               .packed = from->finishes,
                               .pack = pack_finishes},
                              {.packing = p,
                               .batch = batch,
                               .floats = out->textures ? p.texcoord_floats : 0,
                               .channels = p.texcoord_channels,
                               .packed = from->texcoords,
                               .pack = pack_texcoords}};
    psplat_gl_texture *const textures[] = {&out->splats, &out->clips, &out->finishes,
                                           &out->texcoords};
    psplat_result result = PSPLAT_OK;
    if (packed) describe_packed(&p, batch, packed, out);
    for (size_t i = 0; i < sizeof sources / sizeof *sources && result == PSPLAT_OK; ++i)
        result = upload(renderer, &sources[i], staging, textures[i], error);
    return result;
}

/* Makes the box of a curved batch enclose the ellipses that may be drawn in place of its patches
 * (spec 5.1), and the walls under their rims, too. */
static void enlarge_box(psplat_model_batch *batch) {
    float room = batch->sagitta + batch->wall;
    for (int i = 0; i < 3; ++i) {
        batch->bounds_min[i] -= room;
        batch->bounds_max[i] += room;
    }
}

/* Makes spheres enclose walls. */
static void enlarge_spheres(psplat_model_batch *batch) {
    size_t count = (size_t)batch->splat_count;
    for (size_t i = 0; i < psplat_chunk_count(count); ++i) batch->chunks[i].radius += batch->wall;
    for (size_t i = 0; batch->spheres && i < count; ++i) batch->spheres[4 * i + 3] += batch->wall;
}

/* Returns the floats of a batch's spheres, which have their use where splats have many pixels. */
static size_t sphere_floats(size_t splat_count) {
    return splat_count <= MOST_SPHERES ? 4 * splat_count : 0;
}

/* Allocates chunks and spheres of a batch. Returns 0 where memory runs out. */
static int allocate_bounds(psplat_renderer *renderer, const psplat_batch *batch,
                           psplat_model_batch *out) {
    size_t count = batch->splat_count, floats = sphere_floats(count);
    out->chunks =
        psplat_allocate(&renderer->allocator, psplat_chunk_count(count), sizeof *out->chunks);
    if (floats) out->spheres = psplat_allocate(&renderer->allocator, floats, sizeof(float));
    return out->chunks && (out->spheres || !floats);
}

static psplat_result upload_batch(psplat_renderer *renderer, psplat_model *model, size_t index,
                                  const psplat_asset *asset, float *staging, psplat_error *error) {
    const psplat_batch *batch = psplat_asset_batch(asset, index);
    const psplat_packed *packed = psplat_asset_packed(asset, index);
    const psplat_model_batch *twin = find_primitive(model, index, batch->primitive);
    psplat_model_batch *out = &model->batches[index];
    describe_batch(batch, out);
    out->shares_place = index > 0 && !memcmp(out->model, out[-1].model, sizeof out->model);
    psplat_model_use_images(renderer, model, batch, out);
    if (twin) {
        out->splats = twin->splats;
        out->clips = twin->clips;
        out->finishes = twin->finishes;
        out->texcoords = twin->texcoords;
        out->chunks = twin->chunks;
        out->spheres = twin->spheres;
        out->sagitta = twin->sagitta;
        out->uncut_count = twin->uncut_count;
        out->number = twin->number;
        enlarge_box(out);
        return PSPLAT_OK;
    }
    out->is_owner = 1;
    out->number = renderer->batch_count++;
    if (!allocate_bounds(renderer, batch, out))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for bounds of %zu splats",
                           batch->splat_count);
    psplat_result result = upload_textures(renderer, batch, packed, out, staging, error);
    enlarge_box(out);
    enlarge_spheres(out);
    return result;
}

static psplat_result check_sizes(const psplat_gl *gl, const psplat_asset *asset,
                                 psplat_error *error) {
    for (size_t i = 0; i < psplat_asset_all_batch_count(asset); ++i) {
        const psplat_batch *batch = psplat_asset_batch(asset, i);
        size_t row = (size_t)psplat_packing_of(batch).row_splats, count = batch->splat_count;
        size_t most = (size_t)gl->max_texture_size * row;
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
    psplat_result result = psplat_gl_state_take(&state, gl, PSPLAT_UNIT_COUNT, error);
    if (result != PSPLAT_OK) return result;
    psplat_gl_errors(gl, NULL);
    for (size_t i = 0; i < model->batch_count && result == PSPLAT_OK; ++i)
        result = upload_batch(renderer, model, i, asset, staging, error);
    if (result == PSPLAT_OK) result = psplat_gl_errors(gl, error);
    psplat_gl_state_restore(&state, gl);
    return result;
}

static psplat_result upload_all(psplat_renderer *renderer, const psplat_asset *asset,
                                psplat_model *model, psplat_error *error) {
    size_t size = sizeof(float) * MAX_ROW_FLOATS * ROWS_PER_UPLOAD;
    psplat_result result = psplat_model_load_images(renderer, asset, model, error);
    if (result != PSPLAT_OK) return psplat_gl_finish(&renderer->gl, result, error);
    float *staging = psplat_allocate(&renderer->allocator, 1, size);
    if (!staging) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory to pack splats");
    result = upload_batches(renderer, asset, model, staging, error);
    psplat_resize(&renderer->allocator, staging, size, 0);
    return psplat_gl_finish(&renderer->gl, result, error);
}

/* Frees a model that holds nothing of GL. */
static void free_model(const psplat_allocator *allocator, psplat_model *model) {
    if (model->batches)
        psplat_resize(allocator, model->batches, model->batch_count * sizeof *model->batches, 0);
    if (model->levels)
        psplat_resize(allocator, model->levels, model->level_count * sizeof *model->levels, 0);
    psplat_resize(allocator, model, sizeof *model, 0);
}

/* Allocates a model of empty batches with the levels of an asset. Returns NULL where memory runs
 * out. */
static psplat_model *allocate_model(const psplat_allocator *allocator, const psplat_asset *asset) {
    psplat_model *model = psplat_allocate(allocator, 1, sizeof *model);
    if (!model) return NULL;
    model->batch_count = psplat_asset_all_batch_count(asset);
    model->level_count = psplat_asset_level_count(asset);
    psplat_asset_bounds(asset, model->bounds_min, model->bounds_max);
    model->batches = psplat_allocate(allocator, model->batch_count, sizeof *model->batches);
    model->levels = psplat_allocate(allocator, model->level_count, sizeof *model->levels);
    if (!model->batches || !model->levels) {
        free_model(allocator, model);
        return NULL;
    }
    for (size_t i = 0; i < model->level_count; ++i)
        model->levels[i] = *psplat_asset_get_level(asset, i);
    return model;
}

psplat_result psplat_model_create(psplat_renderer *renderer, const psplat_asset *asset,
                                  psplat_model **model, psplat_error *error) {
    if (model) *model = NULL;
    if (!renderer || !asset || !model)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "renderer, asset and model must not be NULL");
    psplat_result result = check_sizes(&renderer->gl, asset, error);
    if (result != PSPLAT_OK) return result;

    psplat_model *made = allocate_model(&renderer->allocator, asset);
    if (!made)
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu batches",
                           psplat_asset_all_batch_count(asset));
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
        psplat_gl_texture_delete(&renderer->gl, &batch->splats);
        psplat_gl_texture_delete(&renderer->gl, &batch->clips);
        psplat_gl_texture_delete(&renderer->gl, &batch->finishes);
        psplat_gl_texture_delete(&renderer->gl, &batch->texcoords);
        size_t chunk_count = psplat_chunk_count((size_t)batch->splat_count);
        if (batch->chunks)
            psplat_resize(&renderer->allocator, batch->chunks, chunk_count * sizeof(psplat_chunk),
                          0);
        size_t floats = sphere_floats((size_t)batch->splat_count);
        if (batch->spheres)
            psplat_resize(&renderer->allocator, batch->spheres, floats * sizeof(float), 0);
    }
    psplat_model_drop_images(renderer, model);
    free_model(&renderer->allocator, model);
}

psplat_model_info psplat_model_describe(const psplat_model *model) {
    psplat_model_info info = {0};
    for (size_t i = 0; model && i < model->batch_count; ++i) {
        const psplat_model_batch *batch = &model->batches[i];
        if (!batch->level) {
            info.splat_count += (size_t)batch->splat_count;
            info.batch_count += 1;
        }
        if (batch->is_owner)
            info.bytes += batch->splats.bytes + batch->clips.bytes + batch->finishes.bytes +
                          batch->texcoords.bytes;
    }
    if (model) info.level_count = model->level_count;
    for (size_t i = 0; model && i < model->image_count; ++i)
        info.bytes += model->images[i].texture.bytes;
    return info;
}
