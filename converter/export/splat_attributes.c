/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_attributes.c - the attribute table: the vertex attributes of a mesh's splats as bytes.
 *
 * An attribute that has its default value in every splat is not written: there is no NORMAL_FIELD
 * where all gradients are 0, and no third component of it where all of those are 0, unless it is
 * that of curved surfaces. Integers are
 * stored in the smallest type that holds them, in little-endian order, so that equal splats give
 * equal bytes on every machine.
 */
#include "export/splat_attributes.h"

#include "export/khr_gaussians.h"
#include "splats/octahedron.h"
#include "splats/quantize.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define OURS "_PSPLAT_surface_splats:"
#define GAUSSIAN "KHR_gaussian_splatting:"

const char *const psplat_attribute_names[PSPLAT_ATTRIBUTE_KINDS] = {"POSITION",
                                                                    "NORMAL",
                                                                    "COLOR_0",
                                                                    OURS "ROTATION",
                                                                    OURS "TURN",
                                                                    OURS "TILT",
                                                                    OURS "TILT",
                                                                    OURS "SCALE",
                                                                    OURS "NORMAL_FIELD",
                                                                    OURS "NORMAL_FIELD",
                                                                    OURS "SHAPE",
                                                                    OURS "CLIP_0",
                                                                    OURS "CLIP_1",
                                                                    OURS "CLIP_2",
                                                                    OURS "CLIP_3",
                                                                    OURS "COLOR_U",
                                                                    OURS "COLOR_V",
                                                                    OURS
                                                                    "OCCLUSION_ROUGHNESS_METALLIC",
                                                                    OURS "EMISSIVE",
                                                                    "TEXCOORD_0",
                                                                    OURS "TEXCOORD_U",
                                                                    OURS "TEXCOORD_V",
                                                                    OURS "TEXCOORD_UU",
                                                                    OURS "TEXCOORD_UV",
                                                                    OURS "TEXCOORD_VV",
                                                                    GAUSSIAN "ROTATION",
                                                                    GAUSSIAN "SCALE",
                                                                    GAUSSIAN "OPACITY",
                                                                    GAUSSIAN "SH_DEGREE_0_COEF_0"};

/* Returns the largest integer of a type; 1 for floats and for attributes that are not stored. */
static int32_t most_of(int type) {
    static const int32_t most[] = {127, 255, 32767, 65535};
    return !type || type == PSPLAT_TYPE_FLOAT ? 1 : most[type - PSPLAT_TYPE_BYTE];
}

static size_t component_bytes(int type) {
    return type == PSPLAT_TYPE_FLOAT ? 4 : type >= PSPLAT_TYPE_SHORT ? 2 : 1;
}

size_t psplat_attribute_bytes(const psplat_attribute_format *format) {
    return (format->components * component_bytes(format->type) + 3) / 4 * 4;
}

int psplat_attribute_is_normalized(const psplat_attribute_format *format, size_t kind) {
    return format->type != PSPLAT_TYPE_FLOAT && kind != PSPLAT_ATTRIBUTE_POSITION &&
           kind != PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE;
}

/* ---- values -------------------------------------------------------------------------------- */

static int is_gaussian(size_t kind) {
    return kind >= PSPLAT_ATTRIBUTE_GAUSSIAN_ROTATION;
}

static const float *gaussian_values(const psplat_gaussian *gaussian, size_t kind) {
    static const float opaque = 1;
    return kind == PSPLAT_ATTRIBUTE_GAUSSIAN_ROTATION ? gaussian->rotation
           : kind == PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE  ? gaussian->scale
           : kind == PSPLAT_ATTRIBUTE_OPACITY         ? &opaque
                                                      : gaussian->harmonic;
}

static int is_texcoord(size_t kind) {
    return kind >= PSPLAT_ATTRIBUTE_TEXCOORD && kind <= PSPLAT_ATTRIBUTE_TEXCOORD_VV;
}

static const float *texcoord_values(const psplat_texcoord *t, size_t kind) {
    const float *const values[] = {t->at,       t->along_u,  t->along_v,
                                   t->along_uu, t->along_uv, t->along_vv};
    return values[kind - PSPLAT_ATTRIBUTE_TEXCOORD];
}

static const int32_t *texcoord_codes(const psplat_quantized_texcoord *t, size_t kind) {
    const int32_t *const codes[] = {t->at,       t->along[0], t->along[1],
                                    t->bends[0], t->bends[1], t->bends[2]};
    return codes[kind - PSPLAT_ATTRIBUTE_TEXCOORD];
}

/* Stores a clip line of a splat and its bend, where the splat has that line; else one that cuts
 * nothing off (spec 3.6). */
static void line_values(const psplat_splat *splat, size_t line, float values[4]) {
    static const float padding[4] = {1, 0, 1, 0};
    memcpy(values, padding, sizeof padding);
    if (line >= splat->clip_count) return;
    memcpy(values, splat->clip[line], sizeof splat->clip[line]);
    values[3] = splat->bend[line];
}

/* Stores the attribute of a splat as floats: its value, or, where integers will be rounded from it,
 * the fraction of its range. */
static void values_of(const psplat_attribute_table *table, size_t kind, size_t index,
                      float values[4]) {
    static const psplat_finish plain = {
        .occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    const psplat_splat *s = &table->splats->splats[index];
    const psplat_finish *f = table->splats->finishes ? &table->splats->finishes[index] : &plain;
    const float orm[3] = {f->occlusion, f->roughness, f->metallic};
    float sign = table->codes && table->codes[index].flipped ? -1.0f : 1.0f;
    const float *from = is_gaussian(kind) ? gaussian_values(&table->gaussians[index], kind)
                        : is_texcoord(kind)
                            ? texcoord_values(&table->splats->texcoords[index], kind)
                        : kind == PSPLAT_ATTRIBUTE_POSITION      ? s->center
                        : kind == PSPLAT_ATTRIBUTE_NORMAL        ? s->normal
                        : kind == PSPLAT_ATTRIBUTE_COLOR         ? s->color
                        : kind == PSPLAT_ATTRIBUTE_ROTATION      ? s->rotation
                        : kind == PSPLAT_ATTRIBUTE_SCALE         ? s->radius
                        : kind == PSPLAT_ATTRIBUTE_FIELD         ? s->gradient
                        : kind == PSPLAT_ATTRIBUTE_SURFACE_FIELD ? s->gradient
                        : kind == PSPLAT_ATTRIBUTE_SHAPE         ? s->shape + 2
                        : kind == PSPLAT_ATTRIBUTE_COLOR_U       ? f->color_u
                        : kind == PSPLAT_ATTRIBUTE_COLOR_V       ? f->color_v
                        : kind == PSPLAT_ATTRIBUTE_ORM           ? orm
                                                                 : f->emissive;
    if (psplat_attribute_is_clip_line(kind)) {
        line_values(s, kind - PSPLAT_ATTRIBUTE_LINE, values);
        return;
    }
    memcpy(values, from, table->formats[kind].components * sizeof *values);
    if (kind == PSPLAT_ATTRIBUTE_TEXCOORD && psplat_attribute_table_has_texcoord_grid(table))
        for (size_t k = 0; k < 2; ++k)
            values[k] = (float)(table->codes[index].texcoord.at[k] *
                                table->splats->precision.texcoord_step);
    if (kind == PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE && table->codes)
        for (size_t k = 0; k < 3; ++k)
            values[k] = (float)((double)values[k] / table->splats->precision.unit);
    if (kind != PSPLAT_ATTRIBUTE_COLOR_U && kind != PSPLAT_ATTRIBUTE_COLOR_V) return;
    for (size_t k = 0; k < 3; ++k) values[k] *= sign;
    if (table->formats[kind].type != PSPLAT_TYPE_FLOAT)
        for (size_t k = 0; k < 3; ++k) values[k] /= table->color_range;
}

/* Stores the integers of an attribute that psplat_quantize_splat has quantized. Returns 0 for those
 * that are rounded from the floats of values_of instead. */
static int codes_of(const psplat_attribute_table *table, size_t kind, size_t index,
                    int32_t values[4]) {
    const psplat_precision *p = &table->splats->precision;
    const psplat_quantized_splat *c = &table->codes[index];
    if (kind == PSPLAT_ATTRIBUTE_POSITION)
        for (int k = 0; k < 3; ++k) values[k] = c->position[k] - table->low[k];
    else if (kind == PSPLAT_ATTRIBUTE_NORMAL)
        psplat_octahedron_decode(c->normal, p->normal_bits, values);
    else if (kind == PSPLAT_ATTRIBUTE_TURN)
        values[0] = c->turn;
    else if (kind == PSPLAT_ATTRIBUTE_TILT)
        memcpy(values, c->tilt, sizeof c->tilt);
    else if (kind == PSPLAT_ATTRIBUTE_SURFACE_TILT)
        memcpy(values, c->shape_tilt, sizeof c->shape_tilt);
    else if (kind == PSPLAT_ATTRIBUTE_SCALE)
        for (int k = 0; k < 2; ++k)
            values[k] = (c->scale[k] - table->least_scale) * table->scale_factor;
    else if (kind == PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE &&
             table->formats[kind].type != PSPLAT_TYPE_FLOAT)
        for (int k = 0; k < 3; ++k)
            values[k] = (int32_t)fmax(1, rint((double)table->gaussians[index].scale[k] / p->unit));
    else if (kind == PSPLAT_ATTRIBUTE_FIELD)
        memcpy(values, c->field, sizeof c->field);
    else if (kind == PSPLAT_ATTRIBUTE_SURFACE_FIELD || kind == PSPLAT_ATTRIBUTE_SHAPE)
        memcpy(values, c->shape, sizeof c->shape);
    else if (is_texcoord(kind) && kind != PSPLAT_ATTRIBUTE_TEXCOORD)
        memcpy(values, texcoord_codes(&c->texcoord, kind), 2 * sizeof *values);
    else if (psplat_attribute_is_clip_line(kind) &&
             kind - PSPLAT_ATTRIBUTE_LINE >= table->splats->splats[index].clip_count)
        values[0] = values[2] = 0, values[1] = (int32_t)lrint(1 / p->line_step);
    else if (psplat_attribute_is_clip_line(kind))
        memcpy(values, c->lines[kind - PSPLAT_ATTRIBUTE_LINE], sizeof c->lines[0]);
    else
        return 0;
    return 1;
}

/* ---- bytes --------------------------------------------------------------------------------- */

void psplat_attribute_table_put(const psplat_attribute_table *table, size_t kind,
                                const psplat_attribute_format *format, size_t index, uint8_t *out) {
    size_t bytes = component_bytes(format->type);
    uint8_t *end = out + psplat_attribute_bytes(format);
    int32_t integers[4];
    float values[4];
    int is_coded = table->codes && codes_of(table, kind, index, integers);
    if (!is_coded) values_of(table, kind, index, values);
    for (size_t k = 0; k < format->components; ++k) {
        uint32_t bits;
        if (format->type == PSPLAT_TYPE_FLOAT)
            memcpy(&bits, &values[k], sizeof bits);
        else if (is_coded)
            bits = (uint32_t)integers[k];
        else
            bits = (uint32_t)(int32_t)lrintf(fminf(fmaxf(values[k], -1.0f), 1.0f) *
                                             (float)most_of(format->type));
        out = psplat_put_integer(out, bits, bytes);
    }
    while (out < end) *out++ = 0;
}

void psplat_attribute_table_put_octahedral(const psplat_attribute_table *table, size_t index,
                                           uint8_t *out) {
    const int32_t *code = table->codes[index].normal;
    int bits = table->splats->precision.normal_bits;
    size_t bytes = component_bytes(table->formats[PSPLAT_ATTRIBUTE_NORMAL].type);
    out = psplat_put_integer(out, (uint32_t)code[0], bytes);
    out = psplat_put_integer(out, (uint32_t)code[1], bytes);
    psplat_put_integer(psplat_put_integer(out, (1u << (bits - 1)) - 1, bytes), 0, bytes);
}

void psplat_attribute_table_put_exponential(const psplat_attribute_table *table, size_t index,
                                            uint8_t *out) {
    int exponent = (int)lrint(log2(table->splats->precision.texcoord_step));
    for (int k = 0; k < 2; ++k) {
        out = psplat_put_integer(out, (uint32_t)table->codes[index].texcoord.at[k], 3);
        *out++ = (uint8_t)exponent;
    }
}

/* ---- formats that splats need --------------------------------------------------------------- */

/* Returns whether a component of the attribute, from number `from` on, is not the default. */
static int differs_from_default(const psplat_attribute_table *table, size_t kind, size_t index,
                                size_t from) {
    int32_t integers[4] = {0};
    float values[4] = {0}, rest = kind == PSPLAT_ATTRIBUTE_ORM || kind == PSPLAT_ATTRIBUTE_EMISSIVE;
    size_t components = table->formats[kind].components;
    if (table->codes && codes_of(table, kind, index, integers)) {
        for (size_t k = from; k < components; ++k)
            if (integers[k]) return 1;
        return 0;
    }
    values_of(table, kind, index, values);
    for (size_t k = from; k < components; ++k)
        if (values[k] != rest) return 1;
    return 0;
}

static size_t components_of(const psplat_attribute_table *table, size_t kind, size_t first,
                            size_t count) {
    size_t most = 0, all = table->formats[kind].components;
    for (size_t i = first; i < first + count && most < all; ++i) {
        if (kind == PSPLAT_ATTRIBUTE_FIELD && all == 3 &&
            !differs_from_default(table, kind, i, 2)) {
            if (most < 2 && differs_from_default(table, kind, i, 0)) most = 2;
        } else if (differs_from_default(table, kind, i, 0))
            most = all;
    }
    return most;
}

/* Returns the components that lines need: one less than in the table where none of them bends. */
static size_t line_components(const psplat_attribute_table *table, size_t kind, size_t first,
                              size_t count) {
    size_t all = table->formats[kind].components, straight = table->codes ? 2 : 3;
    for (size_t i = first; i < first + count && all > straight; ++i)
        if (differs_from_default(table, kind, i, straight)) return all;
    return straight;
}

/* Returns whether the attribute is one of those that primitives of a run's kind of surface have. */
static int belongs_to(const psplat_run *like, size_t kind) {
    int is_surface = like->is_curved && !like->has_shape;
    if (kind == PSPLAT_ATTRIBUTE_SHAPE) return like->has_shape;
    if (is_texcoord(kind))
        return kind < PSPLAT_ATTRIBUTE_TEXCOORD_UU ? like->has_texcoord : like->has_texcoord_bend;
    if (kind == PSPLAT_ATTRIBUTE_TILT || kind == PSPLAT_ATTRIBUTE_FIELD) return !is_surface;
    if (kind == PSPLAT_ATTRIBUTE_SURFACE_TILT || kind == PSPLAT_ATTRIBUTE_SURFACE_FIELD)
        return is_surface;
    return !psplat_attribute_is_clip_line(kind) || kind - PSPLAT_ATTRIBUTE_LINE < like->clip_lines;
}

/* Returns whether the attribute may be left out where it has its default value. */
static int is_optional(size_t kind) {
    return kind == PSPLAT_ATTRIBUTE_TILT || kind == PSPLAT_ATTRIBUTE_SURFACE_TILT ||
           kind == PSPLAT_ATTRIBUTE_FIELD ||
           (kind >= PSPLAT_ATTRIBUTE_COLOR_U && !is_gaussian(kind) && !is_texcoord(kind));
}

void psplat_attribute_table_formats(const psplat_attribute_table *table, size_t first, size_t count,
                                    const psplat_run *like,
                                    psplat_attribute_format formats[PSPLAT_ATTRIBUTE_KINDS]) {
    memcpy(formats, table->formats, sizeof table->formats);
    for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind) {
        psplat_attribute_format *format = &formats[kind];
        if (!belongs_to(like, kind))
            format->components = 0;
        else if (psplat_attribute_is_clip_line(kind))
            format->components = line_components(table, kind, first, count);
        else if (is_optional(kind))
            format->components = components_of(table, kind, first, count);
    }
    if (formats[PSPLAT_ATTRIBUTE_COLOR_U].components ||
        formats[PSPLAT_ATTRIBUTE_COLOR_V].components)
        formats[PSPLAT_ATTRIBUTE_COLOR_U].components =
            formats[PSPLAT_ATTRIBUTE_COLOR_V].components = 3;
}

void psplat_attribute_table_extent(const psplat_attribute_table *table, size_t first, size_t count,
                                   float low[3], float high[3]) {
    for (size_t i = first; i < first + count; ++i)
        for (int k = 0; k < 3; ++k) {
            float x = table->codes ? (float)(table->codes[i].position[k] - table->low[k])
                                   : table->splats->splats[i].center[k];
            if (i == first || x < low[k]) low[k] = x;
            if (i == first || x > high[k]) high[k] = x;
        }
}

/* ---- types ---------------------------------------------------------------------------------- */

/* Returns the greatest magnitude of the quantized integers of an attribute. */
static int32_t greatest(const psplat_attribute_table *table, size_t kind) {
    int32_t most = 0;
    for (size_t i = 0; i < table->splats->count; ++i) {
        int32_t values[4] = {0};
        if (!codes_of(table, kind, i, values)) continue; /* a float */
        for (size_t k = 0; k < table->formats[kind].components; ++k)
            if (abs(values[k]) > most) most = abs(values[k]);
    }
    return most;
}

/* Returns the smallest type whose largest integer is at least `most`. */
static int type_for(int32_t most, int is_signed) {
    if (is_signed) return most <= 127 ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_SHORT;
    return most <= 255 ? PSPLAT_TYPE_UNSIGNED_BYTE : PSPLAT_TYPE_UNSIGNED_SHORT;
}

/* Returns whether 8 bits suffice for a linear colour: the error of rounding, seen through a gamma
 * of 2.4 as the eye sees it, must not exceed 1 % of white. It does for dark colours. */
static int fits_bytes(const float color[3]) {
    for (size_t k = 0; k < 3; ++k) {
        double c = (double)color[k], rounded = rint(c * 255) / 255;
        if (fabs(pow(c, 1 / 2.4) - pow(rounded, 1 / 2.4)) > 0.01) return 0;
    }
    return 1;
}

/* Returns the smallest type for all of the colours, which lie stride bytes apart. */
static int type_of_colors(const float *colors, size_t count, size_t stride) {
    for (size_t i = 0; i < count; ++i)
        if (!fits_bytes((const float *)((const char *)colors + i * stride)))
            return PSPLAT_TYPE_UNSIGNED_SHORT;
    return PSPLAT_TYPE_UNSIGNED_BYTE;
}

static int is_opaque(const psplat_splats *splats) {
    for (size_t i = 0; i < splats->count; ++i)
        if (splats->splats[i].color[3] != 1.0f) return 0;
    return 1;
}

static float color_range_of(const psplat_splats *splats) {
    float range = 0;
    for (size_t i = 0; i < splats->count; ++i)
        for (size_t k = 0; k < 3; ++k)
            range = fmaxf(range, fmaxf(fabsf(splats->finishes[i].color_u[k]),
                                       fabsf(splats->finishes[i].color_v[k])));
    return range;
}

static void set_finishes(psplat_attribute_table *table) {
    const psplat_splats *splats = table->splats;
    psplat_attribute_format *formats = table->formats;
    table->color_range = color_range_of(splats);
    /* The specification allows no range of 0 (spec 3.1), and there is nothing to store then. */
    if (table->color_range > 0)
        formats[PSPLAT_ATTRIBUTE_COLOR_U] = formats[PSPLAT_ATTRIBUTE_COLOR_V] =
            (psplat_attribute_format){table->codes ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_FLOAT, 3};
    formats[PSPLAT_ATTRIBUTE_ORM] = formats[PSPLAT_ATTRIBUTE_EMISSIVE] =
        (psplat_attribute_format){table->codes ? PSPLAT_TYPE_UNSIGNED_BYTE : PSPLAT_TYPE_FLOAT, 3};
    if (table->codes)
        formats[PSPLAT_ATTRIBUTE_EMISSIVE].type =
            type_of_colors(splats->finishes->emissive, splats->count, sizeof *splats->finishes);
}

static void set_material_formats(psplat_attribute_table *table) {
    const psplat_splats *splats = table->splats;
    /* Three shorts would save nothing over four, since glTF aligns elements to 4 bytes. */
    if (splats->has_color)
        table->formats[PSPLAT_ATTRIBUTE_COLOR] = (psplat_attribute_format){
            table->codes
                ? type_of_colors(splats->splats->color, splats->count, sizeof *splats->splats)
                : PSPLAT_TYPE_UNSIGNED_SHORT,
            table->codes && is_opaque(splats) ? 3 : 4};
    if (splats->finishes) set_finishes(table);
}

/* Sets the formats of texture coordinates. Those at centres are floats; the others of one order
 * have one type and one range. */
static void set_texcoords(psplat_attribute_table *table) {
    enum { FIRST = PSPLAT_ATTRIBUTE_TEXCOORD_U, SECOND = PSPLAT_ATTRIBUTE_TEXCOORD_UU };
    psplat_attribute_format *formats = table->formats;
    int32_t slope = 0, bend = 0;
    for (size_t kind = PSPLAT_ATTRIBUTE_TEXCOORD; kind <= PSPLAT_ATTRIBUTE_TEXCOORD_VV; ++kind)
        formats[kind] = (psplat_attribute_format){PSPLAT_TYPE_FLOAT, 2};
    for (size_t kind = FIRST; kind <= PSPLAT_ATTRIBUTE_TEXCOORD_VV && table->codes; ++kind) {
        formats[kind].type = PSPLAT_TYPE_SHORT;
        int32_t *most = kind < SECOND ? &slope : &bend, found = greatest(table, kind);
        if (found > *most) *most = found;
    }
    for (size_t kind = FIRST; kind <= PSPLAT_ATTRIBUTE_TEXCOORD_VV && table->codes; ++kind)
        formats[kind].type = type_for(kind < SECOND ? slope : bend, 1);
}

static int has_bends(const psplat_splats *splats) {
    for (size_t i = 0; i < splats->run_count; ++i)
        if (splats->runs[i].has_bends) return 1;
    return 0;
}

static void set_floats(psplat_attribute_table *table) {
    static const psplat_attribute_format formats[] = {
        [PSPLAT_ATTRIBUTE_POSITION] = {PSPLAT_TYPE_FLOAT, 3},
        [PSPLAT_ATTRIBUTE_NORMAL] = {PSPLAT_TYPE_FLOAT, 3},
        [PSPLAT_ATTRIBUTE_ROTATION] = {PSPLAT_TYPE_FLOAT, 4},
        [PSPLAT_ATTRIBUTE_SCALE] = {PSPLAT_TYPE_FLOAT, 2},
        [PSPLAT_ATTRIBUTE_FIELD] = {PSPLAT_TYPE_FLOAT, 3},
        [PSPLAT_ATTRIBUTE_SURFACE_FIELD] = {PSPLAT_TYPE_FLOAT, 3},
        [PSPLAT_ATTRIBUTE_SHAPE] = {PSPLAT_TYPE_FLOAT, 3},
    };
    memcpy(table->formats, formats, sizeof formats);
    for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k)
        table->formats[PSPLAT_ATTRIBUTE_LINE + k] =
            (psplat_attribute_format){PSPLAT_TYPE_FLOAT, has_bends(table->splats) ? 4 : 3};
}

/* Writes the logarithms of radii from the least one on. The range of 16-bit integers with these
 * steps could exceed that of floats, so the integers are multiplied until they fill the type and
 * the range shrinks to what is used. */
static void set_scale(psplat_attribute_table *table) {
    const psplat_splats *splats = table->splats;
    int32_t least = table->codes->scale[1];
    table->scale_factor = 1;
    for (size_t i = 0; i < splats->count; ++i)
        if (table->codes[i].scale[1] < least) least = table->codes[i].scale[1];
    table->least_scale = least;
    psplat_attribute_format *format = &table->formats[PSPLAT_ATTRIBUTE_SCALE];
    *format = (psplat_attribute_format){PSPLAT_TYPE_UNSIGNED_BYTE, 2};
    int32_t most = greatest(table, PSPLAT_ATTRIBUTE_SCALE);
    format->type = type_for(most, 0);
    if (format->type == PSPLAT_TYPE_UNSIGNED_SHORT && most <= 65535)
        table->scale_factor = 65535 / most;
}

/* Returns whether no position was clamped by psplat_quantize_splat, which limits integers to a
 * billion steps. */
static int positions_fit(const psplat_attribute_table *table) {
    static const int32_t most_steps = 999999999;
    for (size_t i = 0; i < table->splats->count; ++i)
        for (int k = 0; k < 3; ++k)
            if (abs(table->codes[i].position[k]) > most_steps) return 0;
    return 1;
}

/* Fails where an integer does not fit into the type of its attribute. */
static psplat_result check_integers(const psplat_attribute_table *table, psplat_error *error) {
    for (size_t kind = 0; kind < PSPLAT_ATTRIBUTE_KINDS; ++kind) {
        const psplat_attribute_format *format = &table->formats[kind];
        if (format->components && greatest(table, kind) > most_of(format->type))
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%s: numbers are more than %d steps",
                               psplat_attribute_names[kind], (int)most_of(format->type));
    }
    if (positions_fit(table)) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                       "positions are more than a billion steps from the origin");
}

/* Sets the formats of what only curved splats have. */
static void set_shape(psplat_attribute_table *table) {
    psplat_attribute_format *formats = table->formats;
    if (!(table->splats->precision.shape_step > 0)) return;
    formats[PSPLAT_ATTRIBUTE_SURFACE_TILT].components = 2;
    formats[PSPLAT_ATTRIBUTE_SHAPE].components = 3;
    formats[PSPLAT_ATTRIBUTE_SURFACE_TILT].type =
        type_for(greatest(table, PSPLAT_ATTRIBUTE_SURFACE_TILT), 1);
    formats[PSPLAT_ATTRIBUTE_SHAPE].type = type_for(greatest(table, PSPLAT_ATTRIBUTE_SHAPE), 1);
    formats[PSPLAT_ATTRIBUTE_SURFACE_FIELD] = formats[PSPLAT_ATTRIBUTE_SHAPE];
}

/* Gives all lines one type, because they share the ranges of the extension object. */
static void set_lines(psplat_attribute_table *table) {
    int32_t most = 0;
    for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k) {
        psplat_attribute_format *format = &table->formats[PSPLAT_ATTRIBUTE_LINE + k];
        format->components = has_bends(table->splats) ? 3 : 2;
        int32_t found = greatest(table, PSPLAT_ATTRIBUTE_LINE + k);
        if (found > most) most = found;
    }
    for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k)
        table->formats[PSPLAT_ATTRIBUTE_LINE + k].type = type_for(most, 1);
}

/* Quantizes all splats, and finds the least position. */
static void quantize(psplat_attribute_table *table) {
    const psplat_splats *splats = table->splats;
    for (size_t run = 0, i = 0; run < splats->run_count; ++run)
        for (size_t end = i + splats->runs[run].count; i < end; ++i) {
            psplat_quantized_splat *code = &table->codes[i];
            psplat_quantize_splat(&splats->precision, &splats->runs[run], &splats->splats[i], code);
            if (splats->runs[run].has_texcoord)
                psplat_quantize_texcoord(&splats->precision, &splats->texcoords[i], code->flipped,
                                         &code->texcoord);
            for (int k = 0; k < 3; ++k)
                if (!i || table->codes[i].position[k] < table->low[k])
                    table->low[k] = table->codes[i].position[k];
        }
}

static psplat_result set_integers(psplat_attribute_table *table, psplat_error *error) {
    const psplat_splats *splats = table->splats;
    psplat_attribute_format *formats = table->formats;
    table->codes = malloc(splats->count * sizeof *table->codes);
    if (!table->codes) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for integers");
    quantize(table);
    formats[PSPLAT_ATTRIBUTE_POSITION] = (psplat_attribute_format){PSPLAT_TYPE_UNSIGNED_SHORT, 3};
    formats[PSPLAT_ATTRIBUTE_NORMAL] = (psplat_attribute_format){
        splats->precision.normal_bits <= 8 ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_SHORT, 3};
    formats[PSPLAT_ATTRIBUTE_TURN].components = 1;
    formats[PSPLAT_ATTRIBUTE_TILT].components = 2;
    formats[PSPLAT_ATTRIBUTE_FIELD].components = 3;
    formats[PSPLAT_ATTRIBUTE_TURN].type = type_for(greatest(table, PSPLAT_ATTRIBUTE_TURN), 0);
    formats[PSPLAT_ATTRIBUTE_TILT].type = type_for(greatest(table, PSPLAT_ATTRIBUTE_TILT), 1);
    formats[PSPLAT_ATTRIBUTE_FIELD].type = type_for(greatest(table, PSPLAT_ATTRIBUTE_FIELD), 1);
    set_shape(table);
    set_scale(table);
    set_lines(table);
    return check_integers(table, error);
}

psplat_result psplat_attribute_table_fill(const psplat_splats *splats,
                                          psplat_attribute_table *table, psplat_error *error) {
    *table = (psplat_attribute_table){.splats = splats};
    psplat_result result = PSPLAT_OK;
    if (!splats->count) return PSPLAT_OK;
    if (splats->precision.unit > 0)
        result = set_integers(table, error);
    else
        set_floats(table);
    if (splats->texcoords && !result) set_texcoords(table);
    set_material_formats(table);
    return result;
}

void psplat_attribute_table_add_gaussians(psplat_attribute_table *table,
                                          const psplat_gaussian *gaussians) {
    psplat_attribute_format *formats = table->formats;
    table->gaussians = gaussians;
    formats[PSPLAT_ATTRIBUTE_GAUSSIAN_ROTATION] =
        (psplat_attribute_format){table->codes ? PSPLAT_TYPE_SHORT : PSPLAT_TYPE_FLOAT, 4};
    formats[PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE] =
        (psplat_attribute_format){table->codes ? PSPLAT_TYPE_UNSIGNED_SHORT : PSPLAT_TYPE_FLOAT, 3};
    if (table->codes && greatest(table, PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE) > 65535)
        formats[PSPLAT_ATTRIBUTE_GAUSSIAN_SCALE].type = PSPLAT_TYPE_FLOAT;
    formats[PSPLAT_ATTRIBUTE_OPACITY] = (psplat_attribute_format){PSPLAT_TYPE_UNSIGNED_BYTE, 1};
    formats[PSPLAT_ATTRIBUTE_HARMONIC] = (psplat_attribute_format){PSPLAT_TYPE_FLOAT, 3};
}

void psplat_attribute_table_free(psplat_attribute_table *table) {
    free(table->codes);
    *table = (psplat_attribute_table){0};
}

void psplat_attribute_table_ranges(const psplat_attribute_table *table,
                                   psplat_quantization_ranges *ranges) {
    const psplat_precision *p = &table->splats->precision;
    const psplat_attribute_format *formats = table->formats;
    double steps = (double)most_of(formats[PSPLAT_ATTRIBUTE_SCALE].type) / table->scale_factor;
    double line = most_of(formats[PSPLAT_ATTRIBUTE_LINE].type);
    double least = table->least_scale * p->scale_step;
    *ranges = (psplat_quantization_ranges){
        .turn = (float)(most_of(formats[PSPLAT_ATTRIBUTE_TURN].type) * p->turn_step),
        .tilt = (float)(most_of(formats[PSPLAT_ATTRIBUTE_TILT].type) * p->tilt_step),
        .surface_tilt =
            (float)(most_of(formats[PSPLAT_ATTRIBUTE_SURFACE_TILT].type) * p->shape_step),
        .field = (float)(most_of(formats[PSPLAT_ATTRIBUTE_FIELD].type) * p->field_step),
        .shape = (float)(most_of(formats[PSPLAT_ATTRIBUTE_SHAPE].type) * p->shape_step),
        .scale = {(float)exp(least), (float)exp(least + steps * p->scale_step)},
        .clip = {(float)(line * p->line_turn_step), (float)(line * p->line_step)},
        .bend = (float)(line * p->bend_step),
        .color = table->color_range,
        .texcoord =
            (float)(most_of(formats[PSPLAT_ATTRIBUTE_TEXCOORD_U].type) * p->texcoord_slope_step),
        .texcoord_bend =
            (float)(most_of(formats[PSPLAT_ATTRIBUTE_TEXCOORD_UU].type) * p->texcoord_bend_step)};
}
