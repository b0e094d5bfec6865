/* SPDX-License-Identifier: MIT
 *
 * animation.c - reads animations (glTF 2.0 section 3.11). Only channels that move nodes are read;
 * weights of morph targets and the targets of extensions do not move splats. Each accessor is
 * decoded and checked once, however many samplers share it.
 */
#include "asset/animation.h"

#include <math.h>
#include <string.h>

/* How many times over the bytes of buffers may be read by accessors that overlap. Exporters repeat
 * few accessors, and without a limit a small file could fill the memory. */
enum { MOST_OVERLAP = 4 };

enum { FLOATS = 1 << (PSPLAT_FLOAT - PSPLAT_BYTE), INTEGERS = 0xf };

static const psplat_attribute_type times_type = {"the times of a sampler", {{1, 1, 1, FLOATS, 0}}};
static const psplat_attribute_type vectors_type = {"the values of a sampler",
                                                   {{1, 3, 3, FLOATS, 0}}};
static const psplat_attribute_type rotations_type = {"the rotations of a sampler",
                                                     {{1, 4, 4, FLOATS | INTEGERS, 0}}};

/* An accessor that samplers read. */
typedef struct track {
    psplat_reader reader;
    float *values;                       /* NULL until it is read */
    int is_time, is_rotation, is_spline; /* checked as such */
} track;

typedef struct sampler {
    psplat_json_value json;
    psplat_keys keys;
    size_t components; /* of its values; 0 until it is read */
} sampler;

/* What reading all animations shares. */
typedef struct reading {
    psplat_gltf *gltf;
    psplat_rig *rig;
    track *tracks;    /* one for each accessor */
    size_t bytes;     /* of all tracks read so far */
    size_t *animated; /* of each node: 1 + its index among the transforms that move, or 0 */
    size_t *moved[3]; /* of each node and path: 1 + the last animation that moves it, or 0 */
} reading;

static psplat_result fail_memory(const psplat_gltf *gltf, psplat_json_value at) {
    return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, at),
                       "no memory for the animations");
}

/* ---- tracks ---------------------------------------------------------------------------------- */

static psplat_result fail_element(const psplat_gltf *gltf, const psplat_reader *reader,
                                  const char *name, size_t index, const char *what) {
    const psplat_buffer *buffer = reader->buffer;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE,
                       psplat_buffer_offset(buffer, reader->start + index * reader->stride),
                       "%s%s%.80s: number %zu %s", name, buffer->path ? " in " : "",
                       buffer->path ? buffer->path : "", index, what);
}

static psplat_result check_times(const psplat_gltf *gltf, const track *t) {
    for (size_t i = 0; i < t->reader.count; ++i) {
        if (t->values[i] < 0)
            return fail_element(gltf, &t->reader, times_type.name, i, "is negative");
        if (i && !(t->values[i] > t->values[i - 1]))
            return fail_element(gltf, &t->reader, times_type.name, i,
                                "is not after the one before it");
    }
    return PSPLAT_OK;
}

/* Gives quaternions length 1. The tolerance is what rounding to bytes makes of them. */
static psplat_result normalise(const psplat_gltf *gltf, const track *t, size_t first, size_t step) {
    for (size_t i = first; i < t->reader.count; i += step) {
        float *q = t->values + 4 * i;
        double sum = 0;
        for (int k = 0; k < 4; ++k) sum += (double)q[k] * (double)q[k];
        double length = sqrt(sum);
        if (!(length >= 0.99 && length <= 1.01))
            return fail_element(gltf, &t->reader, rotations_type.name, i,
                                "is not a unit quaternion");
        for (int k = 0; k < 4; ++k) q[k] = (float)((double)q[k] / length);
    }
    return PSPLAT_OK;
}

static psplat_result decode(reading *r, psplat_json_value at, const psplat_attribute_type *type,
                            track *t) {
    psplat_gltf *gltf = r->gltf;
    const psplat_reader *reader = &t->reader;
    size_t numbers = reader->count * reader->components;
    r->bytes += psplat_reader_bytes(reader);
    if (r->bytes / MOST_OVERLAP > gltf->loaded_bytes)
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, psplat_gltf_offset(gltf, at),
                           "the accessors of animations overlap too much in %zu bytes of buffers",
                           gltf->loaded_bytes);
    t->values = psplat_arena_reserve(gltf->kept, numbers, sizeof *t->values);
    if (!t->values) return fail_memory(gltf, at);
    psplat_reader_get(reader, 0, reader->count, t->values);
    for (size_t i = 0; i < numbers; ++i)
        if (!isfinite(t->values[i]))
            return fail_element(gltf, reader, type->name, i / reader->components, "is not finite");
    return PSPLAT_OK;
}

static psplat_result read_track(reading *r, psplat_json_value value,
                                const psplat_attribute_type *type, const track **out) {
    size_t index = 0;
    psplat_gltf *gltf = r->gltf;
    psplat_result result = psplat_gltf_index(gltf, value, type->name, gltf->accessor_count, &index);
    if (result) return result;
    track *t = &r->tracks[index];
    *out = t;
    psplat_reader reader = t->reader;
    /* What has been read as something else is checked anew, since types differ. */
    result = psplat_reader_open(gltf, value, type, 1, PSPLAT_NONE, &reader);
    if (result || t->values) return result;
    t->reader = reader;
    return decode(r, value, type, t);
}

/* ---- samplers -------------------------------------------------------------------------------- */

static psplat_result read_interpolation(const psplat_gltf *gltf, psplat_json_value value,
                                        psplat_interpolation *out) {
    static const char *const names[] = {"LINEAR", "STEP", "CUBICSPLINE"};
    *out = PSPLAT_LINEAR;
    if (!value) return PSPLAT_OK;
    psplat_result result =
        psplat_json_expect(&gltf->json, value, PSPLAT_JSON_STRING, "interpolation");
    if (result) return result;
    for (size_t i = 0; i < 3; ++i)
        if (psplat_json_equals(&gltf->json, value, names[i])) {
            *out = (psplat_interpolation)i;
            return PSPLAT_OK;
        }
    return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, value),
                       "interpolation is none of LINEAR, STEP and CUBICSPLINE");
}

static psplat_result check_sampler(const psplat_gltf *gltf, psplat_json_value json, track *times,
                                   track *values, const psplat_keys *keys) {
    int is_spline = keys->interpolation == PSPLAT_CUBICSPLINE;
    size_t wanted = is_spline ? 3 : 1;
    psplat_result result = PSPLAT_OK;
    if (values->reader.count % wanted || values->reader.count / wanted != times->reader.count)
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, json),
                           "a sampler has %zu values for %zu times", values->reader.count,
                           times->reader.count);
    if (!times->is_time) result = check_times(gltf, times);
    times->is_time = 1;
    if (result || values->reader.components != 4) return result;
    int *is_checked = is_spline ? &values->is_spline : &values->is_rotation;
    if (!*is_checked) result = normalise(gltf, values, is_spline ? 1 : 0, wanted);
    *is_checked = 1;
    return result;
}

static psplat_result read_sampler(reading *r, sampler *s, const psplat_attribute_type *type) {
    static const char *const names[] = {"input", "output", "interpolation"};
    psplat_gltf *gltf = r->gltf;
    psplat_json_value members[3];
    const track *times = NULL, *values = NULL;
    psplat_result result = psplat_json_members(&gltf->json, s->json, names, 3, members);
    for (size_t i = 0; i < 2 && !result; ++i)
        result = psplat_gltf_require(gltf, s->json, members[i], names[i]);
    if (!result) result = read_interpolation(gltf, members[2], &s->keys.interpolation);
    if (!result) result = read_track(r, members[0], &times_type, &times);
    if (!result) result = read_track(r, members[1], type, &values);
    if (!result)
        result = check_sampler(gltf, s->json, &r->tracks[times - r->tracks],
                               &r->tracks[values - r->tracks], &s->keys);
    if (result) return result;
    s->keys.times = times->values;
    s->keys.values = values->values;
    s->keys.count = times->reader.count;
    s->components = values->reader.components;
    return PSPLAT_OK;
}

/* ---- channels -------------------------------------------------------------------------------- */

typedef struct target {
    size_t node; /* or PSPLAT_NONE: it moves nothing that splats follow */
    psplat_path path;
    psplat_json_value json;
} target;

static psplat_result read_target(const psplat_gltf *gltf, psplat_json_value json, target *out) {
    static const char *const names[] = {"node", "path"};
    static const char *const paths[] = {"translation", "rotation", "scale"};
    psplat_json_value members[2];
    out->json = json;
    out->node = PSPLAT_NONE;
    psplat_result result = psplat_json_members(&gltf->json, json, names, 2, members);
    if (!result) result = psplat_gltf_require(gltf, json, members[1], names[1]);
    if (!result) result = psplat_json_expect(&gltf->json, members[1], PSPLAT_JSON_STRING, "path");
    for (size_t i = 0; i < 3 && !result && members[0]; ++i)
        if (psplat_json_equals(&gltf->json, members[1], paths[i])) {
            out->path = (psplat_path)i;
            result = psplat_gltf_index(gltf, members[0], "node", gltf->node_count, &out->node);
        }
    return result;
}

/* Finds the transform that a channel moves; the first channel of a node makes it. */
static psplat_result find_animated(reading *r, const target *t, size_t *index) {
    psplat_gltf *gltf = r->gltf;
    psplat_rig *rig = r->rig;
    double matrix[16];
    int has_matrix = 0;
    if (r->animated[t->node]) {
        *index = r->animated[t->node] - 1;
        return PSPLAT_OK;
    }
    *index = rig->animated_count;
    psplat_result result =
        psplat_node_transform(gltf, t->node, &rig->rest[*index], matrix, &has_matrix);
    if (!result && has_matrix)
        result = psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, t->json),
                             "node %zu has a matrix, which cannot be animated", t->node);
    if (result) return result;
    r->animated[t->node] = ++rig->animated_count;
    rig->nodes[rig->index_of[t->node]].animated = *index;
    return PSPLAT_OK;
}

/* Notes what a channel moves, which no other channel of its animation may. */
static psplat_result note_target(reading *r, size_t animation, const target *t) {
    size_t *moved = &r->moved[t->path][t->node];
    if (*moved == animation + 1)
        return psplat_fail(r->gltf->error, PSPLAT_ERROR_FORMAT,
                           psplat_gltf_offset(r->gltf, t->json),
                           "two channels of an animation move the same of node %zu", t->node);
    *moved = animation + 1;
    return PSPLAT_OK;
}

static psplat_result read_channel(reading *r, size_t index, psplat_json_value json,
                                  sampler *samplers, size_t sampler_count) {
    static const char *const names[] = {"sampler", "target"};
    psplat_gltf *gltf = r->gltf;
    psplat_rig_animation *animation = &r->rig->animations[index];
    psplat_json_value members[2];
    size_t at = 0;
    target t;
    psplat_result result = psplat_json_members(&gltf->json, json, names, 2, members);
    for (size_t i = 0; i < 2 && !result; ++i)
        result = psplat_gltf_require(gltf, json, members[i], names[i]);
    if (!result) result = read_target(gltf, members[1], &t);
    if (!result) result = psplat_gltf_index(gltf, members[0], names[0], sampler_count, &at);
    /* What moves no splats may be of a kind that this reader does not know. */
    if (result || t.node == PSPLAT_NONE || r->rig->index_of[t.node] == PSPLAT_NONE) return result;
    sampler *s = &samplers[at];
    int turns = t.path == PSPLAT_PATH_ROTATION;
    result = note_target(r, index, &t);
    if (!result && !s->components)
        result = read_sampler(r, s, turns ? &rotations_type : &vectors_type);
    if (result) return result;
    if (s->components != (turns ? 4u : 3u))
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, json),
                           "a sampler of %zu numbers moves what has %d", s->components,
                           turns ? 4 : 3);
    ++animation->info.channel_count;
    animation->info.duration =
        fmax(animation->info.duration, (double)s->keys.times[s->keys.count - 1]);
    psplat_channel *channel = &animation->channels[animation->channel_count++];
    *channel = (psplat_channel){.keys = s->keys, .path = t.path};
    return find_animated(r, &t, &channel->animated);
}

/* ---- animations ------------------------------------------------------------------------------ */

static psplat_result read_name(const psplat_gltf *gltf, psplat_json_value value,
                               const char **name) {
    char *text = NULL;
    size_t size = 0;
    *name = "";
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_expect(&gltf->json, value, PSPLAT_JSON_STRING, "name");
    if (!result) result = psplat_json_string(&gltf->json, value, gltf->kept, &text, &size);
    if (!result) *name = text;
    return result;
}

static psplat_result list_samplers(psplat_gltf *gltf, psplat_json_value array, sampler **samplers,
                                   size_t *count) {
    void *table = NULL;
    psplat_json_value value = 0;
    psplat_result result =
        psplat_gltf_table(gltf, array, "samplers", sizeof **samplers, &table, count);
    *samplers = table;
    for (size_t i = 0; i < *count && !result; ++i) {
        value =
            i ? psplat_json_next(&gltf->json, array, value) : psplat_json_first(&gltf->json, array);
        (*samplers)[i].json = value;
    }
    return result;
}

static psplat_result read_animation(reading *r, size_t index, psplat_json_value json) {
    static const char *const names[] = {"channels", "samplers", "name"};
    psplat_gltf *gltf = r->gltf;
    psplat_rig_animation *animation = &r->rig->animations[index];
    psplat_json_value members[3];
    sampler *samplers = NULL;
    size_t sampler_count = 0;
    psplat_result result = psplat_json_members(&gltf->json, json, names, 3, members);
    if (!result) result = read_name(gltf, members[2], &animation->info.name);
    if (!result) result = list_samplers(gltf, members[1], &samplers, &sampler_count);
    if (!result)
        result = psplat_json_expect(&gltf->json, members[0], PSPLAT_JSON_ARRAY, "channels");
    if (result || !members[0]) return result;
    animation->channels = psplat_arena_take(gltf->kept, psplat_json_length(&gltf->json, members[0]),
                                            sizeof *animation->channels);
    if (!animation->channels) return fail_memory(gltf, json);
    psplat_json_value value = psplat_json_first(&gltf->json, members[0]);
    for (; value && !result; value = psplat_json_next(&gltf->json, members[0], value))
        result = read_channel(r, index, value, samplers, sampler_count);
    return result;
}

/* ---- the rig --------------------------------------------------------------------------------- */

static int shows_splats(const psplat_gltf *gltf, const psplat_node *node) {
    return node->in_scene && node->mesh != PSPLAT_NONE && gltf->meshes[node->mesh].set_count;
}

/* Adds a node and those above it that are not in the rig yet, parents first. path has room for all
 * nodes. */
static psplat_result add_path(const psplat_gltf *gltf, size_t node, size_t *path, psplat_rig *rig) {
    size_t depth = 0;
    int has_matrix;
    psplat_result result = PSPLAT_OK;
    for (; node != PSPLAT_NONE && rig->index_of[node] == PSPLAT_NONE;
         node = gltf->nodes[node].parent)
        path[depth++] = node;
    while (depth-- && !result) {
        size_t at = path[depth], parent = gltf->nodes[at].parent;
        psplat_rig_node *out = &rig->nodes[rig->node_count];
        psplat_transform transform;
        out->parent = parent == PSPLAT_NONE ? PSPLAT_NONE : rig->index_of[parent];
        out->animated = PSPLAT_NONE;
        result = psplat_node_transform(gltf, at, &transform, out->matrix, &has_matrix);
        rig->index_of[at] = rig->node_count++;
    }
    return result;
}

/* Counts the nodes that lead to splats. index_of is PSPLAT_NONE before and after; in between it
 * marks what has been counted. */
static size_t count_nodes(const psplat_gltf *gltf, size_t *index_of) {
    size_t count = 0;
    for (size_t i = 0; i < gltf->node_count; ++i) {
        size_t at = shows_splats(gltf, &gltf->nodes[i]) ? i : PSPLAT_NONE;
        for (; at != PSPLAT_NONE && index_of[at] == PSPLAT_NONE; at = gltf->nodes[at].parent) {
            index_of[at] = 0;
            ++count;
        }
    }
    for (size_t i = 0; i < gltf->node_count; ++i) index_of[i] = PSPLAT_NONE;
    return count;
}

static psplat_result make_nodes(psplat_gltf *gltf, psplat_rig *rig) {
    size_t *path = psplat_arena_take(gltf->scratch, gltf->node_count, sizeof *path);
    rig->index_of = psplat_arena_take(gltf->scratch, gltf->node_count, sizeof *rig->index_of);
    if (!path || !rig->index_of) return fail_memory(gltf, gltf->json_animations);
    for (size_t i = 0; i < gltf->node_count; ++i) rig->index_of[i] = PSPLAT_NONE;
    rig->nodes =
        psplat_arena_take(gltf->kept, count_nodes(gltf, rig->index_of), sizeof *rig->nodes);
    if (!rig->nodes) return fail_memory(gltf, gltf->json_animations);
    psplat_result result = PSPLAT_OK;
    for (size_t i = 0; i < gltf->node_count && !result; ++i)
        if (shows_splats(gltf, &gltf->nodes[i])) result = add_path(gltf, i, path, rig);
    return result;
}

static psplat_result begin(psplat_gltf *gltf, psplat_rig *rig, reading *r) {
    size_t count = gltf->node_count;
    *r = (reading){.gltf = gltf, .rig = rig};
    r->tracks = psplat_arena_take(gltf->scratch, gltf->accessor_count, sizeof *r->tracks);
    r->animated = psplat_arena_take(gltf->scratch, count, sizeof *r->animated);
    for (size_t i = 0; i < 3; ++i)
        r->moved[i] = psplat_arena_take(gltf->scratch, count, sizeof *r->moved[i]);
    rig->rest = psplat_arena_take(gltf->kept, rig->node_count, sizeof *rig->rest);
    int is_made = r->tracks && r->animated && r->moved[0] && r->moved[1] && r->moved[2];
    return is_made && rig->rest ? PSPLAT_OK : fail_memory(gltf, gltf->json_animations);
}

psplat_result psplat_animations_parse(psplat_gltf *gltf, psplat_rig *rig) {
    psplat_json_value array = gltf->json_animations, value = 0;
    reading r;
    *rig = (psplat_rig){0};
    psplat_result result = psplat_json_expect(&gltf->json, array, PSPLAT_JSON_ARRAY, "animations");
    size_t count = array && !result ? psplat_json_length(&gltf->json, array) : 0;
    if (result || !count) return result;
    rig->animations = psplat_arena_take(gltf->kept, count, sizeof *rig->animations);
    if (!rig->animations) return fail_memory(gltf, array);
    result = make_nodes(gltf, rig);
    if (!result) result = begin(gltf, rig, &r);
    for (; rig->animation_count < count && !result; ++rig->animation_count) {
        value = rig->animation_count ? psplat_json_next(&gltf->json, array, value)
                                     : psplat_json_first(&gltf->json, array);
        result = read_animation(&r, rig->animation_count, value);
    }
    return result;
}
