/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * glb.c - splats to a complete GLB (spec 3): one node, one mesh, one primitive per number of clip
 * lines, unclipped first (BSK04 section 4.1). Only what a model needs is written: no NORMAL_FIELD
 * where every gradient of a primitive is 0, no COLOR_0 where the colour is uniform, no glTF
 * default. Equal splats give equal bytes, whatever the locale and the machine's byte order.
 */
#include "converter.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CLASSES = PSPLAT_MAX_CLIP_LINES + 1, FLOAT = 5126, UNSIGNED_SHORT = 5123, COLUMNS = 10 };

/* One attribute: components floats of each splat, from byte offset on. Colours are written as
 * normalized unsigned shorts: half the bytes of floats at an error of 2^-17, less than a tenth of
 * the smallest step of the 8-bit sRGB colours that most meshes carry. Three shorts would save
 * nothing, glTF aligns elements to 4 bytes. */
typedef struct column {
    const char *name;
    size_t offset;
    size_t components;
    int type;
} column;

#define CLIP_COLUMN(k)                                                                             \
    {                                                                                              \
        "_PSPLAT_surface_splats:CLIP_" #k, offsetof(psplat_splat, clip) + (k)*3 * sizeof(float),   \
            3, FLOAT                                                                               \
    }

enum { POSITION_COLUMN = 0, COLOR_COLUMN = 2, FIELD_COLUMN = 5, FIRST_CLIP_COLUMN = 6 };

static const column columns[COLUMNS] = {
    {"POSITION", offsetof(psplat_splat, center), 3, FLOAT},
    {"NORMAL", offsetof(psplat_splat, normal), 3, FLOAT},
    {"COLOR_0", offsetof(psplat_splat, color), 4, UNSIGNED_SHORT},
    {"_PSPLAT_surface_splats:ROTATION", offsetof(psplat_splat, rotation), 4, FLOAT},
    {"_PSPLAT_surface_splats:SCALE", offsetof(psplat_splat, radius), 2, FLOAT},
    {"_PSPLAT_surface_splats:NORMAL_FIELD", offsetof(psplat_splat, gradient), 2, FLOAT},
    CLIP_COLUMN(0),
    CLIP_COLUMN(1),
    CLIP_COLUMN(2),
    CLIP_COLUMN(3),
};

/* A growing string; after a failed allocation further additions do nothing. */
typedef struct text {
    char *data;
    size_t size, capacity;
    int failed;
} text;

/* A run of splats with the same number of clip lines: one primitive. */
typedef struct run {
    const psplat_splat *splats;
    size_t count;
    size_t clip_lines;
    int has_column[COLUMNS];
    size_t column_count;
    float min[3], max[3];
} run;

static void text_add_bytes(text *t, const char *bytes, size_t size) {
    if (t->failed) return;
    if (t->capacity - t->size < size) {
        size_t capacity = 2 * t->capacity + size + 1024;
        char *data = realloc(t->data, capacity);
        if (!data) {
            t->failed = 1;
            return;
        }
        t->data = data;
        t->capacity = capacity;
    }
    memcpy(t->data + t->size, bytes, size);
    t->size += size;
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
text_add(text *t, const char *format, ...) {
    char piece[256];
    va_list arguments;
    va_start(arguments, format);
    int size = vsnprintf(piece, sizeof piece, format, arguments);
    va_end(arguments);
    if (size > 0) text_add_bytes(t, piece, (size_t)size);
}

/* The shortest decimal that reads back as the same number. printf writes the decimal separator of
 * the locale, which may be several bytes; whatever is neither digit, sign nor exponent becomes '.'.
 */
static void text_add_number(text *t, double value, int is_float) {
    char number[40];
    for (int precision = 1; precision <= 17; ++precision) {
        snprintf(number, sizeof number, "%.*g", precision, value);
        double back = is_float ? (double)strtof(number, NULL) : strtod(number, NULL);
        if (back == value) break;
    }
    char *end = number;
    int in_separator = 0;
    for (const char *c = number; *c; ++c) {
        int is_separator = !strchr("0123456789+-e", *c);
        if (!is_separator) *end++ = *c;
        if (is_separator && !in_separator) *end++ = '.';
        in_separator = is_separator;
    }
    text_add_bytes(t, number, (size_t)(end - number));
}

static void text_add_floats(text *t, const char *key, const float *values, size_t count) {
    text_add(t, "\"%s\":[", key);
    for (size_t i = 0; i < count; ++i) {
        if (i) text_add(t, ",");
        text_add_number(t, (double)values[i], 1);
    }
    text_add(t, "]");
}

/* Length of the well-formed UTF-8 sequence at s, or 0 (Unicode 15, table 3-7). */
static size_t utf8_length(const unsigned char *s) {
    size_t length = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : 4;
    if (length == 0 || s[0] > 0xf4) return 0;
    for (size_t i = 1; i < length; ++i)
        if ((s[i] & 0xc0) != 0x80) return 0;
    if ((s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f)) return 0;
    if ((s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f)) return 0;
    return length;
}

/* Names come from file names, which may hold any bytes: what is not UTF-8 becomes U+FFFD. */
static void text_add_string(text *t, const char *string) {
    const unsigned char *s = (const unsigned char *)string;
    text_add(t, "\"");
    while (*s) {
        size_t length = utf8_length(s);
        if (length == 0)
            text_add(t, "\xef\xbf\xbd");
        else if (*s < 0x20 || *s == '"' || *s == '\\')
            text_add(t, "\\u%04x", *s);
        else
            text_add_bytes(t, (const char *)s, length);
        s += length ? length : 1;
    }
    text_add(t, "\"");
}

/* ---- runs --------------------------------------------------------------------------------- */

static int run_uses(const run *r, size_t index, const psplat_splats *splats) {
    if (index == COLOR_COLUMN) return splats->has_color;
    if (index >= FIRST_CLIP_COLUMN) return index - FIRST_CLIP_COLUMN < r->clip_lines;
    if (index != FIELD_COLUMN) return 1;
    for (size_t i = 0; i < r->count; ++i)
        if (r->splats[i].gradient[0] != 0.0f || r->splats[i].gradient[1] != 0.0f) return 1;
    return 0;
}

static void run_measure(run *r, const psplat_splats *splats) {
    for (size_t i = 0; i < COLUMNS; ++i) {
        r->has_column[i] = run_uses(r, i, splats);
        r->column_count += (size_t)r->has_column[i];
    }
    for (size_t axis = 0; axis < 3; ++axis) {
        r->min[axis] = r->max[axis] = r->splats[0].center[axis];
        for (size_t i = 1; i < r->count; ++i) {
            float value = r->splats[i].center[axis];
            if (value < r->min[axis]) r->min[axis] = value;
            if (value > r->max[axis]) r->max[axis] = value;
        }
    }
}

static size_t element_size(const column *c) {
    return c->components * (c->type == FLOAT ? 4 : 2);
}

static size_t run_bytes(const run *r) {
    size_t bytes = 0;
    for (size_t i = 0; i < COLUMNS; ++i)
        if (r->has_column[i]) bytes += r->count * element_size(&columns[i]);
    return bytes;
}

/* JSON has no word for infinity or not-a-number, and a reader would refuse them anyway. */
static int all_finite(const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(values[i])) return 0;
    return 1;
}

static psplat_result check_splats(const psplat_splats *splats, psplat_error *error) {
    if (!splats->count) return psplat_fail(error, PSPLAT_ERROR_NO_SPLATS, 0, "no splats to write");
    size_t index = 0;
    for (size_t clip_lines = 0; clip_lines < CLASSES; ++clip_lines)
        for (size_t i = 0; i < splats->count_by_clip_lines[clip_lines]; ++i, ++index)
            if (index >= splats->count || splats->splats[index].clip_count != clip_lines)
                return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                                   "splat %zu is not in the class of %zu clip lines that "
                                   "count_by_clip_lines puts it in",
                                   index, clip_lines);
    if (index != splats->count)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0,
                           "count_by_clip_lines adds up to %zu of %zu splats", index,
                           splats->count);
    for (size_t i = 0; i < splats->count; ++i)
        for (size_t c = 0; c < COLUMNS; ++c) {
            const char *splat = (const char *)&splats->splats[i];
            float values[4];
            memcpy(values, splat + columns[c].offset, columns[c].components * sizeof(float));
            if (!all_finite(values, columns[c].components))
                return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "splat %zu: %s is not finite", i,
                                   columns[c].name);
        }
    return PSPLAT_OK;
}

/* ---- JSON --------------------------------------------------------------------------------- */

static void add_attributes(text *t, const run *r, size_t accessor) {
    const char *separator = "";
    text_add(t, "\"attributes\":{");
    for (size_t i = 0; i < COLUMNS; ++i) {
        if (!r->has_column[i]) continue;
        text_add(t, "%s\"%s\":%zu", separator, columns[i].name, accessor++);
        separator = ",";
    }
    text_add(t, "}");
}

static void add_kernel(text *t, const psplat_kernel *kernel) {
    if (kernel->sharpness == PSPLAT_DEFAULT_KERNEL_SHARPNESS &&
        kernel->exponent == PSPLAT_DEFAULT_KERNEL_EXPONENT)
        return;
    text_add(t, ",\"kernel\":{\"sharpness\":");
    text_add_number(t, (double)kernel->sharpness, 1);
    text_add(t, ",\"exponent\":");
    text_add_number(t, (double)kernel->exponent, 1);
    text_add(t, "}");
}

static void add_primitive(text *t, const run *r, size_t accessor, const psplat_splats *splats,
                          int has_material) {
    float extent[3];
    for (size_t i = 0; i < 3; ++i) extent[i] = (float)((double)r->max[i] - (double)r->min[i]);
    text_add(t, "{\"mode\":0,");
    add_attributes(t, r, accessor);
    if (has_material) text_add(t, ",\"material\":0");
    text_add(t, ",\"extensions\":{\"PSPLAT_surface_splats\":{\"version\":1,\"clipLines\":%zu,",
             r->clip_lines);
    text_add(t, "\"depthTolerance\":");
    text_add_number(t, (double)splats->depth_tolerance, 1);
    text_add(t, ",");
    text_add_floats(t, "positionExtent", extent, 3);
    add_kernel(t, &splats->kernel);
    text_add(t, "}}}");
}

static void add_node(text *t, const psplat_splats *splats, const char *name) {
    const double *origin = splats->origin;
    text_add(t, "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0");
    if (name && *name) {
        text_add(t, ",\"name\":");
        text_add_string(t, name);
    }
    if (origin[0] != 0.0 || origin[1] != 0.0 || origin[2] != 0.0) {
        text_add(t, ",\"translation\":[");
        for (size_t i = 0; i < 3; ++i) {
            if (i) text_add(t, ",");
            text_add_number(t, origin[i], 0);
        }
        text_add(t, "]");
    }
    text_add(t, "}],");
}

static int is_emissive(const psplat_material *m) {
    /* Unlit materials show their base colour alone (spec 5.6). */
    return !m->unlit &&
           (m->emissive[0] != 0.0f || m->emissive[1] != 0.0f || m->emissive[2] != 0.0f);
}

/* glTF's factor ends at 1; KHR_materials_emissive_strength carries the rest. */
static float emissive_strength(const psplat_material *m) {
    if (!is_emissive(m)) return 1.0f;
    return fmaxf(1.0f, fmaxf(fmaxf(m->emissive[0], m->emissive[1]), m->emissive[2]));
}

static int is_default_material(const psplat_material *m) {
    for (size_t i = 0; i < 4; ++i)
        if (m->base_color[i] != 1.0f) return 0;
    return m->metallic == 1.0f && m->roughness == 1.0f && !is_emissive(m) && !m->double_sided &&
           !m->unlit;
}

static void add_metallic_roughness(text *t, const psplat_material *m) {
    const float *base = m->base_color;
    const char *separator = "";
    text_add(t, "\"pbrMetallicRoughness\":{");
    if (base[0] != 1.0f || base[1] != 1.0f || base[2] != 1.0f || base[3] != 1.0f) {
        text_add_floats(t, "baseColorFactor", base, 4);
        separator = ",";
    }
    if (m->metallic != 1.0f) {
        text_add(t, "%s\"metallicFactor\":", separator);
        text_add_number(t, (double)m->metallic, 1);
        separator = ",";
    }
    if (m->roughness != 1.0f) {
        text_add(t, "%s\"roughnessFactor\":", separator);
        text_add_number(t, (double)m->roughness, 1);
    }
    text_add(t, "}");
}

static void add_material(text *t, const psplat_material *m) {
    float strength = emissive_strength(m);
    text_add(t, "\"materials\":[{");
    add_metallic_roughness(t, m);
    if (is_emissive(m)) {
        float factor[3];
        for (size_t i = 0; i < 3; ++i) factor[i] = m->emissive[i] / strength;
        text_add(t, ",");
        text_add_floats(t, "emissiveFactor", factor, 3);
    }
    if (m->double_sided) text_add(t, ",\"doubleSided\":true");
    if (m->unlit) text_add(t, ",\"extensions\":{\"KHR_materials_unlit\":{}}");
    if (strength > 1.0f) {
        text_add(t, ",\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":");
        text_add_number(t, (double)strength, 1);
        text_add(t, "}}");
    }
    text_add(t, "}],");
}

static void add_accessors(text *t, const run *runs, size_t run_count) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    size_t view = 0;
    text_add(t, "\"accessors\":[");
    for (size_t i = 0; i < run_count; ++i)
        for (size_t c = 0; c < COLUMNS; ++c) {
            if (!runs[i].has_column[c]) continue;
            text_add(t,
                     "%s{\"bufferView\":%zu,\"componentType\":%d,%s\"count\":%zu,\"type\":\"%s\"",
                     view ? "," : "", view, columns[c].type,
                     columns[c].type == FLOAT ? "" : "\"normalized\":true,", runs[i].count,
                     types[columns[c].components]);
            if (c == POSITION_COLUMN) {
                text_add(t, ",");
                text_add_floats(t, "min", runs[i].min, 3);
                text_add(t, ",");
                text_add_floats(t, "max", runs[i].max, 3);
            }
            text_add(t, "}");
            ++view;
        }
    text_add(t, "],");
}

static void add_views(text *t, const run *runs, size_t run_count) {
    size_t offset = 0;
    text_add(t, "\"bufferViews\":[");
    for (size_t i = 0; i < run_count; ++i)
        for (size_t c = 0; c < COLUMNS; ++c) {
            if (!runs[i].has_column[c]) continue;
            size_t bytes = runs[i].count * element_size(&columns[c]);
            text_add(t, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34962}",
                     offset ? "," : "", offset, bytes);
            offset += bytes;
        }
    text_add(t, "],\"buffers\":[{\"byteLength\":%zu}]}", offset);
}

static void add_document(text *t, const psplat_splats *splats, const char *name, const run *runs,
                         size_t run_count) {
    int has_material = !is_default_material(&splats->material);
    text_add(t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"phongsplat 0.1.0\"},");
    text_add(t, "\"extensionsUsed\":[\"PSPLAT_surface_splats\"%s%s],",
             splats->material.unlit ? ",\"KHR_materials_unlit\"" : "",
             emissive_strength(&splats->material) > 1.0f ? ",\"KHR_materials_emissive_strength\""
                                                         : "");
    add_node(t, splats, name);
    text_add(t, "\"meshes\":[{");
    if (name && *name) {
        text_add(t, "\"name\":");
        text_add_string(t, name);
        text_add(t, ",");
    }
    text_add(t, "\"primitives\":[");
    size_t accessor = 0;
    for (size_t i = 0; i < run_count; ++i) {
        if (i) text_add(t, ",");
        add_primitive(t, &runs[i], accessor, splats, has_material);
        accessor += runs[i].column_count;
    }
    text_add(t, "]}],");
    if (has_material) add_material(t, &splats->material);
    add_accessors(t, runs, run_count);
    add_views(t, runs, run_count);
    while (t->size % 4) text_add(t, " ");
}

/* ---- bytes -------------------------------------------------------------------------------- */

static uint8_t *put_u32(uint8_t *out, uint32_t value) {
    for (int i = 0; i < 4; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

static uint8_t *put_value(uint8_t *out, float value, int type) {
    if (type == FLOAT) {
        uint32_t bits;
        memcpy(&bits, &value, sizeof bits);
        return put_u32(out, bits);
    }
    unsigned quantised = (unsigned)lrintf(fminf(fmaxf(value, 0.0f), 1.0f) * 65535.0f);
    *out++ = (uint8_t)quantised;
    *out++ = (uint8_t)(quantised >> 8);
    return out;
}

static uint8_t *put_run(uint8_t *out, const run *r) {
    for (size_t c = 0; c < COLUMNS; ++c) {
        if (!r->has_column[c]) continue;
        for (size_t i = 0; i < r->count; ++i) {
            float values[4];
            memcpy(values, (const char *)&r->splats[i] + columns[c].offset,
                   columns[c].components * sizeof(float));
            for (size_t k = 0; k < columns[c].components; ++k)
                out = put_value(out, values[k], columns[c].type);
        }
    }
    return out;
}

/* glTF 2.0 section 4.4: header, JSON chunk, BIN chunk. */
static psplat_result pack(const text *json, const run *runs, size_t run_count, uint8_t **data,
                          size_t *size, psplat_error *error) {
    enum { HEADERS = 12 + 8 + 8, MAGIC = 0x46546c67, JSON = 0x4e4f534a, BIN = 0x004e4942 };
    size_t bytes = 0;
    for (size_t i = 0; i < run_count; ++i) bytes += run_bytes(&runs[i]);
    size_t total = HEADERS + json->size + bytes;
    if (total > UINT32_MAX)
        return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                           "%zu bytes are more than the 4 GiB that a GLB can hold", total);
    uint8_t *out = malloc(total);
    if (!out) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for %zu bytes", total);
    *data = out;
    *size = total;
    out = put_u32(put_u32(put_u32(out, MAGIC), 2), (uint32_t)total);
    out = put_u32(put_u32(out, (uint32_t)json->size), JSON);
    memcpy(out, json->data, json->size);
    out = put_u32(put_u32(out + json->size, (uint32_t)bytes), BIN);
    for (size_t i = 0; i < run_count; ++i) out = put_run(out, &runs[i]);
    return PSPLAT_OK;
}

psplat_result psplat_glb_write(const psplat_splats *splats, const char *name, uint8_t **data,
                               size_t *size, psplat_error *error) {
    if (!splats || !data || !size)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "splats, data and size are required");
    *data = NULL;
    *size = 0;
    psplat_result result = check_splats(splats, error);
    if (result) return result;

    run runs[CLASSES] = {0};
    size_t run_count = 0;
    const psplat_splat *next = splats->splats;
    for (size_t clip_lines = 0; clip_lines < CLASSES; ++clip_lines) {
        size_t count = splats->count_by_clip_lines[clip_lines];
        if (!count) continue;
        run *r = &runs[run_count++];
        *r = (run){.splats = next, .count = count, .clip_lines = clip_lines};
        run_measure(r, splats);
        next += count;
    }
    text json = {0};
    add_document(&json, splats, name, runs, run_count);
    result = json.failed ? psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for the JSON")
                         : pack(&json, runs, run_count, data, size, error);
    free(json.data);
    return result;
}
