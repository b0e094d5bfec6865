/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * glb_writer.c - the glTF writer: splats and the graph of their scene become a complete GLB (spec
 * 3).
 *
 * It makes several layouts of the same data and keeps the smallest file. Equal splats give equal
 * bytes in every locale and on machines of either byte order.
 */
#include "export/glb_writer.h"

#include "base/json_writer.h"
#include "export/animation_file.h"
#include "export/buffer_layout.h"
#include "export/fallback_mesh_file.h"
#include "export/gltf_document.h"
#include "export/material_json.h"
#include "export/mesh_levels.h"
#include "export/meshopt_codec.h"
#include "export/splat_attributes.h"
#include "export/splat_stream.h"
#include "scene/scene.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The most splats of which all layouts are tried, streams among them. In larger files the JSON is a
 * negligible part, and one good layout saves the time: accessors, which are read without decoding
 * number after number. Chosen by hand. */
enum { MOST_SPLATS_TO_TRY = 200000 };

/* ---- what is refused ------------------------------------------------------------------------ */

/* Tells whether all values are finite: JSON cannot say infinity or NaN, and readers refuse both. */
static int all_finite(const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(values[i])) return 0;
    return 1;
}

/* Returns the name of an attribute that is not finite, or NULL if all are. */
static const char *infinite_texcoord(const psplat_texcoord *t) {
    if (!all_finite(t->at, 2)) return "TEXCOORD_0";
    if (!all_finite(t->along_u, 2)) return "TEXCOORD_U";
    if (!all_finite(t->along_v, 2)) return "TEXCOORD_V";
    if (!all_finite(t->along_uu, 2)) return "TEXCOORD_UU";
    if (!all_finite(t->along_uv, 2)) return "TEXCOORD_UV";
    return all_finite(t->along_vv, 2) ? NULL : "TEXCOORD_VV";
}

/* Returns the name of an attribute of a splat that is not finite, or NULL if all are. finish may be
 * NULL. */
static const char *infinite_part(const psplat_splat *s, const psplat_finish *finish) {
    if (!all_finite(s->center, 3)) return "POSITION";
    if (!all_finite(s->normal, 3)) return "NORMAL";
    if (!all_finite(s->color, 4)) return "COLOR_0";
    if (!all_finite(s->rotation, 4)) return "ROTATION";
    if (!all_finite(s->radius, 2)) return "SCALE";
    if (!all_finite(s->gradient, 3)) return "NORMAL_FIELD";
    if (!all_finite(s->shape, 5)) return "SHAPE";
    if (!all_finite(s->clip[0], 3 * PSPLAT_MAX_CLIP_LINES) ||
        !all_finite(s->bend, PSPLAT_MAX_CLIP_LINES))
        return "CLIP";
    if (!finish) return NULL;
    const float surface[3] = {finish->occlusion, finish->roughness, finish->metallic};
    if (!all_finite(finish->color_u, 3)) return "COLOR_U";
    if (!all_finite(finish->color_v, 3)) return "COLOR_V";
    if (!all_finite(surface, 3)) return "OCCLUSION_ROUGHNESS_METALLIC";
    return all_finite(finish->emissive, 3) ? NULL : "EMISSIVE";
}

/* Returns whether splats that have integers have steps for all that a run has. */
static int has_steps(const psplat_precision *precision, const psplat_run *run) {
    if (!(precision->unit > 0)) return 1;
    return (!run->is_curved || precision->shape_step > 0) &&
           (!run->has_texcoord || precision->texcoord_slope_step > 0) &&
           (!run->has_texcoord_bend || precision->texcoord_bend_step > 0) &&
           (!run->has_bends || precision->bend_step > 0);
}

/* Returns what a splat has that its run says it has not, or NULL. */
static const char *unexpected_part(const psplat_run *run, const psplat_splat *splat) {
    for (int k = 0; k < 5 && !run->is_curved; ++k)
        if (splat->shape[k] != 0) return "a shape";
    for (uint32_t i = 0; i < splat->clip_count && !run->has_bends; ++i)
        if (splat->bend[i] != 0) return "bent lines";
    return NULL;
}

static psplat_result check_run_splat(const psplat_run *run, size_t r, const psplat_splat *splat,
                                     size_t index, psplat_error *error) {
    const char *unexpected = unexpected_part(run, splat);
    if (splat->clip_count != run->clip_lines)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "splat %zu has not the %u clip lines of run %zu", index,
                           (unsigned)run->clip_lines, r);
    if (!unexpected) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "splat %zu has %s, run %zu has not", index,
                       unexpected, r);
}

static psplat_result check_runs(const psplat_splats *splats, psplat_error *error) {
    size_t index = 0, count = 0;
    for (size_t r = 0; r < splats->run_count; ++r) {
        const psplat_run *run = &splats->runs[r];
        if (!run->count || run->material >= splats->material_count ||
            run->clip_lines > PSPLAT_MAX_CLIP_LINES || run->seam_lines > run->clip_lines)
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "run %zu is empty or has a material or lines that there are not", r);
        if ((run->has_texcoord && !splats->texcoords) ||
            (run->has_texcoord_bend && !run->has_texcoord))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "run %zu has texture coordinates that there are not", r);
        if ((run->has_shape && !run->is_curved) || !has_steps(&splats->precision, run))
            return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                               "run %zu has shapes without being curved, or something without a "
                               "step for it",
                               r);
        for (size_t i = 0; i < run->count && index < splats->count; ++i, ++index) {
            psplat_result result = check_run_splat(run, r, &splats->splats[index], index, error);
            if (result) return result;
        }
        count += run->count;
    }
    if (count == splats->count) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "runs add up to %zu of %zu splats", count,
                       splats->count);
}

static psplat_result check_splats(const psplat_splats *splats, psplat_error *error) {
    psplat_result result = check_runs(splats, error);
    if (result) return result;
    for (size_t i = 0; i < splats->count; ++i) {
        const psplat_finish *finish = splats->finishes ? &splats->finishes[i] : NULL;
        const char *what = infinite_part(&splats->splats[i], finish);
        if (!what && splats->texcoords) what = infinite_texcoord(&splats->texcoords[i]);
        if (what)
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "splat %zu: %s is not finite", i,
                               what);
    }
    return PSPLAT_OK;
}

static psplat_result check(const psplat_scene *scene, const psplat_splats *splats,
                           psplat_error *error) {
    size_t count = 0;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
        result = check_splats(&splats[i], error);
        count += splats[i].count;
    }
    if (result || count) return result;
    return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "no splats to write");
}

/* ---- bytes ---------------------------------------------------------------------------------- */

static uint8_t *put_u32(uint8_t *out, uint32_t value) {
    for (int i = 0; i < 4; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

/* Puts the file together as glTF 2.0 section 4.4 defines it: header, JSON chunk padded with spaces,
 * BIN chunk. */
static psplat_result pack(const psplat_writer *json, const psplat_scene *scene,
                          const psplat_buffer_layout *layout, const psplat_materials *materials,
                          uint8_t **data, size_t *size, psplat_error *error) {
    enum { HEADERS = 12 + 8 + 8, MAGIC = 0x46546c67, JSON = 0x4e4f534a, BIN = 0x004e4942 };
    size_t bytes = 0, json_size = (json->size + 3) / 4 * 4;
    for (size_t i = 0; i < psplat_document_view_count(layout); ++i)
        bytes += psplat_buffer_view_bytes(psplat_document_view(layout, i));
    for (size_t i = 0; i < materials->image_count; ++i)
        bytes += psplat_image_view_bytes(&scene->materials.images[materials->images[i]]);
    size_t total = HEADERS + json_size + bytes;
    if (total > UINT32_MAX)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%zu bytes are more than the 4 GiB that a GLB can hold", total);
    uint8_t *out = calloc(total, 1);
    if (!out) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu bytes", total);
    *data = out;
    *size = total;
    out = put_u32(put_u32(put_u32(out, MAGIC), 2), (uint32_t)total);
    out = put_u32(put_u32(out, (uint32_t)json_size), JSON);
    memset(out, ' ', json_size);
    memcpy(out, json->text, json->size);
    out = put_u32(put_u32(out + json_size, (uint32_t)bytes), BIN);
    for (size_t i = 0; i < psplat_document_view_count(layout); ++i) {
        const psplat_buffer_view *view = psplat_document_view(layout, i);
        memcpy(out, view->packed ? view->packed : view->bytes,
               view->packed ? view->packed_size : view->rows * view->stride);
        out += psplat_buffer_view_bytes(view);
    }
    for (size_t i = 0; i < materials->image_count; ++i) {
        const psplat_image *image = &scene->materials.images[materials->images[i]];
        memcpy(out, image->bytes, image->size);
        out += psplat_image_view_bytes(image);
    }
    return PSPLAT_OK;
}

/* Makes the file of another plan, which replaces *data if it is smaller. */
static psplat_result try_plan(const psplat_scene *scene, const psplat_buffer_layout_plan *plan,
                              const psplat_materials *materials, psplat_buffer_layout *layout,
                              uint8_t **data, size_t *size, psplat_error *error) {
    psplat_writer json = {.compact = 1};
    uint8_t *tried = NULL;
    size_t tried_size = 0;
    psplat_result result = psplat_buffer_layout_make(plan, layout, error);
    if (!result && !psplat_document_write(&json, scene, layout, materials))
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the JSON");
    if (!result) result = pack(&json, scene, layout, materials, &tried, &tried_size, error);
    free(json.text);
    psplat_buffer_layout_clear(layout);
    if (result) return result;
    if (*data && *size <= tried_size) {
        free(tried);
        return PSPLAT_OK;
    }
    free(*data);
    *data = tried;
    *size = tried_size;
    return PSPLAT_OK;
}

static int has_curved_runs(const psplat_splats *splats) {
    for (size_t i = 0; i < splats->run_count; ++i)
        if (splats->runs[i].is_curved) return 1;
    return 0;
}

/* The least steps of POSITION over the longest side of a mesh, so that viewers that know no splats
 * show points where they are, by eye. */
enum { LEAST_POSITION_STEPS = 64 };

/* Returns the most low bits of positions that may be in streams. */
static uint32_t most_low_bits(const psplat_write_desc *desc, const psplat_buffer_layout *layout) {
    uint32_t most = desc->fallbacks || desc->gaussians ? 0 : PSPLAT_MOST_LOW_BITS;
    for (size_t i = 0; i < layout->mesh_count; ++i) {
        const psplat_attribute_table *table = &layout->tables[i];
        float low[3], high[3], longest = 0;
        if (!table->splats->count) continue;
        if (!psplat_stream_can_hold(table)) return 0;
        psplat_attribute_table_extent(table, 0, table->splats->count, low, high);
        for (int k = 0; k < 3; ++k) longest = fmaxf(longest, high[k] - low[k]);
        while (most && longest < LEAST_POSITION_STEPS * (float)(1u << most)) --most;
    }
    return most;
}

/* Tries streams with all low bits that POSITION may lack, and with and without compression of what
 * is beside them; then, in orders that take longer to find, the best of them and those with a bit
 * or two more or less. */
static psplat_result try_streams(const psplat_scene *scene, const psplat_write_desc *desc,
                                 const psplat_materials *materials, psplat_buffer_layout *layout,
                                 uint8_t **data, size_t *size, psplat_error *error) {
    uint32_t most = most_low_bits(desc, layout);
    enum { NEAR_BITS = 2 };
    psplat_buffer_layout_plan best = {.streams = 1};
    psplat_result result = PSPLAT_OK;
    for (uint32_t low_bits = 0; low_bits <= most && !result; ++low_bits)
        for (unsigned kind = 0; kind < 4 && !result; ++kind) {
            const psplat_buffer_layout_plan plan = {.streams = 1,
                                                    .low_bits = low_bits,
                                                    .flat_joins = (kind & 1) != 0,
                                                    .padding = 0.02,
                                                    .codec = kind & 2 ? desc->codec : NULL};
            size_t least = *data ? *size : SIZE_MAX;
            result = try_plan(scene, &plan, materials, layout, data, size, error);
            if (!result && *size < least) best = plan;
        }
    psplat_buffer_layout_plan plan = best;
    plan.short_orders = 1;
    for (plan.low_bits = 0; plan.low_bits <= most && !result; ++plan.low_bits)
        if (labs((long)plan.low_bits - (long)best.low_bits) <= NEAR_BITS)
            result = try_plan(scene, &plan, materials, layout, data, size, error);
    return result;
}

static psplat_result try_plans(const psplat_scene *scene, const psplat_write_desc *desc,
                               const psplat_materials *materials, psplat_buffer_layout *layout,
                               uint8_t **data, size_t *size, psplat_error *error) {
    enum { APART = 1, NORMALS = 2, ALIKE = 4, JOINED = 8, PADDED = 16, PLANS = 32 };
    static const psplat_buffer_layout_plan plain;
    const psplat_codec *codec = desc->codec;
    const unsigned large = codec ? APART | NORMALS | ALIKE : APART;
    unsigned plans = JOINED;
    size_t splats = 0;
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < layout->mesh_count; ++i) {
        splats += layout->tables[i].splats->count;
        if (has_curved_runs(layout->tables[i].splats)) plans = PLANS;
    }
    if (!splats) return try_plan(scene, &plain, materials, layout, data, size, error);
    if (codec && splats <= MOST_SPLATS_TO_TRY)
        result = try_streams(scene, desc, materials, layout, data, size, error);
    for (unsigned plan = 0; plan < plans && !result; ++plan) {
        const psplat_buffer_layout_plan tried = {.lines_apart = (plan & APART) != 0,
                                                 .normals_apart = (plan & NORMALS) != 0,
                                                 .rows_alike = (plan & ALIKE) != 0,
                                                 .flat_joins = (plan & JOINED) != 0,
                                                 .padding = !codec          ? 1
                                                            : plan & PADDED ? 0.02
                                                                            : 0.1,
                                                 .codec = codec};
        /* Normals apart need the filter of a codec, and without one padding costs what it costs. */
        if ((tried.normals_apart || plan & PADDED) && !codec) continue;
        if (splats > MOST_SPLATS_TO_TRY && plan != large) continue;
        result = try_plan(scene, &tried, materials, layout, data, size, error);
    }
    return result;
}

/* Fills the tables of attributes and the fallback meshes, which all plans share. */
static psplat_result fill(const psplat_splats *splats, const psplat_write_desc *desc,
                          psplat_buffer_layout *layout, psplat_fallback_file *fallbacks,
                          psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < layout->mesh_count && !result; ++i)
        result = psplat_attribute_table_fill(&splats[i], &layout->tables[i], error);
    for (size_t i = 0; i < layout->finest_count && !result && desc->gaussians; ++i)
        if (splats[i].count)
            psplat_attribute_table_add_gaussians(&layout->tables[i], desc->gaussians[i]);
    if (result || !desc->fallbacks) return result;
    layout->fallbacks = fallbacks;
    return psplat_fallback_file_make(desc->fallbacks, layout->tables, layout->finest_count,
                                     desc->codec, fallbacks, error);
}

/* Writes a scene of which the coarser levels are meshes. */
static psplat_result write_leveled(const psplat_leveled_scene *leveled,
                                   const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                   psplat_error *error) {
    const psplat_scene *scene = &leveled->scene;
    psplat_buffer_layout layout = {.tables = calloc(scene->mesh_count + 1, sizeof *layout.tables),
                                   .mesh_count = scene->mesh_count,
                                   .levels = desc->levels,
                                   .finest_count = leveled->finest_count};
    psplat_fallback_file fallbacks = {0};
    psplat_animation_file animations = {0};
    psplat_materials materials = {0};
    psplat_result result = PSPLAT_OK;
    if (!layout.tables)
        result = psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the file");
    if (!result) result = fill(leveled->splats, desc, &layout, &fallbacks, error);
    if (!result) result = psplat_animation_file_make(scene, desc->codec, &animations, error);
    if (scene->animation_count) layout.animations = &animations;
    if (!result) result = psplat_document_materials(scene, &layout, &materials, error);
    if (!result) result = try_plans(scene, desc, &materials, &layout, data, size, error);
    psplat_fallback_file_free(&fallbacks);
    psplat_animation_file_free(&animations);
    psplat_materials_free(&materials);
    for (size_t i = 0; i < scene->mesh_count && layout.tables; ++i)
        psplat_attribute_table_free(&layout.tables[i]);
    free(layout.tables);
    return result;
}

psplat_result psplat_scene_write(const psplat_scene *scene, const psplat_splats *splats,
                                 const psplat_write_desc *desc, uint8_t **data, size_t *size,
                                 psplat_error *error) {
    static const psplat_write_desc defaults;
    psplat_leveled_scene leveled = {.splats = NULL};
    if (!scene || !splats || !data || !size)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "scene, splats, data and size are required");
    if (!desc) desc = &defaults;
    *data = NULL;
    *size = 0;
    psplat_result result = psplat_leveled_scene_make(scene, splats, desc->levels, &leveled, error);
    if (!result) result = check(&leveled.scene, leveled.splats, error);
    if (!result) result = write_leveled(&leveled, desc, data, size, error);
    psplat_leveled_scene_free(&leveled);
    if (!result) return PSPLAT_OK;
    free(*data);
    *data = NULL;
    *size = 0;
    return result;
}

psplat_result psplat_scene_write_meshes(const psplat_scene *scene,
                                        const psplat_fallback_mesh *meshes,
                                        const psplat_codec *codec, uint8_t **data, size_t *size,
                                        psplat_error *error) {
    psplat_write_desc desc = {.codec = codec, .fallbacks = meshes};
    psplat_leveled_scene leveled = {.splats = NULL};
    psplat_splats *none = calloc(scene->mesh_count + 1, sizeof *none);
    *data = NULL;
    *size = 0;
    if (!none) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the file");
    /* Where a node would put splats it puts triangles. */
    for (size_t i = 0; i < scene->mesh_count; ++i)
        memcpy(none[i].origin, meshes[i].origin, sizeof none[i].origin);
    psplat_result result = psplat_leveled_scene_make(scene, none, NULL, &leveled, error);
    if (!result) result = write_leveled(&leveled, &desc, data, size, error);
    psplat_leveled_scene_free(&leveled);
    free(none);
    return result;
}

psplat_result psplat_glb_write(const psplat_splats *splats, const char *name,
                               const psplat_write_desc *desc, uint8_t **data, size_t *size,
                               psplat_error *error) {
    uint32_t root = 0;
    size_t length = name ? strlen(name) : 0;
    char *copy = calloc(length + 1, 1);
    if (!copy) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the name");
    if (length) memcpy(copy, name, length);
    psplat_scene_mesh mesh = {.name = length ? copy : NULL};
    psplat_scene_node node = {.name = mesh.name,
                              .rotation = {0, 0, 0, 1},
                              .scale = {1, 1, 1},
                              .camera = PSPLAT_NO_INDEX,
                              .light = PSPLAT_NO_INDEX};
    psplat_scene_view view = {.roots = &root, .root_count = 1};
    const psplat_scene scene = {.meshes = &mesh,
                                .mesh_count = 1,
                                .nodes = &node,
                                .node_count = 1,
                                .scenes = &view,
                                .scene_count = 1,
                                .is_made = 1};
    psplat_result result = psplat_scene_write(&scene, splats, desc, data, size, error);
    free(copy);
    return result;
}
