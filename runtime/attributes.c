/* SPDX-License-Identifier: MIT
 *
 * attributes.c - one primitive of splats: extension object (spec 3.1), attributes (3.2), and the
 * check of every value (3.3 to 3.8) and of the extent against rescaling tools (6.2).
 */
#include "gltf.h"

#include <float.h>
#include <math.h>

enum {
    POSITION,
    NORMAL,
    COLOR,
    ROTATION,
    SCALE,
    NORMAL_FIELD,
    FIRST_CLIP,
    ATTRIBUTES = FIRST_CLIP + PSPLAT_MAX_CLIP_LINES
};

#define BIT(type) (1u << ((type)-PSPLAT_BYTE))
#define FLOATS BIT(PSPLAT_FLOAT)
#define COLORS (FLOATS | BIT(PSPLAT_UNSIGNED_BYTE) | BIT(PSPLAT_UNSIGNED_SHORT))
#define ROTATIONS (FLOATS | BIT(PSPLAT_BYTE) | BIT(PSPLAT_SHORT))

static const psplat_attribute_type types[ATTRIBUTES] = {
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

/* The attributes of one primitive while its splats are decoded. */
typedef struct decoder {
    const psplat_gltf *gltf;
    psplat_reader readers[ATTRIBUTES];
    int is_present[ATTRIBUTES];
    size_t index; /* of the splat being decoded */
} decoder;

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
                                     psplat_json_value found[ATTRIBUTES]) {
    enum { OURS = ATTRIBUTES - ROTATION };
    const char *names[ATTRIBUTES + OURS];
    psplat_json_value members[ATTRIBUTES + OURS];
    for (size_t i = 0; i < ATTRIBUTES; ++i) names[i] = types[i].name;
    static const char *const underscored[OURS] = {
        "_" PSPLAT_EXTENSION ":ROTATION",     "_" PSPLAT_EXTENSION ":SCALE",
        "_" PSPLAT_EXTENSION ":NORMAL_FIELD", "_" PSPLAT_EXTENSION ":CLIP_0",
        "_" PSPLAT_EXTENSION ":CLIP_1",       "_" PSPLAT_EXTENSION ":CLIP_2",
        "_" PSPLAT_EXTENSION ":CLIP_3"};
    for (size_t i = 0; i < OURS; ++i) names[ATTRIBUTES + i] = underscored[i];
    psplat_result result =
        psplat_json_members(&gltf->json, object, names, ATTRIBUTES + OURS, members);
    if (result) return result;
    for (size_t i = 0; i < ATTRIBUTES; ++i) {
        psplat_json_value other = i >= ROTATION ? members[i + OURS] : 0;
        if (members[i] && other)
            return psplat_fail(gltf->error, PSPLAT_ERROR_FORMAT, psplat_gltf_offset(gltf, other),
                               "%s occurs with and without an underscore", types[i].name);
        found[i] = members[i] ? members[i] : other;
    }
    return PSPLAT_OK;
}

static int is_required(size_t attribute, uint32_t clip_count) {
    return attribute != COLOR && attribute != NORMAL_FIELD &&
           (attribute < FIRST_CLIP || attribute - FIRST_CLIP < clip_count);
}

static psplat_result open_readers(psplat_gltf *gltf, psplat_json_value object, uint32_t clip_count,
                                  decoder *d) {
    psplat_json_value found[ATTRIBUTES];
    psplat_result result = find_attributes(gltf, object, found);
    for (size_t i = 0; i < ATTRIBUTES && !result; ++i) {
        d->is_present[i] = found[i] != 0;
        if (is_required(i, clip_count)) result = require(gltf, object, found[i], types[i].name);
        if (!result && found[i] && i >= FIRST_CLIP && i - FIRST_CLIP >= clip_count)
            result = psplat_fail(
                gltf->error, PSPLAT_ERROR_RANGE, psplat_gltf_offset(gltf, found[i]),
                "%s is present although clipLines is %u", types[i].name, (unsigned)clip_count);
        if (!result && found[i])
            result = psplat_reader_open(gltf, found[i], &types[i],
                                        i == POSITION ? PSPLAT_NONE : d->readers[POSITION].count,
                                        &d->readers[i]);
    }
    return result;
}

/* ---- values ------------------------------------------------------------------------------- */

static psplat_result fail_value(const decoder *d, size_t attribute, const char *what) {
    const psplat_reader *reader = &d->readers[attribute];
    const psplat_buffer *buffer = reader->buffer;
    size_t at = psplat_buffer_offset(buffer, reader->start + d->index * reader->stride);
    return psplat_fail(d->gltf->error, PSPLAT_ERROR_RANGE, at, "splat %zu%s%.80s: %s %s", d->index,
                       buffer->path ? " in " : "", buffer->path ? buffer->path : "",
                       types[attribute].name, what);
}

static psplat_result get(const decoder *d, size_t attribute, float *values) {
    const psplat_reader *reader = &d->readers[attribute];
    psplat_reader_get(reader, d->index, values);
    for (size_t i = 0; i < reader->components; ++i)
        if (!isfinite(values[i])) return fail_value(d, attribute, "is not finite");
    return PSPLAT_OK;
}

/* Refuses lengths more than 1 % away from 1 (spec 3.3, 3.5) and normalises, but leaves values that
 * are unit up to float rounding as they are stored: a round trip changes no bit. */
static int normalise(float *values, size_t count) {
    double square = 0;
    for (size_t i = 0; i < count; ++i) square += (double)values[i] * (double)values[i];
    double length = sqrt(square);
    if (!(length >= 0.99 && length <= 1.01)) return 0;
    if (fabs(length - 1) > 2 * (double)FLT_EPSILON)
        for (size_t i = 0; i < count; ++i) values[i] = (float)((double)values[i] / length);
    return 1;
}

/* Columns U, V, N of the rotation by quaternion q. */
static void rotation_axes(const float q[4], double axes[3][3]) {
    double x = (double)q[0], y = (double)q[1], z = (double)q[2], w = (double)q[3];
    axes[0][0] = 1 - 2 * (y * y + z * z);
    axes[0][1] = 2 * (x * y + z * w);
    axes[0][2] = 2 * (x * z - y * w);
    axes[1][0] = 2 * (x * y - z * w);
    axes[1][1] = 1 - 2 * (x * x + z * z);
    axes[1][2] = 2 * (y * z + x * w);
    axes[2][0] = 2 * (x * z + y * w);
    axes[2][1] = 2 * (y * z - x * w);
    axes[2][2] = 1 - 2 * (x * x + y * y);
}

static psplat_result decode_frame(const decoder *d, psplat_splat *splat, double axes[3][3]) {
    psplat_result result = get(d, POSITION, splat->center);
    if (!result) result = get(d, ROTATION, splat->rotation);
    if (!result && !normalise(splat->rotation, 4))
        result = fail_value(d, ROTATION, "is not a unit quaternion");
    if (!result) result = get(d, SCALE, splat->radius);
    if (!result && !(splat->radius[0] >= splat->radius[1] && splat->radius[1] > 0))
        result = fail_value(d, SCALE, "is not two radii, the larger first, above 0");
    if (!result) rotation_axes(splat->rotation, axes);
    return result;
}

/* Spec 3.5, eq. (3a): what keeps n(u, v) within 90 degrees of N, and finite, all over the ellipse.
 */
static psplat_result decode_gradient(const decoder *d, psplat_splat *splat, double cosine) {
    psplat_result result = get(d, NORMAL_FIELD, splat->gradient);
    if (result) return result;
    double alpha = (double)splat->gradient[0], beta = (double)splat->gradient[1];
    double gamma = (double)splat->gradient[2];
    /* Far from the bound, where fields are, it takes no root: neither term exceeds 10. */
    if (cosine > 0.1 && alpha * alpha + beta * beta + 2 * gamma * gamma < 100) return PSPLAT_OK;
    double ratio = (double)splat->radius[1] / (double)splat->radius[0];
    double center = sqrt(fmax(1 / (cosine * cosine) - 1, 0));
    double change = sqrt(alpha * alpha + beta * beta + gamma * gamma * (1 + ratio * ratio));
    if (center + change <= 20) return PSPLAT_OK;
    return fail_value(d, NORMAL_FIELD, "bends the normal by more than spec 3.5 allows");
}

static psplat_result decode_normals(const decoder *d, psplat_splat *splat, double axes[3][3]) {
    psplat_result result = get(d, NORMAL, splat->normal);
    if (!result && !normalise(splat->normal, 3)) result = fail_value(d, NORMAL, "is not unit");
    if (result) return result;
    double cosine = 0;
    for (size_t i = 0; i < 3; ++i) cosine += (double)splat->normal[i] * axes[2][i];
    if (!(cosine >= 0.05))
        return fail_value(d, NORMAL, "leaves the plane's normal N by more than acos 0.05");
    return d->is_present[NORMAL_FIELD] ? decode_gradient(d, splat, cosine) : PSPLAT_OK;
}

static psplat_result decode_color(const decoder *d, psplat_splat *splat) {
    for (size_t i = 0; i < 4; ++i) splat->color[i] = 1;
    if (!d->is_present[COLOR]) return PSPLAT_OK;
    psplat_result result = get(d, COLOR, splat->color);
    for (size_t i = 0; i < 4 && !result; ++i)
        if (splat->color[i] < 0 || splat->color[i] > 1)
            result = fail_value(d, COLOR, "is not from 0 to 1");
    return result;
}

static psplat_result decode_clip_lines(const decoder *d, psplat_splat *splat) {
    psplat_result result = PSPLAT_OK;
    for (uint32_t i = 0; i < splat->clip_count && !result; ++i) {
        const float *line = splat->clip[i];
        result = get(d, FIRST_CLIP + i, splat->clip[i]);
        if (!result && line[0] == 0 && line[1] == 0)
            result = fail_value(d, FIRST_CLIP + i, "is no line: a and b are 0");
    }
    return result;
}

/* Enlarges the set's box by the unclipped ellipse, rounding outwards. */
static psplat_result enlarge_bounds(const decoder *d, psplat_set *set, const psplat_splat *splat,
                                    double axes[3][3]) {
    for (size_t i = 0; i < 3; ++i) {
        double center = (double)splat->center[i];
        double reach =
            hypot((double)splat->radius[0] * axes[0][i], (double)splat->radius[1] * axes[1][i]);
        if (center + reach > (double)FLT_MAX || center - reach < -(double)FLT_MAX)
            return fail_value(d, SCALE, "makes the splat reach beyond what a float can hold");
        float low = (float)(center - reach), high = (float)(center + reach);
        if ((double)low > center - reach) low = nextafterf(low, -FLT_MAX);
        if ((double)high < center + reach) high = nextafterf(high, FLT_MAX);
        if (d->index == 0 || low < set->bounds_min[i]) set->bounds_min[i] = low;
        if (d->index == 0 || high > set->bounds_max[i]) set->bounds_max[i] = high;
    }
    return PSPLAT_OK;
}

static psplat_result decode_splats(decoder *d, psplat_set *set) {
    psplat_result result = PSPLAT_OK;
    for (d->index = 0; d->index < set->count && !result; ++d->index) {
        psplat_splat *splat = &set->splats[d->index];
        double axes[3][3];
        splat->clip_count = set->clip_count;
        result = decode_frame(d, splat, axes);
        if (!result) result = decode_normals(d, splat, axes);
        if (!result) result = decode_color(d, splat);
        if (!result) result = decode_clip_lines(d, splat);
        if (!result) result = enlarge_bounds(d, set, splat, axes);
    }
    return result;
}

/* ---- the whole ---------------------------------------------------------------------------- */

/* Spec 6.2: another tool may have scaled POSITION, knowing nothing of SCALE. */
static psplat_result check_extent(const psplat_gltf *gltf, psplat_json_value value,
                                  const psplat_set *set) {
    double stated[3], found[3], largest = 0, difference = 0;
    psplat_result result = psplat_json_numbers(&gltf->json, value, "positionExtent", 3, stated);
    if (result) return result;
    for (size_t i = 0; i < 3; ++i) {
        float low = set->splats[0].center[i], high = low;
        for (size_t k = 1; k < set->count; ++k) {
            low = fminf(low, set->splats[k].center[i]);
            high = fmaxf(high, set->splats[k].center[i]);
        }
        found[i] = (double)high - (double)low;
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

static psplat_result describe(const decoder *d, psplat_set *set) {
    set->attributes = psplat_arena_take(d->gltf->kept, ATTRIBUTES, sizeof *set->attributes);
    if (!set->attributes)
        return psplat_fail(d->gltf->error, PSPLAT_ERROR_MEMORY, 0, "no memory for attributes");
    for (size_t i = 0; i < ATTRIBUTES; ++i) {
        const psplat_reader *reader = &d->readers[i];
        if (!d->is_present[i]) continue;
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
    psplat_json_value extent = 0;
    decoder d = {.gltf = gltf};
    psplat_result result = parse_extension(gltf, extension, set, &extent);
    if (!result) result = open_readers(gltf, attributes, set->clip_count, &d);
    if (result) return result;
    set->count = d.readers[POSITION].count;
    set->has_color = d.is_present[COLOR];
    set->has_gamma = d.readers[NORMAL_FIELD].components == 3;
    result = check_total(gltf, attributes, set->count);
    if (result) return result;
    set->splats = psplat_arena_take(gltf->kept, set->count, sizeof *set->splats);
    if (!set->splats)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, attributes),
                           "no memory for %zu splats", set->count);
    result = describe(&d, set);
    if (!result) result = decode_splats(&d, set);
    if (!result) result = check_extent(gltf, extent, set);
    return result;
}
