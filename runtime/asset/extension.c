/* SPDX-License-Identifier: MIT
 *
 * extension.c - the extension object: what a primitive of splats says about itself (spec 3.1).
 */
#include "asset/gltf.h"

#include <float.h>

/* The members of the object. */
static const char *const names[] = {
    "version",    "clipLines",  "depthTolerance", "positionExtent",    "kernel",    "scaleRange",
    "tiltRange",  "fieldRange", "colorRange",     "turnRange",         "clipRange", "curved",
    "shapeRange", "bendRange",  "texcoordRange",  "texcoordBendRange", "stream",    "seamLines"};
enum { MEMBERS = sizeof names / sizeof *names };

/* Reads a number that is a float above zero or, where zero_is_allowed, not below zero. */
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
    static const char *const kernel_names[] = {"sharpness", "exponent"};
    psplat_json_value members[2];
    *kernel = (psplat_kernel){PSPLAT_DEFAULT_KERNEL_SHARPNESS, PSPLAT_DEFAULT_KERNEL_EXPONENT};
    if (!object) return PSPLAT_OK;
    psplat_result result = psplat_json_members(&gltf->json, object, kernel_names, 2, members);
    if (!result) result = parse_positive(gltf, members[0], kernel_names[0], 0, &kernel->sharpness);
    if (!result) result = parse_positive(gltf, members[1], kernel_names[1], 0, &kernel->exponent);
    return result;
}

static psplat_result parse_version(const psplat_gltf *gltf, psplat_json_value value,
                                   size_t *version) {
    psplat_result result = psplat_json_integer(&gltf->json, value, "version", UINT32_MAX, version);
    if (result || (*version >= 1 && *version <= PSPLAT_EXTENSION_VERSION)) return result;
    return psplat_fail(gltf->error, *version ? PSPLAT_ERROR_UNSUPPORTED : PSPLAT_ERROR_RANGE,
                       psplat_gltf_offset(gltf, value),
                       "version %zu of " PSPLAT_EXTENSION " is not one of 1 to %d", *version,
                       PSPLAT_EXTENSION_VERSION);
}

/* Reads the first and the last radius that integers stand for (spec 3.9). Both must be floats, as
 * all radii are. */
static psplat_result parse_scale_range(const psplat_gltf *gltf, psplat_json_value value,
                                       double range[2]) {
    if (!value) return PSPLAT_OK;
    psplat_result result = psplat_json_numbers(&gltf->json, value, "scaleRange", 2, range);
    if (result) return result;
    if ((float)range[0] > 0 && range[0] <= range[1] && range[1] <= (double)FLT_MAX)
        return PSPLAT_OK;
    return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                       "scaleRange must be two floats above 0, the larger one last");
}

/* Reads the factors by which the integers of a clip line's turn and distance are multiplied. The
 * bound 65536 is the greatest number of parts of a turn that a short can count, and more. */
static psplat_result parse_clip_range(const psplat_gltf *gltf, psplat_json_value value,
                                      float range[2]) {
    double numbers[2] = {1, 1};
    psplat_result result = PSPLAT_OK;
    if (value) result = psplat_json_numbers(&gltf->json, value, "clipRange", 2, numbers);
    if (result) return result;
    for (size_t i = 0; i < 2; ++i) {
        range[i] = (float)numbers[i];
        if (!(range[i] > 0 && numbers[i] <= 65536))
            return psplat_fail(gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, value),
                               "clipRange must be two floats above 0, at most 65536");
    }
    return PSPLAT_OK;
}

/* Reads what version 3 added; members are curved, shapeRange, bendRange, texcoordRange and
 * texcoordBendRange. Older primitives must not be curved, because a reader of their version would
 * show them flat. */
static psplat_result parse_version_3(const psplat_gltf *gltf, const psplat_json_value members[5],
                                     psplat_set *set) {
    psplat_result result = PSPLAT_OK;
    if (members[0])
        result = psplat_json_boolean(&gltf->json, members[0], "curved", &set->is_curved);
    if (!result && set->version < 3) {
        if (!set->is_curved) return PSPLAT_OK;
        return psplat_fail(
            gltf->error, PSPLAT_ERROR_UNSUPPORTED, psplat_gltf_offset(gltf, members[0]),
            "curved is of version 3 of " PSPLAT_EXTENSION ", the primitive states %zu",
            set->version);
    }
    if (!result) result = parse_positive(gltf, members[1], "shapeRange", 0, &set->shape_range);
    if (!result) result = parse_positive(gltf, members[2], "bendRange", 0, &set->bend_range);
    if (!result)
        result = parse_positive(gltf, members[3], "texcoordRange", 0, &set->texcoord_range);
    if (!result)
        result =
            parse_positive(gltf, members[4], "texcoordBendRange", 0, &set->texcoord_bend_range);
    return result;
}

static psplat_result parse_ranges(const psplat_gltf *gltf, const psplat_json_value members[6],
                                  psplat_set *set) {
    set->turn_range = 1;
    psplat_result result = parse_scale_range(gltf, members[0], set->scale_range);
    if (!result) result = parse_positive(gltf, members[1], "tiltRange", 0, &set->tilt_range);
    if (!result) result = parse_positive(gltf, members[2], "fieldRange", 0, &set->field_range);
    if (!result) result = parse_positive(gltf, members[3], "colorRange", 0, &set->color_range);
    if (!result) result = parse_positive(gltf, members[4], "turnRange", 0, &set->turn_range);
    if (!result) result = parse_clip_range(gltf, members[5], set->clip_range);
    return result;
}

/* Reads what is left for the object of a primitive with a stream (spec 3.12). */
static psplat_result parse_beside_stream(const psplat_gltf *gltf, const psplat_json_value *members,
                                         psplat_set *set) {
    psplat_result result = parse_positive(gltf, members[8], names[8], 0, &set->color_range);
    if (!result) result = parse_positive(gltf, members[14], names[14], 0, &set->texcoord_range);
    if (!result)
        result = parse_positive(gltf, members[15], names[15], 0, &set->texcoord_bend_range);
    set->json_seam_lines = members[17];
    for (size_t i = 1; i < 14 && !result; ++i)
        if (members[i] && i != 8)
            result =
                psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, members[i]),
                            "%s is present although the primitive has a stream", names[i]);
    return result;
}

psplat_result psplat_extension_parse(const psplat_gltf *gltf, psplat_json_value object,
                                     psplat_set *set, psplat_json_value *extent,
                                     psplat_json_value *stream) {
    psplat_json_value members[MEMBERS];
    size_t clip_lines = 0, seams = 0;
    psplat_result result = psplat_json_members(&gltf->json, object, names, MEMBERS, members);
    if (!result) result = psplat_gltf_require(gltf, object, members[0], names[0]);
    if (!result) result = parse_version(gltf, members[0], &set->version);
    if (result) return result;
    *stream = set->version >= 4 ? members[16] : 0;
    if (*stream) return parse_beside_stream(gltf, members, set);
    for (size_t i = 1; i < 4 && !result; ++i)
        result = psplat_gltf_require(gltf, object, members[i], names[i]);
    if (!result)
        result = psplat_json_integer(&gltf->json, members[1], names[1], PSPLAT_MAX_CLIP_LINES,
                                     &clip_lines);
    if (!result) result = parse_positive(gltf, members[2], names[2], 1, &set->depth_tolerance);
    if (!result) result = parse_kernel(gltf, members[4], &set->kernel);
    if (!result && set->version >= 2) result = parse_ranges(gltf, members + 5, set);
    if (!result) result = parse_version_3(gltf, members + 11, set);
    if (!result)
        result = psplat_json_integer(&gltf->json, members[17], names[17], clip_lines, &seams);
    set->clip_count = (uint32_t)clip_lines;
    set->seam_lines = (uint32_t)seams;
    *extent = members[3];
    return result;
}
