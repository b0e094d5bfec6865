/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * animation_file.c - animations in a glTF file: buffer views, accessors and the animations
 * themselves. Numbers stay the floats of the source, so that poses stay what they were.
 */
#include "export/animation_file.h"

#include "base/json_writer.h"
#include "export/buffer_layout.h"
#include "export/meshopt_codec.h"
#include "export/splat_attributes.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

/* ---- views ----------------------------------------------------------------------------------- */

static uint8_t *put_floats(uint8_t *out, const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], sizeof bits);
        out = psplat_put_integer(out, bits, 4);
    }
    return out;
}

/* Compresses a view unless that makes it longer, as it does with few keys. */
static int compress(const psplat_codec *codec, psplat_buffer_view *view) {
    size_t bound = codec->bound(view->rows, view->stride);
    view->packed = malloc(bound + 3);
    if (!view->packed) return 0;
    view->packed_size = codec->encode(view->packed, bound, view->bytes, view->rows, view->stride);
    if (view->packed_size && view->packed_size < view->rows * view->stride) return 1;
    int is_longer = view->packed_size > 0;
    free(view->packed);
    view->packed = NULL;
    view->packed_size = 0;
    return is_longer;
}

/* Makes the view of all tracks of so many components, if there are any. */
static int add_view(psplat_animation_file *file, const psplat_scene *scene,
                    const psplat_codec *codec, size_t components) {
    psplat_buffer_view *view = &file->views[file->view_count];
    size_t rows = 0;
    for (size_t i = 0; i < scene->track_count; ++i) {
        const psplat_scene_track *track = &scene->tracks[i];
        if (track->components != components) continue;
        file->places[i] =
            (psplat_attribute_place){.view = file->view_count, .offset = rows * 4 * components};
        rows += track->count;
    }
    if (!rows) return 1;
    ++file->view_count;
    *view = (psplat_buffer_view){
        .stride = 4 * components, .rows = rows, .capacity = rows, .kind = PSPLAT_VIEW_NUMBERS};
    view->bytes = malloc(rows * view->stride);
    if (!view->bytes) return 0;
    uint8_t *out = view->bytes;
    for (size_t i = 0; i < scene->track_count; ++i)
        if (scene->tracks[i].components == components)
            out = put_floats(out, scene->tracks[i].values, scene->tracks[i].count * components);
    return !codec || compress(codec, view);
}

psplat_result psplat_animation_file_make(const psplat_scene *scene, const psplat_codec *codec,
                                         psplat_animation_file *file, psplat_error *error) {
    *file = (psplat_animation_file){0};
    file->places = calloc(scene->track_count + 1, sizeof *file->places);
    if (file->places && add_view(file, scene, codec, 1) && add_view(file, scene, codec, 3) &&
        add_view(file, scene, codec, 4))
        return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the animations");
}

void psplat_animation_file_free(psplat_animation_file *file) {
    for (size_t i = 0; i < file->view_count; ++i) {
        free(file->views[i].bytes);
        free(file->views[i].packed);
    }
    free(file->places);
    *file = (psplat_animation_file){0};
}

/* ---- JSON ------------------------------------------------------------------------------------ */

void psplat_animation_file_write_accessors(psplat_writer *json, const psplat_animation_file *file,
                                           const psplat_scene *scene, size_t first_view) {
    static const char *const types[] = {"", "SCALAR", "", "VEC3", "VEC4"};
    for (size_t i = 0; i < scene->track_count; ++i) {
        const psplat_scene_track *track = &scene->tracks[i];
        psplat_writer_open(json, NULL, '{');
        psplat_writer_count(json, "bufferView", first_view + file->places[i].view);
        if (file->places[i].offset) psplat_writer_count(json, "byteOffset", file->places[i].offset);
        psplat_writer_count(json, "componentType", (size_t)PSPLAT_TYPE_FLOAT);
        psplat_writer_count(json, "count", track->count);
        psplat_writer_string(json, "type", types[track->components]);
        if (track->components == 1) { /* glTF wants the bounds of times */
            psplat_writer_floats(json, "min", &track->values[0], 1);
            psplat_writer_floats(json, "max", &track->values[track->count - 1], 1);
        }
        psplat_writer_close(json, '}');
    }
}

static void write_sampler(psplat_writer *json, const psplat_scene_sampler *sampler,
                          size_t first_accessor) {
    static const char *const interpolations[] = {"LINEAR", "STEP", "CUBICSPLINE"};
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "input", first_accessor + sampler->times);
    psplat_writer_count(json, "output", first_accessor + sampler->values);
    if (sampler->interpolation != PSPLAT_SCENE_LINEAR)
        psplat_writer_string(json, "interpolation", interpolations[sampler->interpolation]);
    psplat_writer_close(json, '}');
}

static void write_channel(psplat_writer *json, const psplat_scene_channel *channel) {
    static const char *const paths[] = {"translation", "rotation", "scale"};
    psplat_writer_open(json, NULL, '{');
    psplat_writer_count(json, "sampler", channel->sampler);
    psplat_writer_open(json, "target", '{');
    psplat_writer_count(json, "node", channel->node);
    psplat_writer_string(json, "path", paths[channel->path]);
    psplat_writer_close(json, '}');
    psplat_writer_close(json, '}');
}

void psplat_animation_file_write(psplat_writer *json, const psplat_scene *scene,
                                 size_t first_accessor) {
    if (!scene->animation_count) return;
    psplat_writer_open(json, "animations", '[');
    for (size_t i = 0; i < scene->animation_count; ++i) {
        const psplat_scene_animation *animation = &scene->animations[i];
        psplat_writer_open(json, NULL, '{');
        if (animation->name) psplat_writer_string(json, "name", animation->name);
        psplat_writer_open(json, "samplers", '[');
        for (size_t k = 0; k < animation->sampler_count; ++k)
            write_sampler(json, &animation->samplers[k], first_accessor);
        psplat_writer_close(json, ']');
        psplat_writer_open(json, "channels", '[');
        for (size_t k = 0; k < animation->channel_count; ++k)
            write_channel(json, &animation->channels[k]);
        psplat_writer_close(json, ']');
        if (animation->extras) psplat_writer_raw(json, "extras", animation->extras);
        psplat_writer_close(json, '}');
    }
    psplat_writer_close(json, ']');
}
