/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * splat_stream.c - splats as a coded stream (spec 3.12).
 *
 * A binary arithmetic coder with adaptive probabilities (Martin: Range encoding, 1979; the carry is
 * that of the LZMA coder) writes the integers of one splat after another, most of them as the
 * difference to the nearest of the splats before.
 */
#include "export/splat_stream.h"

#include "export/splat_attributes.h"
#include "export/texcoord_prediction.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FORM = 1,
    HEAD_BYTES = 60,
    SECTION_BYTES = 12,
    WINDOW = 32,     /* splats among which the nearest is looked for */
    LEAST_BYTES = 3, /* of a stream, for each splat (spec 3.12) */
    MOST_LENGTH = 17,
    MOST_TEXCOORD = 32767, /* of numbers of the first and second order */
    MOST_TEXCOORD_LOW_BITS = 15,
    COARSE_TEXCOORD_POWER = -6, /* TEXCOORD_0 beside a stream is on a grid of 1/64 */
    ADAPTED = 40                /* the most bits that a probability remembers */
};

enum { CURVED = 1, OWN_FIELD = 2, BENDS = 4, TILTED = 8, GAMMA = 16, TEXCOORD_BENDS = 32 };

/* ---- the arithmetic coder -------------------------------------------------------------------- */

typedef struct bit_model {
    uint16_t one, seen;
} bit_model;

typedef struct number_model {
    bit_model zero, sign, length[MOST_LENGTH + 1], highest[MOST_LENGTH + 1];
} number_model;

enum {
    RADIUS,
    ELONGATION,
    NORMAL,
    TILT,
    FIELD,
    FIELD_TWIST,
    SHAPE,
    SHAPE_TWIST,
    LINES,
    LINE_TURN,
    LINE_DISTANCE,
    LINE_BEND,
    TEXCOORD_BEND,
    TEXCOORD_TWIST,
    TEXCOORD_SLOPE,
    TEXCOORD,
    MODELS
};

/* Bytes that grow in memory. */
typedef struct text {
    uint8_t *bytes; /* NULL where memory ran out */
    size_t size, capacity;
    int failed;
} text;

typedef struct encoder {
    text out;
    uint64_t low;
    uint32_t range;
    uint64_t waiting; /* bytes that a carry may still change: one, and the others of 0xff */
    uint8_t first;    /* the first of them */
    int has_begun;    /* the very first byte, which is always 0 and is left out, is gone */
    int is_safe;      /* all readers predict the same texture coordinates */
    number_model models[MODELS];
} encoder;

static void put_byte(text *out, uint32_t byte) {
    if (out->failed) return;
    if (out->size == out->capacity) {
        size_t capacity = 2 * out->capacity + 1024;
        uint8_t *bytes = realloc(out->bytes, capacity);
        if (!bytes) {
            out->failed = 1;
            return;
        }
        out->bytes = bytes;
        out->capacity = capacity;
    }
    out->bytes[out->size++] = (uint8_t)byte;
}

static void put_number(text *out, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) put_byte(out, value >> (8 * i) & 0xff);
}

static void put_float(text *out, double value) {
    float number = (float)value;
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    put_number(out, bits, 4);
}

static void start(encoder *e) {
    const bit_model even = {32768, 0};
    e->range = 0xffffffffu;
    e->waiting = 1;
    for (size_t i = 0; i < MODELS; ++i) {
        number_model *m = &e->models[i];
        m->zero = m->sign = even;
        for (size_t k = 0; k <= MOST_LENGTH; ++k) m->length[k] = m->highest[k] = even;
    }
}

/* Moves the highest byte of low out. A byte waits as long as a carry may change it. */
static void shift_low(encoder *e) {
    if (e->low < 0xff000000u || e->low > 0xffffffffu) {
        uint8_t carry = (uint8_t)(e->low >> 32);
        for (; e->waiting; --e->waiting, e->first = 0xff, e->has_begun = 1)
            if (e->has_begun) put_byte(&e->out, (e->first + carry) & 0xffu);
        e->first = (uint8_t)(e->low >> 24);
    }
    ++e->waiting;
    e->low = (e->low & 0x00ffffffu) << 8;
}

static void split(encoder *e, uint32_t bound, int bit) {
    if (!bit) e->low += bound;
    e->range = bit ? bound : e->range - bound;
    for (; e->range < 1u << 24; e->range <<= 8) shift_low(e);
}

static void put_bit(encoder *e, bit_model *m, int bit) {
    enum { LEAST = 32 };
    split(e, (e->range >> 16) * m->one, bit);
    uint32_t rate = 131072u / (2u * m->seen + 3), one = m->one;
    one = bit ? one + ((65536 - one) * rate >> 16) : one - (one * rate >> 16);
    m->one = (uint16_t)(one < LEAST ? LEAST : one > 65536 - LEAST ? 65536 - LEAST : one);
    if (m->seen < ADAPTED) ++m->seen;
}

static void put_raw(encoder *e, uint32_t value, uint32_t bits) {
    while (bits--) split(e, e->range >> 1, value >> bits & 1);
}

static void put_unsigned(encoder *e, number_model *m, int32_t value) {
    uint32_t number = (uint32_t)value + 1, length = 0;
    while (number >> (length + 1)) ++length;
    for (uint32_t i = 0; i < length; ++i) put_bit(e, &m->length[i], 1);
    put_bit(e, &m->length[length], 0);
    if (length) put_bit(e, &m->highest[length], number >> (length - 1) & 1);
    if (length > 1) put_raw(e, number & ((1u << (length - 1)) - 1), length - 1);
}

static void put_signed(encoder *e, number_model *m, int32_t value) {
    put_bit(e, &m->zero, value != 0);
    if (!value) return;
    put_bit(e, &m->sign, value < 0);
    put_unsigned(e, m, abs(value) - 1);
}

/* Ends with a number of the range that has as many zeros at its end as one of them has, and leaves
 * zeros at the end out, since missing bytes are read as 0. */
static void finish(encoder *e) {
    uint64_t top = e->low + e->range - 1, value = e->low;
    for (int bits = 32; bits >= 8; bits -= 8) {
        uint64_t round = top >> bits << bits;
        if (round < e->low) continue;
        value = round;
        break;
    }
    e->low = value;
    for (int i = 0; i < 5; ++i) shift_low(e);
    for (int i = 0; i < 4 && !e->out.failed && !e->out.bytes[e->out.size - 1]; ++i) --e->out.size;
}

/* ---- what is encoded --------------------------------------------------------------------------
 */

/* What all splats of a stream have in common. */
typedef struct common {
    const psplat_attribute_table *table;
    uint32_t low_bits, normal_bits, turn_bits, line_turn_bits, halving, shape_grades, normal_grades;
    int32_t reference;
    int holds_texcoords;
    uint32_t texcoord_low_bits;
    psplat_texcoord_steps steps; /* as the head has them */
} common;

/* Returns the power of two that is 1 / step, or -1 where there is none from 1 to 14. */
static int power_of(double step) {
    for (int power = 1; power <= 14; ++power)
        if (step * (double)(1 << power) == 1) return power;
    return -1;
}

int psplat_stream_can_hold(const psplat_attribute_table *table) {
    const psplat_precision *p = &table->splats->precision;
    return table->codes && power_of(p->turn_step) > 0 && power_of(p->line_turn_step) > 0;
}

int32_t psplat_stream_coarse_position(const psplat_attribute_table *table, size_t index, int k,
                                      uint32_t low_bits) {
    int32_t position = table->codes[index].position[k] - table->low[k];
    return (position + (int32_t)(1u << low_bits) / 2) >> low_bits;
}

static int32_t radius_of(const common *c, size_t index, int k) {
    return c->table->codes[index].scale[k] - c->table->least_scale;
}

static uint32_t least_of(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

static uint32_t grade_of(const common *c, size_t index) {
    int32_t radius = radius_of(c, index, 0);
    if (!c->halving || radius >= c->reference) return 0;
    return least_of((uint32_t)(c->reference - radius) / c->halving, PSPLAT_MOST_GRADE);
}

/* Returns the bits that the lines of a splat have less. */
static uint32_t line_grade(const common *c, size_t index) {
    return least_of(grade_of(c, index), c->line_turn_bits - 1);
}

static uint32_t turn_bits(const common *c, size_t index) {
    if (!c->halving) return c->turn_bits;
    uint32_t elongation = (uint32_t)(radius_of(c, index, 0) - radius_of(c, index, 1));
    uint32_t parts = 32 * elongation / c->halving, bits = 0;
    for (; parts; parts >>= 1) ++bits;
    return least_of(bits + elongation / (3 * c->halving), c->turn_bits);
}

/* Returns x / 2^shift, rounded to the nearest integer, halves up. */
static int32_t shifted(int32_t x, uint32_t shift) {
    int32_t unit = (int32_t)(1u << shift), y = x + unit / 2;
    return y >= 0 ? y / unit : -((unit - 1 - y) / unit);
}

/* Returns the nearest splat, by coarse positions, of the last ones before a place in the order, or
 * -1 for the first: the last of those that are equally near. */
static long nearest(const common *c, const uint32_t *order, size_t at) {
    double least = HUGE_VAL;
    long found = -1;
    for (size_t i = 1; i <= WINDOW && i <= at; ++i) {
        double distance2 = 0;
        for (int k = 0; k < 3; ++k) {
            double d =
                (double)(psplat_stream_coarse_position(c->table, order[at - i], k, c->low_bits) -
                         psplat_stream_coarse_position(c->table, order[at], k, c->low_bits));
            distance2 += d * d;
        }
        if (!(distance2 < least)) continue;
        least = distance2;
        found = (long)order[at - i];
    }
    return found;
}

/* Returns whether the integers of a splat have the zeros at their end that its grade leaves out. */
static int is_graded(const common *c, size_t index) {
    const psplat_quantized_splat *code = &c->table->codes[index];
    uint32_t grade = grade_of(c, index), normal = (1u << least_of(grade, c->normal_grades)) - 1;
    uint32_t shape = (1u << least_of(grade, c->shape_grades)) - 1;
    uint32_t line = (1u << line_grade(c, index)) - 1;
    uint32_t odd = (uint32_t)code->turn & ((1u << (c->turn_bits - turn_bits(c, index))) - 1);
    for (int k = 0; k < 2; ++k) odd |= (uint32_t)code->normal[k] & normal;
    for (int k = 0; k < 3; ++k) odd |= (uint32_t)code->shape[k] & shape;
    for (uint32_t i = 0; i < c->table->splats->splats[index].clip_count; ++i)
        for (int k = 0; k < 3; ++k) odd |= (uint32_t)code->lines[i][k] & line;
    return !odd;
}

static int are_graded(const common *c, const psplat_section *sections, size_t count) {
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < sections[i].count; ++k)
            if (!is_graded(c, sections[i].order[k])) return 0;
    return 1;
}

/* ---- splats ---------------------------------------------------------------------------------- */

static void put_frame(encoder *e, const common *c, size_t index, long near) {
    const psplat_quantized_splat *code = &c->table->codes[index];
    const int32_t *normal = near < 0 ? NULL : c->table->codes[near].normal;
    for (int k = 0; k < 3; ++k) {
        int32_t position = code->position[k] - c->table->low[k],
                half = (int32_t)(1u << c->low_bits) / 2;
        int32_t coarse = psplat_stream_coarse_position(c->table, index, k, c->low_bits);
        put_raw(e, (uint32_t)(position - coarse * (int32_t)(1u << c->low_bits) + half),
                c->low_bits);
    }
    put_signed(e, &e->models[RADIUS],
               radius_of(c, index, 0) - (near < 0 ? 0 : radius_of(c, (size_t)near, 0)));
    put_unsigned(e, &e->models[ELONGATION], radius_of(c, index, 0) - radius_of(c, index, 1));
    uint32_t coarse = least_of(grade_of(c, index), c->normal_grades);
    for (int k = 0; k < 2; ++k)
        put_signed(e, &e->models[NORMAL],
                   code->normal[k] / (int32_t)(1u << coarse) -
                       (normal ? shifted(normal[k], coarse) : 0));
    uint32_t bits = turn_bits(c, index);
    put_raw(e, (uint32_t)code->turn >> (c->turn_bits - bits), bits);
}

static void put_field(encoder *e, const common *c, const psplat_section *section, unsigned flags,
                      size_t index) {
    const psplat_quantized_splat *code = &c->table->codes[index];
    const int32_t *tilt = section->is_curved && !section->has_shape ? code->shape_tilt : code->tilt;
    int32_t unit = (int32_t)(1u << least_of(grade_of(c, index), c->shape_grades));
    for (int k = 0; k < 2 && flags & TILTED; ++k) put_signed(e, &e->models[TILT], tilt[k]);
    for (int k = 0; k < (flags & GAMMA ? 3 : 2) && flags & OWN_FIELD; ++k)
        put_signed(e, &e->models[k < 2 ? FIELD : FIELD_TWIST], code->field[k]);
    for (int k = 0; k < 3 && flags & CURVED; ++k)
        put_signed(e, &e->models[k < 2 ? SHAPE : SHAPE_TWIST], code->shape[k] / unit);
}

/* A line, with its turn from 0 to less than a whole turn. */
typedef struct line {
    int32_t turn, distance, bend;
} line;

static int compare_lines(const void *a, const void *b) {
    const line *first = a, *second = b;
    if (first->turn != second->turn) return first->turn < second->turn ? -1 : 1;
    if (first->distance != second->distance) return first->distance < second->distance ? -1 : 1;
    return (first->bend > second->bend) - (first->bend < second->bend);
}

/* Finds the lines of a splat, its seams behind the others and both in the order of their turns,
 * without lines that cut nothing off. The turn of a line is no less than that of the line before:
 * seams may be a whole turn farther. Returns how many there are. */
static size_t find_lines(const common *c, size_t seams, size_t index,
                         line lines[PSPLAT_MAX_CLIP_LINES]) {
    const psplat_quantized_splat *code = &c->table->codes[index];
    int32_t whole = (int32_t)(1u << (c->line_turn_bits + 1)),
            unit = (int32_t)(1u << line_grade(c, index));
    int32_t padding = (int32_t)lrint(1 / c->table->splats->precision.line_step);
    size_t count = 0, cuts, stored = c->table->splats->splats[index].clip_count;
    for (size_t i = 0; i < stored; ++i) {
        const int32_t *l = code->lines[i];
        if (i + seams < stored && !l[0] && l[1] == padding && !l[2]) continue;
        lines[count++] =
            (line){((l[0] + whole) % whole) >> line_grade(c, index), l[1] / unit, l[2] / unit};
    }
    cuts = count - seams;
    qsort(lines, cuts, sizeof *lines, compare_lines);
    qsort(lines + cuts, seams, sizeof *lines, compare_lines);
    int is_later = cuts && seams && lines[cuts].turn < lines[cuts - 1].turn;
    for (size_t i = cuts; i < count && is_later; ++i)
        lines[i].turn += whole >> line_grade(c, index);
    return count;
}

static void put_lines(encoder *e, const common *c, const psplat_section *section, unsigned flags,
                      size_t index) {
    line lines[PSPLAT_MAX_CLIP_LINES];
    if (!section->clip_lines) return;
    size_t count = find_lines(c, section->seam_lines, index, lines);
    put_unsigned(e, &e->models[LINES], (int32_t)count);
    for (size_t i = 0; i < count; ++i) {
        if (i)
            put_unsigned(e, &e->models[LINE_TURN], lines[i].turn - lines[i - 1].turn);
        else
            put_raw(e, (uint32_t)lines[i].turn, c->line_turn_bits + 1 - line_grade(c, index));
        put_signed(e, &e->models[LINE_DISTANCE], lines[i].distance);
        if (flags & BENDS) put_signed(e, &e->models[LINE_BEND], lines[i].bend);
    }
}

static int has_bends(const psplat_quantized_texcoord *t) {
    for (int i = 0; i < 6; ++i)
        if (t->bends[i / 2][i % 2]) return 1;
    return 0;
}

/* Returns what a section has that is not 0 in all of its splats. */
static unsigned flags_of(const common *c, const psplat_section *section) {
    unsigned flags = section->is_curved ? CURVED | GAMMA : 0;
    int is_surface = section->is_curved && !section->has_shape;
    if (section->has_shape) flags |= OWN_FIELD;
    for (size_t i = 0; i < section->count; ++i) {
        const psplat_quantized_splat *code = &c->table->codes[section->order[i]];
        const int32_t *tilt = is_surface ? code->shape_tilt : code->tilt;
        if (tilt[0] || tilt[1]) flags |= TILTED;
        if (!is_surface && (code->field[0] || code->field[1] || code->field[2])) flags |= OWN_FIELD;
        if (!is_surface && code->field[2]) flags |= GAMMA;
        if (c->holds_texcoords && section->has_texcoord_bend && has_bends(&code->texcoord))
            flags |= TEXCOORD_BENDS;
        for (uint32_t k = 0; k < c->table->splats->splats[section->order[i]].clip_count; ++k)
            if (code->lines[k][2]) flags |= BENDS;
    }
    return flags;
}

/* ---- texture coordinates --------------------------------------------------------------------- */

static int is_within(const int32_t numbers[2], int32_t most) {
    return abs(numbers[0]) <= most && abs(numbers[1]) <= most;
}

int psplat_stream_can_hold_texcoords(const psplat_attribute_table *table) {
    if (!psplat_attribute_table_has_texcoord_grid(table)) return 0;
    for (size_t i = 0; i < table->splats->count; ++i) {
        const psplat_quantized_texcoord *t = &table->codes[i].texcoord;
        int fits = is_within(t->at, (1 << 23) - 1);
        for (int k = 0; k < 2; ++k) fits &= is_within(t->along[k], MOST_TEXCOORD);
        for (int k = 0; k < 3; ++k) fits &= is_within(t->bends[k], MOST_TEXCOORD);
        if (!fits) return 0;
    }
    return 1;
}

uint32_t psplat_stream_texcoord_low_bits(const psplat_attribute_table *table) {
    int bits = COARSE_TEXCOORD_POWER - ilogb(table->splats->precision.texcoord_step);
    return (uint32_t)(bits < 0 ? 0 : bits > MOST_TEXCOORD_LOW_BITS ? MOST_TEXCOORD_LOW_BITS : bits);
}

int32_t psplat_stream_coarse_texcoord(const psplat_attribute_table *table, size_t index, int k) {
    return shifted(table->codes[index].texcoord.at[k], psplat_stream_texcoord_low_bits(table));
}

/* Returns the splat that predicts the texture coordinates of one in the order, as nearest() does,
 * but for splats that are far away in the image; -1 for the first. */
static long nearest_in_chart(const common *c, const uint32_t *order, size_t at) {
    double least = HUGE_VAL;
    long found = -1;
    for (size_t i = 1; i <= WINDOW && i <= at; ++i) {
        double places = 0, images = 0;
        for (int k = 0; k < 3; ++k) {
            double d = psplat_stream_coarse_position(c->table, order[at - i], k, c->low_bits) -
                       psplat_stream_coarse_position(c->table, order[at], k, c->low_bits);
            places += d * d;
        }
        for (int k = 0; k < 2; ++k) {
            double d = psplat_stream_coarse_texcoord(c->table, order[at - i], k) -
                       psplat_stream_coarse_texcoord(c->table, order[at], k);
            images += d * d;
        }
        if (!(places * (1 + images) < least)) continue;
        least = places * (1 + images);
        found = (long)order[at - i];
    }
    return found;
}

/* Writes coordinates at the centre as the difference to what is predicted, which TEXCOORD_0 limits
 * to a step of its own. */
static void put_texcoord_at(encoder *e, const common *c, size_t index, const double move[2],
                            long from) {
    const psplat_quantized_splat *codes = c->table->codes;
    int32_t half = (int32_t)(1u << c->texcoord_low_bits) / 2;
    for (int k = 0; k < 2; ++k) {
        int32_t predicted = from < 0 ? 0 : codes[from].texcoord.at[k];
        int32_t middle = psplat_stream_coarse_texcoord(c->table, index, k) *
                         (int32_t)(1u << c->texcoord_low_bits);
        int32_t low = middle - half, high = half ? middle + half - 1 : middle;
        predicted += psplat_texcoord_round(move[k] / c->steps.at, 1 << 24, &e->is_safe);
        predicted = predicted < low ? low : predicted > high ? high : predicted;
        put_signed(e, &e->models[TEXCOORD], codes[index].texcoord.at[k] - predicted);
    }
}

static void put_texcoord(encoder *e, const common *c, unsigned flags, size_t index, long from) {
    const psplat_quantized_texcoord *t = &c->table->codes[index].texcoord;
    psplat_texcoord_field field, known;
    double along[2][2] = {{0, 0}, {0, 0}}, move[2] = {0, 0};
    psplat_texcoord_field_make(c->table, index, &c->steps, &field);
    for (int i = 0; i < 6 && flags & TEXCOORD_BENDS; ++i)
        put_signed(e, &e->models[i / 2 == 1 ? TEXCOORD_TWIST : TEXCOORD_BEND],
                   t->bends[i / 2][i % 2]);
    if (from >= 0) {
        psplat_texcoord_field_make(c->table, (size_t)from, &c->steps, &known);
        psplat_texcoord_predict_slopes(&known, &field, along);
        psplat_texcoord_predict_move(&known, &field, move);
    }
    for (int i = 0; i < 4; ++i)
        put_signed(e, &e->models[TEXCOORD_SLOPE],
                   t->along[i / 2][i % 2] -
                       psplat_texcoord_round(along[i / 2][i % 2] / c->steps.along, MOST_TEXCOORD,
                                             &e->is_safe));
    put_texcoord_at(e, c, index, move, from);
}

/* ---- the head -------------------------------------------------------------------------------- */

static void put_head(text *out, const common *c, const psplat_section *sections, size_t count) {
    const psplat_attribute_table *table = c->table;
    const psplat_splats *splats = table->splats;
    const psplat_precision *p = &splats->precision;
    double unit = (double)(1u << c->low_bits);
    int32_t low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
    const uint32_t bytes[] = {FORM,         c->low_bits,       c->normal_bits,
                              c->turn_bits, c->line_turn_bits, c->halving};
    for (size_t i = 0; i < count; ++i)
        for (size_t n = 0; n < sections[i].count; ++n)
            for (int k = 0; k < 3; ++k) {
                int32_t x = table->codes[sections[i].order[n]].position[k];
                if (x < low[k]) low[k] = x;
                if (x > high[k]) high[k] = x;
            }
    for (size_t i = 0; i < sizeof bytes / sizeof *bytes; ++i) put_byte(out, bytes[i]);
    put_number(out, (uint32_t)c->reference, 2);
    put_byte(out, (uint32_t)count);
    put_byte(out, c->halving ? c->shape_grades : 0);
    put_byte(out, c->halving ? c->normal_grades : 0);
    put_byte(out, c->holds_texcoords ? c->texcoord_low_bits + 1 : 0);
    put_float(out, (double)splats->kernel.sharpness);
    put_float(out, (double)splats->kernel.exponent);
    for (int k = 0; k < 3; ++k) put_float(out, low[k] < high[k] ? (high[k] - low[k]) / unit : 0);
    put_float(out, exp(table->least_scale * p->scale_step) / unit);
    put_float(out, p->scale_step);
    put_float(out, p->tilt_step);
    put_float(out, p->field_step);
    put_float(out, p->shape_step);
    put_float(out, p->line_step);
    put_float(out, p->bend_step);
    if (!c->holds_texcoords) return;
    put_float(out, p->texcoord_step);
    put_float(out, p->texcoord_slope_step);
    put_float(out, p->texcoord_bend_step);
}

static void put_section(text *out, const common *c, const psplat_section *section) {
    double unit = c->table->splats->precision.unit * (double)(1u << c->low_bits);
    put_number(out, (uint32_t)section->count, 4);
    put_float(out, (double)section->depth_tolerance / unit);
    put_number(out, (uint32_t)section->clip_lines, 1);
    put_number(out, flags_of(c, section), 3);
}

static void put_splats(encoder *e, const common *c, const psplat_section *sections, size_t count,
                       uint32_t *order) {
    size_t at = 0;
    for (size_t i = 0; i < count; ++i) {
        unsigned flags = flags_of(c, &sections[i]);
        for (size_t k = 0; k < sections[i].count; ++k, ++at) {
            order[at] = sections[i].order[k];
            put_frame(e, c, order[at], nearest(c, order, at));
            put_field(e, c, &sections[i], flags, order[at]);
            put_lines(e, c, &sections[i], flags, order[at]);
            if (c->holds_texcoords)
                put_texcoord(e, c, flags, order[at], nearest_in_chart(c, order, at));
        }
    }
}

/* Sets what texture coordinates need, as readers get it from the floats of the head. */
static void set_texcoords(common *c) {
    const psplat_precision *p = &c->table->splats->precision;
    double unit = (double)(1u << c->low_bits);
    c->holds_texcoords = 1;
    c->texcoord_low_bits = psplat_stream_texcoord_low_bits(c->table);
    c->steps = (psplat_texcoord_steps){
        .at = p->texcoord_step,
        .along = (double)(float)p->texcoord_slope_step,
        .bend = (double)(float)p->texcoord_bend_step,
        .radius_step = (double)(float)p->scale_step,
        .first_radius = (double)(float)(exp(c->table->least_scale * p->scale_step) / unit),
        .low_bits = c->low_bits};
}

static common common_of(const psplat_attribute_table *table, const psplat_section *sections,
                        size_t count, uint32_t low_bits) {
    const psplat_precision *p = &table->splats->precision;
    common c = {.table = table,
                .low_bits = low_bits,
                .normal_bits = (uint32_t)p->normal_bits,
                .turn_bits = (uint32_t)power_of(p->turn_step),
                .line_turn_bits = (uint32_t)power_of(p->line_turn_step),
                .halving = (uint32_t)p->halving,
                .shape_grades = (uint32_t)p->shape_grades,
                .normal_grades = (uint32_t)p->normal_grades};
    int32_t reference = p->reference - table->least_scale;
    c.reference = reference < 0 ? 0 : reference > 65535 ? 65535 : reference;
    if (!are_graded(&c, sections, count)) c.halving = 0;
    return c;
}

uint8_t *psplat_stream_encode(const psplat_attribute_table *table, const psplat_section *sections,
                              size_t section_count, const psplat_stream_desc *desc, size_t *size,
                              int *is_safe) {
    common c = common_of(table, sections, section_count, desc->low_bits);
    encoder e = {.is_safe = 1};
    size_t count = 0;
    for (size_t i = 0; i < section_count; ++i) count += sections[i].count;
    uint32_t *order = malloc((count + 1) * sizeof *order);
    if (!order) return NULL;
    if (desc->holds_texcoords) set_texcoords(&c);
    put_head(&e.out, &c, sections, section_count);
    for (size_t i = 0; i < section_count; ++i) put_section(&e.out, &c, &sections[i]);
    start(&e);
    put_splats(&e, &c, sections, section_count, order);
    finish(&e);
    while (!e.out.failed && e.out.size < LEAST_BYTES * count) put_byte(&e.out, 0);
    free(order);
    *size = e.out.size;
    *is_safe = e.is_safe;
    if (!e.out.failed && e.is_safe) return e.out.bytes;
    free(e.out.bytes);
    return NULL;
}
