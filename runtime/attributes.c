/* SPDX-License-Identifier: MIT
 *
 * attributes.c - one primitive of splats: extension object (spec 3.1), attributes (3.2), and the
 * check of the extent against rescaling tools (6.2).
 */
#include "gltf.h"

#include <float.h>
#include <math.h>

#define BIT(type) (1u << ((type)-PSPLAT_BYTE))
#define FLOATS BIT(PSPLAT_FLOAT)
#define COLORS (FLOATS | BIT(PSPLAT_UNSIGNED_BYTE) | BIT(PSPLAT_UNSIGNED_SHORT))
#define ROTATIONS (FLOATS | BIT(PSPLAT_BYTE) | BIT(PSPLAT_SHORT))

static const psplat_attribute_type types[PSPLAT_ATTRIBUTES] = {
    {"POSITION", 3, 3, FLOATS},
    {"NORMAL", 3, 3, FLOATS},
    {"COLOR_0", 3, 4, COLORS},
    {PSPLAT_EXTENSION ":ROTATION", 4, 4, ROTATIONS},
    {PSPLAT_EXTENSION ":SCALE", 2, 2, FLOATS},
    {PSPLAT_EXTENSION ":NORMAL_FIELD", 2, 3, FLOATS},
    {PSPLAT_EXTENSION ":CLIP_0", 3, 3, FLOATS},
    {PSPLAT_EXTENSION ":CLIP_1", 3, 3, FLOATS},
    {PSPLAT_EXTENSION ":CLIP_2", 3, 3, FLOATS},
    {PSPLAT_EXTENSION ":CLIP_3", 3, 3, FLOATS},
};

const char *psplat_attribute_name(size_t attribute) {
    return types[attribute].name;
}

/* ---- the extension object ----------------------------------------------------------------- */

static psplat_result require(const psplat_gltf *gltf, psplat_json_value object,
                             psplat_json_value member, const char *what) {
    if (member) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, object),
                       "%s is missing", what);
}

/* A number that is a float above (or, where zero_is_allowed, not below) zero. */
static psplat_result parse_positive(const psplat_gltf *gltf, psplat_json_value value,
                                    const char *what, int zero_is_allowed, float *out) {
    double number = 0;
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_number(&gltf->json, value, what, &number);
    if (result) return result;
    if (number < 0 || number > (double)FLT_MAX || (!zero_is_allowed && (float)number <= 0))
        return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                           "%s must be %s 0 and a float", what,
                           zero_is_allowed ? "at least" : "greater than");
    *out = (float)number;
    return PSPLAT_OK;
}

static psplat_result parse_kernel(const psplat_gltf *gltf, psplat_json_value object,
                                  psplat_kernel *kernel) {
    static const char *const names[] = {"sharpness", "exponent"};
    psplat_json_value members[2];
    *kernel = (psplat_kernel){PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT};
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 2, members);
    if (!result) result = parse_positive(gltf, members[0], names[0], 0, &kernel->sharpness);
    if (!result) result = parse_positive(gltf, members[1], names[1], 0, &kernel->exponent);
    return result;
}

static psplat_result parse_version(const psplat_gltf *gltf, psplat_json_value value) {
    size_t version = 0;
    psplat_result result = psplat_json_integer(&gltf->json, value, "version", UINT32_MAX, &version);
    if (result || version == 1) return result;
    return psplat_fail(gltf->error, version ? PSPLAT_ERROR_UNSUPPORTED : PSPLAT_ERROR_RANGE,
                       psplat_gltf_offset(gltf, value),
                       "version %zu of " PSPLAT_EXTENSION " is not 1", version);
}

static psplat_result parse_extension(const psplat_gltf *gltf, psplat_json_value object,
                                     psplat_set *set, psplat_json_value *extent) {
    static const char *const names[] = {"version", "clipLines", "depthTolerance", "positionExtent",
                                        "kernel"};
    psplat_json_value members[5];
    size_t clip_lines = 0;
    psplat_result result = psplat_json_members(&gltf->json, object, names, 5, members);
    for (size_t i = 0; i < 4 && !result; ++i) result = require(gltf, object, members[i], names[i]);
    if (!result) result = parse_version(gltf, members[0]);
    if (!result)
        result = psplat_json_integer(&gltf->json, members[1], names[1], PSPLAT_MAX_CLIP_LINES,
                                     &clip_lines);
    if (!result) result = parse_positive(gltf, members[2], names[2], 1, &set->depth_tolerance);
    if (!result) result = parse_kernel(gltf, members[4], &set->kernel);
    set->clip_count = (uint32_t)clip_lines;
    *extent = members[3];
    return result;
}

/* ---- attributes --------------------------------------------------------------------------- */

/* The extension's names are accepted with and without their underscore, but not both at once. */
static psplat_result find_attributes(const psplat_gltf *gltf, psplat_json_value object,
                                     psplat_json_value found[PSPLAT_ATTRIBUTES]) {
    enum { OURS = PSPLAT_ATTRIBUTES - PSPLAT_ROTATION };
    const char *names[PSPLAT_ATTRIBUTES + OURS];
    psplat_json_value members[PSPLAT_ATTRIBUTES + OURS];
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) names[i] = types[i].name;
    static const char *const underscored[OURS] = {
        "_" PSPLAT_EXTENSION ":ROTATION",     "_" PSPLAT_EXTENSION ":SCALE",
        "_" PSPLAT_EXTENSION ":NORMAL_FIELD", "_" PSPLAT_EXTENSION ":CLIP_0",
        "_" PSPLAT_EXTENSION ":CLIP_1",       "_" PSPLAT_EXTENSION ":CLIP_2",
        "_" PSPLAT_EXTENSION ":CLIP_3"};
    for (size_t i = 0; i < OURS; ++i) names[PSPLAT_ATTRIBUTES + i] = underscored[i];
    psplat_result result =
        psplat_json_members(&gltf->json, object, names, PSPLAT_ATTRIBUTES + OURS, members);
    if (result) return result;
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        psplat_json_value other = i >= PSPLAT_ROTATION ? members[i + OURS] : 0;
        if (members[i] && other)
            return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, other),
                               "%s occurs with and without an underscore", types[i].name);
        found[i] = members[i] ? members[i] : other;
    }
    return PSPLAT_OK;
}

static int is_required(size_t attribute, uint32_t clip_count) {
    return attribute != PSPLAT_COLOR && attribute != PSPLAT_NORMAL_FIELD &&
           (attribute < PSPLAT_FIRST_CLIP || attribute - PSPLAT_FIRST_CLIP < clip_count);
}

static psplat_result open_readers(psplat_gltf *gltf, psplat_json_value object, uint32_t clip_count,
                                  psplat_readers *r) {
    psplat_json_value found[PSPLAT_ATTRIBUTES];
    psplat_result result = find_attributes(gltf, object, found);
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES && !result; ++i) {
        r->is_present[i] = found[i] != 0;
        if (is_required(i, clip_count)) result = require(gltf, object, found[i], types[i].name);
        if (!result && found[i] && i >= PSPLAT_FIRST_CLIP && i - PSPLAT_FIRST_CLIP >= clip_count)
            result = psplat_fail(
                gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, found[i]),
                "%s is present although clipLines is %u", types[i].name, (unsigned)clip_count);
        if (!result && found[i])
            result = psplat_reader_open(
                gltf, found[i], &types[i],
                i == PSPLAT_POSITION ? PSPLAT_NONE : r->of[PSPLAT_POSITION].count, &r->of[i]);
    }
    return result;
}

/* ---- the whole ---------------------------------------------------------------------------- */

/* Spec 6.2: another tool may have scaled POSITION, knowing nothing of SCALE. */
static psplat_result check_extent(const psplat_gltf *gltf, psplat_json_value value,
                                  const double found[3]) {
    double stated[3], largest = 0, difference = 0;
    psplat_result result = psplat_json_numbers(&gltf->json, value, "positionExtent", 3, stated);
    if (result) return result;
    for (size_t i = 0; i < 3; ++i) {
        if (stated[i] < 0)
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                               "positionExtent must not be negative");
        largest = fmax(largest, fmax(found[i], stated[i]));
        difference = fmax(difference, fabs(found[i] - stated[i]));
    }
    if (difference <= 1e-4 * largest) return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RESCALED, psplat_gltf_offset(gltf, value),
                       "POSITION extends over %g x %g x %g, was written as %g x %g x %g: another "
                       "tool rescaled it but not the radii",
                       found[0], found[1], found[2], stated[0], stated[1], stated[2]);
}

/* Splats take 128 bytes in memory and at least 32 in a file. A file may use its bytes for several
 * primitives, but not to make a small file fill the memory. */
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
    set->attributes = psplat_arena_take(gltf->kept, PSPLAT_ATTRIBUTES, sizeof *set->attributes);
    if (!set->attributes)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, 0, "no memory for attributes");
    for (size_t i = 0; i < PSPLAT_ATTRIBUTES; ++i) {
        const psplat_reader *reader = &r->of[i];
        if (!r->is_present[i]) continue;
        set->attributes[set->attribute_count++] =
            (psplat_attribute){.name = types[i].name,
                               .component_type = (uint32_t)reader->component_type,
                               .components = (uint32_t)reader->components,
                               .bytes = psplat_reader_bytes(reader)};
    }
    return PSPLAT_OK;
}

psplat_result psplat_set_parse(psplat_gltf *gltf, psplat_json_value attributes,
                               psplat_json_value extension, psplat_set *set) {
    psplat_json_value stated = 0;
    psplat_readers readers = {0};
    double extent[3];
    psplat_result result = parse_extension(gltf, extension, set, &stated);
    if (!result) result = open_readers(gltf, attributes, set->clip_count, &readers);
    if (result) return result;
    set->count = readers.of[PSPLAT_POSITION].count;
    set->has_color = readers.is_present[PSPLAT_COLOR];
    set->has_gamma = readers.of[PSPLAT_NORMAL_FIELD].components == 3;
    result = check_total(gltf, attributes, set->count);
    if (result) return result;
    set->splats = psplat_arena_reserve(gltf->kept, set->count, sizeof *set->splats);
    if (!set->splats)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, attributes),
                           "no memory for %zu splats", set->count);
    result = describe(gltf, &readers, set);
    if (!result) result = psplat_values_decode(gltf, &readers, set, extent);
    if (!result) result = check_extent(gltf, stated, extent);
    return result;
}
