/* SPDX-License-Identifier: MIT
 *
 * splat_set.c - one primitive of splats: its attributes (spec 3.2) or its stream (spec 3.12), and
 * the check of its extent, which reveals rescaling by another tool (spec 6.2).
 */
#include "asset/gltf.h"
#include "asset/stream.h"

#include <math.h>
#include <string.h>

/* The extension's names are accepted with and without their underscore, but not both at once. */
static psplat_result find_attributes(const psplat_gltf *gltf, psplat_json_value object,
                                     psplat_json_value found[PSPLAT_ATTRIBUTES]) {
    static const char *const underscored[PSPLAT_ATTRIBUTES] = {
        [PSPLAT_ROTATION] = "_" PSPLAT_EXTENSION ":ROTATION",
        [PSPLAT_TURN] = "_" PSPLAT_EXTENSION ":TURN",
        [PSPLAT_TILT] = "_" PSPLAT_EXTENSION ":TILT",
        [PSPLAT_SCALE] = "_" PSPLAT_EXTENSION ":SCALE",
        [PSPLAT_NORMAL_FIELD] = "_" PSPLAT_EXTENSION ":NORMAL_FIELD",
        [PSPLAT_SHAPE] = "_" PSPLAT_EXTENSION ":SHAPE",
        [PSPLAT_FIRST_CLIP] = "_" PSPLAT_EXTENSION ":CLIP_0",
        [PSPLAT_FIRST_CLIP + 1] = "_" PSPLAT_EXTENSION ":CLIP_1",
        [PSPLAT_FIRST_CLIP + 2] = "_" PSPLAT_EXTENSION ":CLIP_2",
        [PSPLAT_FIRST_CLIP + 3] = "_" PSPLAT_EXTENSION ":CLIP_3",
        [PSPLAT_COLOR_U] = "_" PSPLAT_EXTENSION ":COLOR_U",
        [PSPLAT_COLOR_V] = "_" PSPLAT_EXTENSION ":COLOR_V",
        [PSPLAT_ORM] = "_" PSPLAT_EXTENSION ":OCCLUSION_ROUGHNESS_METALLIC",
        [PSPLAT_EMISSIVE] = "_" PSPLAT_EXTENSION ":EMISSIVE",
        [PSPLAT_TEXCOORD_U] = "_" PSPLAT_EXTENSION ":TEXCOORD_U",
        [PSPLAT_TEXCOORD_V] = "_" PSPLAT_EXTENSION ":TEXCOORD_V",
        [PSPLAT_TEXCOORD_UU] = "_" PSPLAT_EXTENSION ":TEXCOORD_UU",
        [PSPLAT_TEXCOORD_UV] = "_" PSPLAT_EXTENSION ":TEXCOORD_UV",
        [PSPLAT_TEXCOORD_VV] = "_" PSPLAT_EXTENSION ":TEXCOORD_VV"};
    const char *names[2 * PSPLAT_ATTRIBUTES];
    psplat_json_value members[2 * PSPLAT_ATTRIBUTES];
    /* glTF's own names have one form, which is looked up twice. */
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        names[2 * i] = psplat_attribute_types[i].name;
        names[2 * i + 1] = underscored[i] ? underscored[i] : names[2 * i];
    }
    psplat_result result =
        psplat_json_members(&gltf->json, object, names, 2 * PSPLAT_ATTRIBUTES, members);
    if (result) return result;
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        psplat_json_value one = members[2 * i], other = underscored[i] ? members[2 * i + 1] : 0;
        if (one && other)
            return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, other),
                               "%s occurs with and without an underscore",
                               psplat_attribute_types[i].name);
        found[i] = one ? one : other;
    }
    return PSPLAT_OK;
}

static int is_clip_line(size_t attribute) {
    return attribute >= PSPLAT_FIRST_CLIP && attribute < PSPLAT_FIRST_CLIP + PSPLAT_MAX_CLIP_LINES;
}

/* The first order of texture coordinates needs those at the centre, the second needs the first, and
 * an order is complete. */
static void require_texcoords(const psplat_json_value found[PSPLAT_ATTRIBUTES],
                              int is_required[PSPLAT_ATTRIBUTES]) {
    int second =
        found[PSPLAT_TEXCOORD_UU] || found[PSPLAT_TEXCOORD_UV] || found[PSPLAT_TEXCOORD_VV];
    int first = second || found[PSPLAT_TEXCOORD_U] || found[PSPLAT_TEXCOORD_V];
    is_required[PSPLAT_TEXCOORD] = first;
    is_required[PSPLAT_TEXCOORD_U] = is_required[PSPLAT_TEXCOORD_V] = first;
    for (size_t i = PSPLAT_TEXCOORD_UU; i <= PSPLAT_TEXCOORD_VV; ++i) is_required[i] = second;
}

/* Checks which attributes are required, allowed and forbidden. */
static psplat_result check_presence(const psplat_gltf *gltf, psplat_json_value object,
                                    const psplat_json_value found[PSPLAT_ATTRIBUTES],
                                    uint32_t clip_count) {
    int is_required[PSPLAT_ATTRIBUTES] = {[PSPLAT_POSITION] = 1,
                                          [PSPLAT_NORMAL] = 1,
                                          [PSPLAT_ROTATION] = !found[PSPLAT_TURN],
                                          [PSPLAT_TURN] = found[PSPLAT_TILT] != 0,
                                          [PSPLAT_SCALE] = 1,
                                          [PSPLAT_COLOR_U] = found[PSPLAT_COLOR_V] != 0,
                                          [PSPLAT_COLOR_V] = found[PSPLAT_COLOR_U] != 0};
    require_texcoords(found, is_required);
    for (size_t i = 0; i < clip_count; ++i) is_required[PSPLAT_FIRST_CLIP + i] = 1;
    if (found[PSPLAT_ROTATION] && found[PSPLAT_TURN])
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT,
                           psplat_gltf_offset(gltf, found[PSPLAT_TURN]),
                           "a primitive has either ROTATION or TURN");
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        if (is_required[i] && !found[i])
            return psplat_gltf_require(gltf, object, found[i], psplat_attribute_types[i].name);
        if (found[i] && is_clip_line(i) && !is_required[i])
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, found[i]),
                               "%s is present although clipLines is %u",
                               psplat_attribute_types[i].name, (unsigned)clip_count);
    }
    return PSPLAT_OK;
}

/* Checks that SHAPE is there only where splats are curved, and that curved splats have all three
 * numbers of a shape (rule 18 of spec 9). */
static psplat_result check_curved(const psplat_gltf *gltf, psplat_json_value attributes,
                                  psplat_json_value shape, const psplat_readers *r,
                                  const psplat_set *set) {
    if (shape && !set->is_curved)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, shape),
                           "SHAPE is present although the primitive is not curved");
    if (!set->is_curved || shape || r->of[PSPLAT_NORMAL_FIELD].components == 3) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, attributes),
                       "a curved primitive has a NORMAL_FIELD of three numbers or a SHAPE");
}

static psplat_result open_readers(psplat_gltf *gltf, psplat_json_value object,
                                  const psplat_set *set, psplat_readers *r) {
    psplat_json_value found[PSPLAT_ATTRIBUTES];
    psplat_result result = find_attributes(gltf, object, found);
    if (!result) result = check_presence(gltf, object, found, set->clip_count);
    /* To the versions before 3, it is an attribute like any that they do not know. */
    if (set->version < 3) found[PSPLAT_TEXCOORD] = 0;
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES && !result; ++i) {
        size_t count = i == PSPLAT_POSITION ? PSPLAT_NONE : r->of[PSPLAT_POSITION].count;
        r->is_present[i] = found[i] != 0;
        if (found[i])
            result = psplat_reader_open(gltf, found[i], &psplat_attribute_types[i], set->version,
                                        count, &r->of[i]);
    }
    return result ? result : check_curved(gltf, object, found[PSPLAT_SHAPE], r, set);
}

/* Returns whether a line is stored with its bend. */
static int is_bent(const psplat_reader *reader) {
    return reader->components == (reader->component_type == PSPLAT_FLOAT ? 4u : 3u);
}

/* Checks that the extension object says what integers stand for (spec 3.9). */
static psplat_result check_ranges(const psplat_gltf *gltf, psplat_json_value extension,
                                  const psplat_readers *r, const psplat_set *set) {
    const struct {
        size_t attribute;
        const char *name;
        int is_stated;
    } ranges[] = {
        {PSPLAT_SCALE, "scaleRange, which the integers of SCALE need,", set->scale_range[1] > 0},
        {PSPLAT_TILT, "tiltRange, which the integers of TILT need,", set->tilt_range > 0},
        {PSPLAT_NORMAL_FIELD, "fieldRange, which the integers of NORMAL_FIELD need,",
         set->field_range > 0},
        {PSPLAT_SHAPE, "shapeRange, which the integers of SHAPE need,", set->shape_range > 0},
        {PSPLAT_COLOR_U, "colorRange, which the integers of COLOR_U need,", set->color_range > 0},
        {PSPLAT_COLOR_V, "colorRange, which the integers of COLOR_V need,", set->color_range > 0},
        {PSPLAT_TEXCOORD_U, "texcoordRange, which the integers of TEXCOORD_U need,",
         set->texcoord_range > 0},
        {PSPLAT_TEXCOORD_V, "texcoordRange, which the integers of TEXCOORD_V need,",
         set->texcoord_range > 0},
        {PSPLAT_TEXCOORD_UU, "texcoordBendRange, which the integers of TEXCOORD_UU need,",
         set->texcoord_bend_range > 0},
        {PSPLAT_TEXCOORD_UV, "texcoordBendRange, which the integers of TEXCOORD_UV need,",
         set->texcoord_bend_range > 0},
        {PSPLAT_TEXCOORD_VV, "texcoordBendRange, which the integers of TEXCOORD_VV need,",
         set->texcoord_bend_range > 0}};
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; ++i) {
        const psplat_reader *reader = &r->of[ranges[i].attribute];
        int needs = r->is_present[ranges[i].attribute] && reader->component_type != PSPLAT_FLOAT;
        if (needs && !ranges[i].is_stated)
            return psplat_gltf_require(gltf, extension, 0, ranges[i].name);
    }
    for (size_t i = PSPLAT_FIRST_CLIP; i < PSPLAT_FIRST_CLIP + set->clip_count; ++i)
        if (is_bent(&r->of[i]) && r->of[i].component_type != PSPLAT_FLOAT && !(set->bend_range > 0))
            return psplat_gltf_require(gltf, extension, 0,
                                       "bendRange, which the integers of bends need,");
    return PSPLAT_OK;
}

/* ---- the whole ---------------------------------------------------------------------------- */

/* Another tool may have scaled POSITION without knowing that SCALE has to follow (spec 6.2). */
static psplat_result compare_extents(const psplat_gltf *gltf, psplat_json_value value,
                                     const double stated[3], const double found[3]) {
    double largest = 0, difference = 0;
    for (size_t i = 0; i < 3; ++i) {
        largest = fmax(largest, fmax(found[i], stated[i]));
        difference = fmax(difference, fabs(found[i] - stated[i]));
    }
    if (difference <= 1e-4 * largest) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RESCALED, psplat_gltf_offset(gltf, value),
                       "POSITION extends over %g x %g x %g, was written as %g x %g x %g: another "
                       "tool rescaled it but not the radii",
                       found[0], found[1], found[2], stated[0], stated[1], stated[2]);
}

static psplat_result check_extent(const psplat_gltf *gltf, psplat_json_value value,
                                  const double found[3]) {
    double stated[3];
    psplat_result result = psplat_json_numbers(&gltf->json, value, "positionExtent", 3, stated);
    if (result) return result;
    if (stated[0] >= 0 && stated[1] >= 0 && stated[2] >= 0)
        return compare_extents(gltf, value, stated, found);
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                       "positionExtent must not be negative");
}

/* A splat takes 164 bytes in memory, 48 more with a finish, 56 more with texture coordinates, and
 * at least 11 in a file. A file may use its bytes for several primitives, but a small file must not
 * fill the memory that way. */
static psplat_result check_total(psplat_gltf *gltf, psplat_json_value attributes, size_t count) {
    if (count <= gltf->loaded_bytes / 8 && gltf->splat_total <= gltf->loaded_bytes / 8 - count) {
        gltf->splat_total += count;
        return PSPLAT_OK;
    }
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, attributes),
                       "the file's primitives use its %zu bytes of data too many times over",
                       gltf->loaded_bytes);
}

static psplat_result describe(const psplat_gltf *gltf, const psplat_readers *r, psplat_set *set) {
    size_t present = 0;
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) present += r->is_present[i] != 0;
    set->attributes = psplat_arena_take(gltf->kept, present, sizeof *set->attributes);
    if (!set->attributes)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, 0, "no memory for attributes");
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        const psplat_reader *reader = &r->of[i];
        if (!r->is_present[i]) continue;
        set->attributes[set->attribute_count++] = (psplat_attribute){
            .name = psplat_attribute_types[i].name,
            .component_type = reader->is_streamed ? 0 : (uint32_t)reader->component_type,
            .components = (uint32_t)reader->components,
            .is_compressed = reader->is_streamed || reader->view->decoded,
            .bytes = psplat_reader_bytes(reader),
            .stored = psplat_reader_stored(reader)};
    }
    return PSPLAT_OK;
}

/* Reserves the packed form. Where it is all that is kept, the other form is made chunk by chunk. */
static int reserve_packed(psplat_gltf *gltf, psplat_set *set) {
    const psplat_batch like = {.clip_count = set->clip_count,
                               .has_color = set->has_color,
                               .has_gamma = set->has_gamma,
                               .is_curved = set->is_curved,
                               .has_shape = set->has_shape,
                               .has_bends = set->has_bends,
                               .has_color_gradient = set->has_color_gradient,
                               .has_surface = set->has_surface,
                               .has_emissive = set->has_emissive,
                               .has_texcoord = set->has_texcoord,
                               .has_texcoord_bend = set->has_texcoord_bend,
                               .material = *set->material};
    set->packing = psplat_packing_of(&like);
    set->packed = psplat_packed_reserve(gltf->kept, &set->packing, set->count);
    if (!gltf->chunk_splats)
        gltf->chunk_splats =
            psplat_arena_reserve(gltf->scratch, PSPLAT_CHUNK_SPLATS, sizeof *gltf->chunk_splats);
    if (!gltf->chunk_finishes)
        gltf->chunk_finishes =
            psplat_arena_reserve(gltf->scratch, PSPLAT_CHUNK_SPLATS, sizeof *gltf->chunk_finishes);
    if (!gltf->chunk_texcoords)
        gltf->chunk_texcoords =
            psplat_arena_reserve(gltf->scratch, PSPLAT_CHUNK_SPLATS, sizeof *gltf->chunk_texcoords);
    return set->packed && gltf->chunk_splats && gltf->chunk_finishes && gltf->chunk_texcoords;
}

static int reserve_splats(psplat_gltf *gltf, psplat_set *set) {
    int varies = set->has_surface || set->has_emissive || set->has_color_gradient;
    set->splats = psplat_arena_reserve(gltf->kept, set->count, sizeof *set->splats);
    if (varies) set->finishes = psplat_arena_reserve(gltf->kept, set->count, sizeof *set->finishes);
    if (set->has_texcoord)
        set->texcoords = psplat_arena_reserve(gltf->kept, set->count, sizeof *set->texcoords);
    return set->splats && (set->finishes || !varies) && (set->texcoords || !set->has_texcoord);
}

static psplat_result reserve(psplat_gltf *gltf, psplat_json_value attributes, psplat_set *set) {
    if (gltf->only_draws ? reserve_packed(gltf, set) : reserve_splats(gltf, set)) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, attributes),
                       "no memory for %zu splats", set->count);
}

/* Notes what the attributes say of all splats. */
static void set_flags(const psplat_readers *r, psplat_set *set) {
    set->count = r->of[PSPLAT_POSITION].count;
    set->has_color = r->is_present[PSPLAT_COLOR];
    set->has_gamma = r->of[PSPLAT_NORMAL_FIELD].components == 3;
    set->has_shape = r->is_present[PSPLAT_SHAPE];
    for (size_t i = PSPLAT_FIRST_CLIP; i < PSPLAT_FIRST_CLIP + set->clip_count; ++i)
        set->has_bends |= is_bent(&r->of[i]);
    set->has_color_gradient = r->is_present[PSPLAT_COLOR_U];
    set->has_surface = r->is_present[PSPLAT_ORM];
    set->has_emissive = r->is_present[PSPLAT_EMISSIVE];
    set->has_texcoord = r->is_present[PSPLAT_TEXCOORD];
    set->has_texcoord_bend = r->is_present[PSPLAT_TEXCOORD_UU];
}

/* Adds a set to gltf. */
static psplat_result add_set(psplat_gltf *gltf, psplat_json_value attributes, psplat_set **set) {
    enum { FIRST_SETS = 16, MAX_SETS = 1 << 16 };
    if (gltf->set_count == MAX_SETS) {
        return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED,
                           psplat_gltf_offset(gltf, attributes),
                           "more than %d primitives of splats", MAX_SETS);
    }
    if (gltf->set_count == gltf->set_capacity) {
        size_t capacity = gltf->set_count ? 2 * gltf->set_count : FIRST_SETS;
        psplat_set *sets = psplat_arena_take(gltf->scratch, capacity, sizeof *sets);
        if (!sets) {
            return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY,
                               psplat_gltf_offset(gltf, attributes), "no memory for %zu primitives",
                               capacity);
        }
        if (gltf->set_count) memcpy(sets, gltf->sets, gltf->set_count * sizeof *sets);
        gltf->sets = sets;
        gltf->set_capacity = capacity;
    }
    *set = &gltf->sets[gltf->set_count++];
    return PSPLAT_OK;
}

/* Fills a set from its readers. */
static psplat_result fill_set(psplat_gltf *gltf, psplat_json_value attributes,
                              psplat_json_value material, const psplat_readers *readers,
                              psplat_set *set, double extent[3]) {
    set_flags(readers, set);
    psplat_result result = psplat_material_get(gltf, material, set->has_texcoord, &set->material);
    if (!result) result = check_total(gltf, attributes, set->count);
    if (!result) result = reserve(gltf, attributes, set);
    if (!result) result = describe(gltf, readers, set);
    return result ? result : psplat_values_decode(gltf, readers, set, extent);
}

/* ---- streams ------------------------------------------------------------------------------ */

/* Distances between integers are exact, so that every machine finds the same nearest splat. */
static psplat_result check_coarse(const psplat_gltf *gltf, psplat_json_value position,
                                  const psplat_reader *reader) {
    if (reader->component_type != PSPLAT_FLOAT && !reader->normalized) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_UNSUPPORTED, psplat_gltf_offset(gltf, position),
                       "POSITION: beside a stream, components must be integers that are not "
                       "normalized");
}

/* Opens the accessors beside a stream. */
static psplat_result open_beside_stream(psplat_gltf *gltf, psplat_json_value object,
                                        const psplat_stream *stream, psplat_readers *r) {
    psplat_json_value found[PSPLAT_ATTRIBUTES];
    int is_required[PSPLAT_ATTRIBUTES] = {0};
    psplat_result result = find_attributes(gltf, object, found);
    if (result) return result;
    require_texcoords(found, is_required);
    is_required[PSPLAT_POSITION] = 1;
    is_required[PSPLAT_TEXCOORD] |= stream->has_texcoord;
    is_required[PSPLAT_COLOR_U] = is_required[PSPLAT_COLOR_V] =
        found[PSPLAT_COLOR_U] || found[PSPLAT_COLOR_V];
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES && !result; ++i) {
        if (found[i] && psplat_stream_holds(stream, i))
            return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, found[i]),
                               "%s is present although the primitive has a stream",
                               psplat_attribute_types[i].name);
        if (is_required[i])
            result = psplat_gltf_require(gltf, object, found[i], psplat_attribute_types[i].name);
        r->is_present[i] = found[i] != 0;
        if (found[i] && !result)
            result = psplat_reader_open(gltf, found[i], &psplat_attribute_types[i],
                                        PSPLAT_EXTENSION_VERSION, stream->count, &r->of[i]);
    }
    return result ? result : check_coarse(gltf, found[PSPLAT_POSITION], &r->of[PSPLAT_POSITION]);
}

/* Reads how many lines of each section are seams. */
static psplat_result read_seams(const psplat_gltf *gltf, psplat_json_value list,
                                psplat_stream *stream) {
    psplat_json_value element = 0;
    psplat_result result = psplat_json_expect(&gltf->json, list, PSPLAT_JSON_ARRAY, "seamLines");
    if (result || !list) return result;
    if (psplat_json_length(&gltf->json, list) != stream->section_count)
        return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, list),
                           "seamLines has %zu elements, the stream %zu sections",
                           psplat_json_length(&gltf->json, list), stream->section_count);
    for (size_t i = 0; i < stream->section_count && !result; ++i) {
        size_t seams = 0;
        element =
            i ? psplat_json_next(&gltf->json, list, element) : psplat_json_first(&gltf->json, list);
        result = psplat_json_integer(&gltf->json, element, "seamLines",
                                     stream->sections[i].clip_count, &seams);
        stream->sections[i].seam_lines = (uint32_t)seams;
    }
    return result;
}

/* Makes a set of a section. all are the readers of the accessors beside the stream. */
static psplat_result add_section(psplat_gltf *gltf, psplat_json_value attributes,
                                 psplat_json_value material, const psplat_stream *stream,
                                 size_t section, const psplat_readers *all,
                                 const psplat_set *like) {
    const psplat_stream_section *kind = &stream->sections[section];
    psplat_readers readers = *all;
    double extent[3];
    psplat_set *set = NULL;
    psplat_result result = add_set(gltf, attributes, &set);
    if (result) return result;
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        readers.of[i].start += kind->first * readers.of[i].stride;
        readers.of[i].count = kind->count;
    }
    psplat_stream_readers(stream, section, &readers);
    *set = *like;
    set->kernel = stream->kernel;
    set->clip_count = kind->clip_count;
    set->seam_lines = kind->seam_lines;
    set->depth_tolerance = kind->depth_tolerance;
    set->is_curved = kind->is_curved;
    return fill_set(gltf, attributes, material, &readers, set, extent);
}

/* Decodes a primitive with a stream. like has what the extension object says. */
static psplat_result parse_streamed(psplat_gltf *gltf, psplat_json_value attributes,
                                    psplat_json_value extension, psplat_json_value material,
                                    psplat_json_value value, const psplat_set *like) {
    psplat_readers readers = {0};
    psplat_stream *stream = NULL;
    psplat_result result = psplat_stream_open(gltf, value, &stream);
    if (!result) result = read_seams(gltf, like->json_seam_lines, stream);
    if (!result) result = open_beside_stream(gltf, attributes, stream, &readers);
    if (!result) result = check_ranges(gltf, extension, &readers, like);
    if (!result) result = psplat_stream_decode(gltf, &readers, stream);
    if (!result) result = compare_extents(gltf, value, stream->extent, stream->found_extent);
    for (size_t i = 0; !result && i < stream->section_count; ++i)
        result = add_section(gltf, attributes, material, stream, i, &readers, like);
    return result;
}

/* ---- primitives --------------------------------------------------------------------------- */

psplat_result psplat_sets_parse(psplat_gltf *gltf, psplat_json_value attributes,
                                psplat_json_value extension, psplat_json_value material) {
    psplat_json_value stated = 0, stream = 0;
    psplat_readers readers = {0};
    psplat_set parsed = {0}, *set = NULL;
    double extent[3];
    psplat_result result = psplat_extension_parse(gltf, extension, &parsed, &stated, &stream);
    if (result) return result;
    if (stream) return parse_streamed(gltf, attributes, extension, material, stream, &parsed);
    result = open_readers(gltf, attributes, &parsed, &readers);
    if (!result) result = check_ranges(gltf, extension, &readers, &parsed);
    if (!result) result = add_set(gltf, attributes, &set);
    if (result) return result;
    *set = parsed;
    result = fill_set(gltf, attributes, material, &readers, set, extent);
    return result ? result : check_extent(gltf, stated, extent);
}
