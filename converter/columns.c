/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * columns.c - the attributes of splats as bytes. Only what splats vary in is written: no
 * NORMAL_FIELD where every gradient is 0, no gamma where every one is, no COLOR_0 where the colour
 * is uniform, and so on. Equal splats give equal bytes, whatever the machine's byte order.
 */
#include "columns.h"
#include "vector.h"

#include <stdlib.h>
#include <string.h>

#define OURS "_PSPLAT_surface_splats:"
#define GAUSSIAN "KHR_gaussian_splatting:"

const char *const psplat_column_names[PSPLAT_COLUMNS] = {"POSITION",
                                                         "NORMAL",
                                                         "COLOR_0",
                                                         OURS "ROTATION",
                                                         OURS "TURN",
                                                         OURS "TILT",
                                                         OURS "SCALE",
                                                         OURS "NORMAL_FIELD",
                                                         OURS "CLIP_0",
                                                         OURS "CLIP_1",
                                                         OURS "CLIP_2",
                                                         OURS "CLIP_3",
                                                         OURS "COLOR_U",
                                                         OURS "COLOR_V",
                                                         OURS "OCCLUSION_ROUGHNESS_METALLIC",
                                                         OURS "EMISSIVE",
                                                         GAUSSIAN "ROTATION",
                                                         GAUSSIAN "SCALE",
                                                         GAUSSIAN "OPACITY",
                                                         GAUSSIAN "SH_DEGREE_0_COEF_0"};

/* Largest integer of a type; 1 of floats, and of columns that there are not. */
static int32_t most_of(int type) {
    static const int32_t most[] = {127, 255, 32767, 65535};
    return !type || type == PSPLAT_TYPE_FLOAT ? 1 : most[type - PSPLAT_TYPE_BYTE];
}

static size_t component_bytes(int type) {
    return type == PSPLAT_TYPE_FLOAT ? 4 : type >= PSPLAT_TYPE_SHORT ? 2 : 1;
}

size_t psplat_column_bytes(const psplat_column *column) {
    return (column->components * component_bytes(column->type) + 3) / 4 * 4;
}

int psplat_column_is_normalized(const psplat_column *column, size_t kind) {
    return column->type != PSPLAT_TYPE_FLOAT && kind != PSPLAT_COLUMN_POSITION &&
           kind != PSPLAT_COLUMN_GAUSSIAN_SCALE;
}

static int is_line(size_t kind) {
    return kind >= PSPLAT_COLUMN_LINE && kind < PSPLAT_COLUMN_COLOR_U;
}

/* ---- values -------------------------------------------------------------------------------- */

static int is_gaussian(size_t kind) {
    return kind >= PSPLAT_COLUMN_GAUSSIAN_ROTATION;
}

static const float *gaussian_values(const psplat_gaussian *gaussian, size_t kind) {
    static const float opaque = 1;
    return kind == PSPLAT_COLUMN_GAUSSIAN_ROTATION ? gaussian->rotation
           : kind == PSPLAT_COLUMN_GAUSSIAN_SCALE  ? gaussian->scale
           : kind == PSPLAT_COLUMN_OPACITY         ? &opaque
                                                   : gaussian->harmonic;
}

/* What a column has of a splat as floats: its value, or the part of its range. */
static void values_of(const psplat_sheet *sheet, size_t kind, size_t index, float values[4]) {
    static const psplat_finish plain = {
        .occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    const psplat_splat *s = &sheet->splats->splats[index];
    const psplat_finish *f = sheet->splats->finishes ? &sheet->splats->finishes[index] : &plain;
    const float orm[3] = {f->occlusion, f->roughness, f->metallic};
    float sign = sheet->codes && sheet->codes[index].flipped ? -1.0f : 1.0f;
    const float *from = is_gaussian(kind) ? gaussian_values(&sheet->gaussians[index], kind)
                        : kind == PSPLAT_COLUMN_POSITION ? s->center
                        : kind == PSPLAT_COLUMN_NORMAL   ? s->normal
                        : kind == PSPLAT_COLUMN_COLOR    ? s->color
                        : kind == PSPLAT_COLUMN_ROTATION ? s->rotation
                        : kind == PSPLAT_COLUMN_SCALE    ? s->radius
                        : kind == PSPLAT_COLUMN_FIELD    ? s->gradient
                        : is_line(kind)                  ? s->clip[kind - PSPLAT_COLUMN_LINE]
                        : kind == PSPLAT_COLUMN_COLOR_U  ? f->color_u
                        : kind == PSPLAT_COLUMN_COLOR_V  ? f->color_v
                        : kind == PSPLAT_COLUMN_ORM      ? orm
                                                         : f->emissive;
    size_t components = sheet->columns[kind].components;
    memcpy(values, from, components * sizeof *values);
    if (is_line(kind) && kind - PSPLAT_COLUMN_LINE >= s->clip_count)
        values[0] = values[2] = 1, values[1] = 0; /* spec 3.6: cuts nothing off */
    if (kind == PSPLAT_COLUMN_GAUSSIAN_SCALE && sheet->codes)
        for (size_t k = 0; k < 3; ++k)
            values[k] = (float)((double)values[k] / sheet->splats->precision.unit);
    if (kind != PSPLAT_COLUMN_COLOR_U && kind != PSPLAT_COLUMN_COLOR_V) return;
    for (size_t k = 0; k < 3; ++k) values[k] *= sign;
    if (sheet->columns[kind].type != PSPLAT_TYPE_FLOAT)
        for (size_t k = 0; k < 3; ++k) values[k] /= sheet->color_range;
}

/* Integers of a column that is not rounded from floats. Returns 0 where it is. */
static int codes_of(const psplat_sheet *sheet, size_t kind, size_t index, int32_t values[4]) {
    const psplat_precision *p = &sheet->splats->precision;
    const psplat_code *c = &sheet->codes[index];
    if (kind == PSPLAT_COLUMN_POSITION)
        for (int k = 0; k < 3; ++k) values[k] = c->position[k] - sheet->low[k];
    else if (kind == PSPLAT_COLUMN_NORMAL)
        psplat_octahedron_decode(c->normal, p->normal_bits, values);
    else if (kind == PSPLAT_COLUMN_TURN)
        values[0] = c->turn;
    else if (kind == PSPLAT_COLUMN_TILT)
        memcpy(values, c->tilt, sizeof c->tilt);
    else if (kind == PSPLAT_COLUMN_SCALE)
        for (int k = 0; k < 2; ++k)
            values[k] = (c->scale[k] - sheet->least_scale) * sheet->scale_factor;
    else if (kind == PSPLAT_COLUMN_GAUSSIAN_SCALE && sheet->columns[kind].type != PSPLAT_TYPE_FLOAT)
        for (int k = 0; k < 3; ++k)
            values[k] = (int32_t)fmax(1, rint((double)sheet->gaussians[index].scale[k] / p->unit));
    else if (kind == PSPLAT_COLUMN_FIELD)
        memcpy(values, c->field, sizeof c->field);
    else if (is_line(kind) && kind - PSPLAT_COLUMN_LINE >= sheet->splats->splats[index].clip_count)
        values[0] = 0, values[1] = (int32_t)lrint(1 / p->line_step);
    else if (is_line(kind))
        memcpy(values, c->lines[kind - PSPLAT_COLUMN_LINE], sizeof c->lines[0]);
    else
        return 0;
    return 1;
}

/* ---- bytes --------------------------------------------------------------------------------- */

static uint8_t *put(uint8_t *out, uint32_t value, size_t bytes) {
    for (size_t i = 0; i < bytes; ++i) *out++ = (uint8_t)(value >> (8 * i));
    return out;
}

void psplat_sheet_put(const psplat_sheet *sheet, size_t kind, const psplat_column *column,
                      size_t index, uint8_t *out) {
    size_t bytes = component_bytes(column->type);
    uint8_t *end = out + psplat_column_bytes(column);
    int32_t integers[4];
    float values[4];
    int is_coded = sheet->codes && codes_of(sheet, kind, index, integers);
    if (!is_coded) values_of(sheet, kind, index, values);
    for (size_t k = 0; k < column->components; ++k) {
        uint32_t bits;
        if (column->type == PSPLAT_TYPE_FLOAT)
            memcpy(&bits, &values[k], sizeof bits);
        else if (is_coded)
            bits = (uint32_t)integers[k];
        else
            bits = (uint32_t)(int32_t)lrintf(fminf(fmaxf(values[k], -1.0f), 1.0f) *
                                             (float)most_of(column->type));
        out = put(out, bits, bytes);
    }
    while (out < end) *out++ = 0;
}

void psplat_sheet_put_octahedral(const psplat_sheet *sheet, size_t index, uint8_t *out) {
    const int32_t *code = sheet->codes[index].normal;
    int bits = sheet->splats->precision.normal_bits;
    size_t bytes = component_bytes(sheet->columns[PSPLAT_COLUMN_NORMAL].type);
    out = put(out, (uint32_t)code[0], bytes);
    out = put(out, (uint32_t)code[1], bytes);
    put(put(out, (1u << (bits - 1)) - 1, bytes), 0, bytes);
}

/* ---- which there are ------------------------------------------------------------------------ */

/* Whether a splat needs components of a column from a number on. */
static int needs(const psplat_sheet *sheet, size_t kind, size_t index, size_t from) {
    int32_t integers[4] = {0};
    float values[4] = {0}, rest = kind == PSPLAT_COLUMN_ORM || kind == PSPLAT_COLUMN_EMISSIVE;
    size_t components = sheet->columns[kind].components;
    if (sheet->codes && codes_of(sheet, kind, index, integers)) {
        for (size_t k = from; k < components; ++k)
            if (integers[k]) return 1;
        return 0;
    }
    values_of(sheet, kind, index, values);
    for (size_t k = from; k < components; ++k)
        if (values[k] != rest) return 1;
    return 0;
}

static size_t components_of(const psplat_sheet *sheet, size_t kind, size_t first, size_t count) {
    size_t most = 0, all = sheet->columns[kind].components;
    for (size_t i = first; i < first + count && most < all; ++i) {
        if (kind == PSPLAT_COLUMN_FIELD && all == 3 && !needs(sheet, kind, i, 2)) {
            if (most < 2 && needs(sheet, kind, i, 0)) most = 2;
        } else if (needs(sheet, kind, i, 0))
            most = all;
    }
    return most;
}

void psplat_sheet_columns(const psplat_sheet *sheet, size_t first, size_t count, size_t lines,
                          psplat_column columns[PSPLAT_COLUMNS]) {
    memcpy(columns, sheet->columns, sizeof sheet->columns);
    for (size_t kind = 0; kind < PSPLAT_COLUMNS; ++kind) {
        psplat_column *column = &columns[kind];
        if (is_line(kind) && kind - PSPLAT_COLUMN_LINE >= lines) column->components = 0;
        if (kind == PSPLAT_COLUMN_TILT || kind == PSPLAT_COLUMN_FIELD ||
            (kind >= PSPLAT_COLUMN_COLOR_U && !is_gaussian(kind)))
            column->components = components_of(sheet, kind, first, count);
    }
    if (columns[PSPLAT_COLUMN_COLOR_U].components || columns[PSPLAT_COLUMN_COLOR_V].components)
        columns[PSPLAT_COLUMN_COLOR_U].components = columns[PSPLAT_COLUMN_COLOR_V].components = 3;
}

void psplat_sheet_extent(const psplat_sheet *sheet, size_t first, size_t count, float low[3],
                         float high[3]) {
    for (size_t i = first; i < first + count; ++i)
        for (int k = 0; k < 3; ++k) {
            float x = sheet->codes ? (float)(sheet->codes[i].position[k] - sheet->low[k])
                                   : sheet->splats->splats[i].center[k];
            if (i == first || x < low[k]) low[k] = x;
            if (i == first || x > high[k]) high[k] = x;
        }
}

/* ---- types ---------------------------------------------------------------------------------- */

/* Greatest magnitude of a column's integers. */
static int32_t greatest(const psplat_sheet *sheet, size_t kind) {
    int32_t most = 0;
    for (size_t i = 0; i < sheet->splats->count; ++i) {
        int32_t values[4];
        codes_of(sheet, kind, i, values);
        for (size_t k = 0; k < sheet->columns[kind].components; ++k)
            if (abs(values[k]) > most) most = abs(values[k]);
    }
    return most;
}

/* The smallest type whose largest integer is at least this. */
static int type_for(int32_t most, int is_signed) {
    if (is_signed) return most <= 127 ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_SHORT;
    return most <= 255 ? PSPLAT_TYPE_UNSIGNED_BYTE : PSPLAT_TYPE_UNSIGNED_SHORT;
}

/* Whether bytes hold a colour: linear light in 8 bits may be no more than 1 % off once encoded for
 * the eye, which dark colours are. */
static int fits_bytes(const float color[3]) {
    for (size_t k = 0; k < 3; ++k) {
        double c = (double)color[k], rounded = rint(c * 255) / 255;
        if (fabs(pow(c, 1 / 2.4) - pow(rounded, 1 / 2.4)) > 0.01) return 0;
    }
    return 1;
}

/* The type of integers that hold all of the colours, count of them with so many bytes between. */
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

static void set_finishes(psplat_sheet *sheet) {
    const psplat_splats *splats = sheet->splats;
    psplat_column *columns = sheet->columns;
    sheet->color_range = color_range_of(splats);
    /* A range of 0 is none (spec 3.1). */
    if (sheet->color_range > 0)
        columns[PSPLAT_COLUMN_COLOR_U] = columns[PSPLAT_COLUMN_COLOR_V] =
            (psplat_column){sheet->codes ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_FLOAT, 3};
    columns[PSPLAT_COLUMN_ORM] = columns[PSPLAT_COLUMN_EMISSIVE] =
        (psplat_column){sheet->codes ? PSPLAT_TYPE_UNSIGNED_BYTE : PSPLAT_TYPE_FLOAT, 3};
    if (sheet->codes)
        columns[PSPLAT_COLUMN_EMISSIVE].type =
            type_of_colors(splats->finishes->emissive, splats->count, sizeof *splats->finishes);
}

static void set_looks(psplat_sheet *sheet) {
    const psplat_splats *splats = sheet->splats;
    /* Three shorts would save nothing, glTF aligns elements to 4 bytes. */
    if (splats->has_color)
        sheet->columns[PSPLAT_COLUMN_COLOR] =
            (psplat_column){sheet->codes ? type_of_colors(splats->splats->color, splats->count,
                                                          sizeof *splats->splats)
                                         : PSPLAT_TYPE_UNSIGNED_SHORT,
                            sheet->codes && is_opaque(splats) ? 3 : 4};
    if (splats->finishes) set_finishes(sheet);
}

static void set_floats(psplat_sheet *sheet) {
    static const psplat_column columns[] = {
        [PSPLAT_COLUMN_POSITION] = {PSPLAT_TYPE_FLOAT, 3},
        [PSPLAT_COLUMN_NORMAL] = {PSPLAT_TYPE_FLOAT, 3},
        [PSPLAT_COLUMN_ROTATION] = {PSPLAT_TYPE_FLOAT, 4},
        [PSPLAT_COLUMN_SCALE] = {PSPLAT_TYPE_FLOAT, 2},
        [PSPLAT_COLUMN_FIELD] = {PSPLAT_TYPE_FLOAT, 3},
    };
    memcpy(sheet->columns, columns, sizeof columns);
    for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k)
        sheet->columns[PSPLAT_COLUMN_LINE + k] = (psplat_column){PSPLAT_TYPE_FLOAT, 3};
}

/* Shorts of radii stand for more than floats hold unless their steps are small: then they count
 * several to a step. */
static void set_scale(psplat_sheet *sheet) {
    const psplat_splats *splats = sheet->splats;
    int32_t least = sheet->codes->scale[1];
    sheet->scale_factor = 1;
    for (size_t i = 0; i < splats->count; ++i)
        if (sheet->codes[i].scale[1] < least) least = sheet->codes[i].scale[1];
    sheet->least_scale = least;
    psplat_column *column = &sheet->columns[PSPLAT_COLUMN_SCALE];
    *column = (psplat_column){PSPLAT_TYPE_UNSIGNED_BYTE, 2};
    int32_t most = greatest(sheet, PSPLAT_COLUMN_SCALE);
    column->type = type_for(most, 0);
    if (column->type == PSPLAT_TYPE_UNSIGNED_SHORT && most <= 65535)
        sheet->scale_factor = 65535 / most;
}

/* Codes beyond what psplat_code_of rounds to are not what they should be. */
static int are_near(const psplat_sheet *sheet) {
    static const int32_t farthest = 999999999;
    for (size_t i = 0; i < sheet->splats->count; ++i)
        for (int k = 0; k < 3; ++k)
            if (abs(sheet->codes[i].position[k]) > farthest) return 0;
    return 1;
}

/* Nothing that a type does not hold is cut off. */
static psplat_result check_integers(const psplat_sheet *sheet, psplat_error *error) {
    for (size_t kind = 0; kind < PSPLAT_COLUMNS; ++kind) {
        const psplat_column *column = &sheet->columns[kind];
        if (column->components && greatest(sheet, kind) > most_of(column->type))
            return psplat_fail(error, PSPLAT_ERROR_RANGE, 0, "%s: numbers are more than %d steps",
                               psplat_column_names[kind], (int)most_of(column->type));
    }
    if (are_near(sheet)) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_RANGE, 0,
                       "positions are more than a billion steps from the origin");
}

static psplat_result set_integers(psplat_sheet *sheet, psplat_error *error) {
    const psplat_splats *splats = sheet->splats;
    psplat_column *columns = sheet->columns;
    sheet->codes = malloc(splats->count * sizeof *sheet->codes);
    if (!sheet->codes) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for integers");
    for (size_t i = 0; i < splats->count; ++i) {
        psplat_code_of(&splats->precision, &splats->splats[i], &sheet->codes[i]);
        for (int k = 0; k < 3; ++k)
            if (!i || sheet->codes[i].position[k] < sheet->low[k])
                sheet->low[k] = sheet->codes[i].position[k];
    }
    columns[PSPLAT_COLUMN_POSITION] = (psplat_column){PSPLAT_TYPE_UNSIGNED_SHORT, 3};
    columns[PSPLAT_COLUMN_NORMAL] = (psplat_column){
        splats->precision.normal_bits <= 8 ? PSPLAT_TYPE_BYTE : PSPLAT_TYPE_SHORT, 3};
    columns[PSPLAT_COLUMN_TURN].components = 1;
    columns[PSPLAT_COLUMN_TILT].components = 2;
    columns[PSPLAT_COLUMN_FIELD].components = 3;
    columns[PSPLAT_COLUMN_TURN].type = type_for(greatest(sheet, PSPLAT_COLUMN_TURN), 0);
    columns[PSPLAT_COLUMN_TILT].type = type_for(greatest(sheet, PSPLAT_COLUMN_TILT), 1);
    columns[PSPLAT_COLUMN_FIELD].type = type_for(greatest(sheet, PSPLAT_COLUMN_FIELD), 1);
    set_scale(sheet);
    int32_t most = 0;
    for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k) {
        columns[PSPLAT_COLUMN_LINE + k].components = 2;
        int32_t found = greatest(sheet, PSPLAT_COLUMN_LINE + k);
        if (found > most) most = found;
    }
    for (size_t k = 0; k < PSPLAT_MAX_CLIP_LINES; ++k)
        columns[PSPLAT_COLUMN_LINE + k].type = type_for(most, 1);
    return check_integers(sheet, error);
}

psplat_result psplat_sheet_fill(const psplat_splats *splats, psplat_sheet *sheet,
                                psplat_error *error) {
    *sheet = (psplat_sheet){.splats = splats};
    psplat_result result = PSPLAT_OK;
    if (!splats->count) return PSPLAT_OK;
    if (splats->precision.unit > 0)
        result = set_integers(sheet, error);
    else
        set_floats(sheet);
    set_looks(sheet);
    return result;
}

void psplat_sheet_add_gaussians(psplat_sheet *sheet, const psplat_gaussian *gaussians) {
    psplat_column *columns = sheet->columns;
    sheet->gaussians = gaussians;
    columns[PSPLAT_COLUMN_GAUSSIAN_ROTATION] =
        (psplat_column){sheet->codes ? PSPLAT_TYPE_SHORT : PSPLAT_TYPE_FLOAT, 4};
    columns[PSPLAT_COLUMN_GAUSSIAN_SCALE] =
        (psplat_column){sheet->codes ? PSPLAT_TYPE_UNSIGNED_SHORT : PSPLAT_TYPE_FLOAT, 3};
    if (sheet->codes && greatest(sheet, PSPLAT_COLUMN_GAUSSIAN_SCALE) > 65535)
        columns[PSPLAT_COLUMN_GAUSSIAN_SCALE].type = PSPLAT_TYPE_FLOAT;
    columns[PSPLAT_COLUMN_OPACITY] = (psplat_column){PSPLAT_TYPE_UNSIGNED_BYTE, 1};
    columns[PSPLAT_COLUMN_HARMONIC] = (psplat_column){PSPLAT_TYPE_FLOAT, 3};
}

void psplat_sheet_free(psplat_sheet *sheet) {
    free(sheet->codes);
    *sheet = (psplat_sheet){0};
}

void psplat_sheet_ranges(const psplat_sheet *sheet, psplat_ranges *ranges) {
    const psplat_precision *p = &sheet->splats->precision;
    const psplat_column *columns = sheet->columns;
    double steps = (double)most_of(columns[PSPLAT_COLUMN_SCALE].type) / sheet->scale_factor;
    double line = most_of(columns[PSPLAT_COLUMN_LINE].type);
    double least = sheet->least_scale * p->scale_step;
    *ranges = (psplat_ranges){
        .turn = (float)(most_of(columns[PSPLAT_COLUMN_TURN].type) * p->turn_step),
        .tilt = (float)(most_of(columns[PSPLAT_COLUMN_TILT].type) * p->tilt_step),
        .field = (float)(most_of(columns[PSPLAT_COLUMN_FIELD].type) * p->field_step),
        .scale = {(float)exp(least), (float)exp(least + steps * p->scale_step)},
        .clip = {(float)(line * p->line_turn_step), (float)(line * p->line_step)},
        .color = sheet->color_range};
}
