/* SPDX-License-Identifier: MIT
 *
 * stream.c - the coded stream of a primitive of splats (spec 3.12). A binary arithmetic decoder
 * with adaptive probabilities (Martin: Range encoding, 1979) reads the integers of one splat after
 * another; most are differences to the nearest of the splats before. They become floats in rows,
 * from which the attributes are read and checked like those of any file.
 *
 * All arithmetic that decides what is read next is of integers, so that every machine reads the
 * same. Every number of a stream is untrusted.
 */
#include "asset/stream.h"

#include "asset/stream_texcoord.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    FORM = 1, /* of the stream: the only one so far */
    HEAD_BYTES = 60,
    TEXCOORD_HEAD_BYTES = 12, /* more, where there are texture coordinates */
    SECTION_BYTES = 12,
    WINDOW = 32,     /* splats among which the nearest is looked for */
    LEAST_BYTES = 3, /* of a stream, for each splat: so that a small file cannot fill the memory */
    MOST_ALIGNING = 3, /* zeros behind the last splat */
    MOST_GRADE = 7,
    MOST_LENGTH = 17, /* of the unary part of a number */
    MOST_RADIUS = 65535,
    MOST_TEXCOORD_LOW_BITS = 15,
    MOST_TEXCOORD = 32767,            /* of numbers of the first and second order */
    MOST_TEXCOORD_AT = (1 << 23) - 1, /* of those at centres, steps */
    ADAPTED = 40                      /* the most bits that a probability remembers */
};

enum {
    CURVED = 1,
    OWN_FIELD = 2,
    BENDS = 4,
    TILTED = 8,
    GAMMA = 16,
    TEXCOORD_BENDS = 32,
    FLAGS = 63
};

/* The floats of a row. */
enum {
    AT_POSITION = 0,
    AT_NORMAL = 3,
    AT_TURN = 6,
    AT_SCALE = 7,
    AT_TILT = 9,
    AT_FIELD = 11,
    AT_SHAPE = 14,
    AT_LINES = 17,
    AT_TEXCOORD = AT_LINES + 4 * PSPLAT_MAX_CLIP_LINES, /* six pairs */
    ROW = AT_TEXCOORD + 12,
    ROW_BYTES = 4 * ROW,
    PLAIN_ROW_BYTES = 4 * AT_TEXCOORD /* without texture coordinates */
};

/* ---- the head ------------------------------------------------------------------------------- */

static uint32_t get_u32(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static float get_float(const uint8_t *bytes) {
    uint32_t bits = get_u32(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static psplat_result fail(const psplat_gltf *gltf, const psplat_stream *s, psplat_result code,
                          const char *what) {
    return psplat_fail(gltf->error, code, psplat_gltf_offset(gltf, s->json), "a stream %s", what);
}

static int is_from(uint32_t value, uint32_t least, uint32_t most) {
    return value >= least && value <= most;
}

/* Reads the steps of texture coordinates, behind the rest of the head. */
static psplat_result parse_texcoord_head(const psplat_gltf *gltf, psplat_stream *s) {
    float steps[3];
    s->has_texcoord = s->bytes[11] > 0;
    s->head_size = HEAD_BYTES;
    if (!s->has_texcoord) return PSPLAT_OK;
    s->head_size += TEXCOORD_HEAD_BYTES;
    if (s->size < s->head_size) return fail(gltf, s, PSPLAT_ERROR_FORMAT, "is too short");
    for (size_t i = 0; i < 3; ++i) {
        steps[i] = get_float(s->bytes + HEAD_BYTES + 4 * i);
        if (!(steps[i] >= 0 && steps[i] <= FLT_MAX))
            return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a number that is none or below 0");
    }
    s->texcoord_low_bits = s->bytes[11] - 1u;
    s->texcoord_step = (double)steps[0];
    s->texcoord_slope_step = (double)steps[1];
    s->texcoord_bend_step = (double)steps[2];
    if (s->texcoord_low_bits > MOST_TEXCOORD_LOW_BITS || !(steps[0] >= FLT_MIN) ||
        get_u32(s->bytes + HEAD_BYTES) & 0x7fffff || !(steps[1] > 0))
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a head out of range");
    return PSPLAT_OK;
}

static psplat_result parse_head(const psplat_gltf *gltf, psplat_stream *s) {
    const uint8_t *b = s->bytes;
    float numbers[12];
    if (s->size < HEAD_BYTES) return fail(gltf, s, PSPLAT_ERROR_FORMAT, "is too short");
    if (b[0] != FORM) return fail(gltf, s, PSPLAT_ERROR_UNSUPPORTED, "is of an unknown form");
    for (size_t i = 0; i < 12; ++i) {
        numbers[i] = get_float(b + 12 + 4 * i);
        if (!(numbers[i] >= 0 && numbers[i] <= FLT_MAX))
            return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a number that is none or below 0");
    }
    s->low_bits = b[1];
    s->normal_bits = b[2];
    s->turn_bits = b[3];
    s->line_turn_bits = b[4];
    s->halving = b[5];
    s->reference = b[6] | b[7] << 8;
    s->section_count = b[8];
    s->shape_grades = b[9];
    s->normal_grades = b[10];
    s->kernel = (psplat_kernel){numbers[0], numbers[1]};
    for (int k = 0; k < 3; ++k) s->extent[k] = (double)numbers[2 + k];
    s->first_radius = (double)numbers[5];
    s->radius_step = (double)numbers[6];
    s->tilt_step = (double)numbers[7];
    s->field_step = (double)numbers[8];
    s->shape_step = (double)numbers[9];
    s->line_step = (double)numbers[10];
    s->bend_step = (double)numbers[11];
    if (!is_from(b[1], 0, 8) || !is_from(b[2], 4, 14) || !is_from(b[3], 1, 14) ||
        !is_from(b[4], 1, 14) || b[9] > MOST_GRADE || b[10] > MOST_GRADE || b[10] > b[2] - 4 ||
        !is_from(b[8], 1, PSPLAT_MAX_SECTIONS) || !(numbers[0] > 0) || !(numbers[1] > 0))
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a head out of range");
    return parse_texcoord_head(gltf, s);
}

static psplat_result parse_sections(const psplat_gltf *gltf, psplat_stream *s) {
    if (s->size < s->head_size + SECTION_BYTES * s->section_count)
        return fail(gltf, s, PSPLAT_ERROR_FORMAT, "is too short");
    for (size_t i = 0; i < s->section_count; ++i) {
        const uint8_t *b = s->bytes + s->head_size + SECTION_BYTES * i;
        unsigned flags = b[9];
        psplat_stream_section *section = &s->sections[i];
        *section = (psplat_stream_section){.first = s->count,
                                           .count = get_u32(b),
                                           .depth_tolerance = get_float(b + 4),
                                           .clip_count = b[8],
                                           .is_curved = (flags & CURVED) != 0,
                                           .has_own_field = (flags & OWN_FIELD) != 0,
                                           .has_bends = (flags & BENDS) != 0,
                                           .has_tilt = (flags & TILTED) != 0,
                                           .has_gamma = (flags & GAMMA) != 0,
                                           .has_texcoord_bend = (flags & TEXCOORD_BENDS) != 0};
        if (!section->count || section->clip_count > PSPLAT_MAX_CLIP_LINES || flags > FLAGS ||
            b[10] || b[11] ||
            !(section->depth_tolerance >= 0 && section->depth_tolerance <= FLT_MAX) ||
            ((flags & CURVED) && !(flags & GAMMA)) ||
            ((flags & TEXCOORD_BENDS) && !(s->texcoord_bend_step > 0)))
            return fail(gltf, s, PSPLAT_ERROR_RANGE, "has a section out of range");
        /* Compared before it is added, so that no sum wraps where size_t has 32 bits. */
        if (section->count > s->size / LEAST_BYTES - s->count)
            return fail(gltf, s, PSPLAT_ERROR_RANGE,
                        "announces more splats than its bytes can hold");
        s->count += section->count;
    }
    return PSPLAT_OK;
}

/* ---- the arithmetic decoder -------------------------------------------------------------------
 */

/* The probability that a bit is 1, as a part of 65536, and how many bits it has seen. */
typedef struct bit_model {
    uint16_t one, seen;
} bit_model;

/* The bits of one kind of number: whether it is 0, its sign, the length of its magnitude, and the
 * highest bit below that. */
typedef struct number_model {
    bit_model zero, sign, length[MOST_LENGTH + 1], highest[MOST_LENGTH + 1];
} number_model;

/* One model for each kind of number of a splat. */
enum {
    RADIUS,
    ELONGATION,
    NORMAL,
    TILT,
    FIELD,       /* alpha and beta of fields that are of no surface */
    FIELD_TWIST, /* gamma of them */
    SHAPE,       /* of surfaces */
    SHAPE_TWIST,
    LINES,
    LINE_TURN,
    LINE_DISTANCE,
    LINE_BEND,
    TEXCOORD_BEND, /* with uu and vv */
    TEXCOORD_TWIST,
    TEXCOORD_SLOPE,
    TEXCOORD,
    MODELS
};

/* The integers of a splat. */
typedef struct code {
    double place[3]; /* POSITION */
    int32_t low[3], radius[2], normal[2], turn, tilt[2], field[3], shape[3];
    uint32_t line_count;
    int32_t lines[PSPLAT_MAX_CLIP_LINES][3];
    int32_t coarse[2];            /* TEXCOORD_0, in its own steps */
    int32_t texcoords[6][2];      /* at the centre, along u and v, uu, uv and vv */
    psplat_stream_texcoord image; /* where there are texture coordinates */
} code;

typedef struct decoder {
    psplat_stream *stream;
    const uint8_t *next, *end;
    size_t missing; /* bytes read beyond the end, which are 0 */
    uint32_t range, value;
    int measures, is_damaged;
    double *spent; /* bits of the attribute that is being read */
    uint16_t rates[ADAPTED + 1];
    number_model models[MODELS];
    code window[WINDOW]; /* the last splats; number i is at i % WINDOW */
} decoder;

/* One stream is decoded at a time, in memory that all of a file share. */
struct psplat_stream_memory {
    psplat_stream stream;
    decoder decoder;
    uint8_t *rows;
    size_t capacity; /* bytes */
};

static uint32_t next_byte(decoder *d) {
    if (d->next < d->end) return *d->next++;
    ++d->missing;
    return 0;
}

static void start(decoder *d) {
    d->range = 0xffffffffu;
    for (int i = 0; i < 4; ++i) d->value = d->value << 8 | next_byte(d);
    for (uint32_t n = 0; n <= ADAPTED; ++n) d->rates[n] = (uint16_t)(131072 / (2 * n + 3));
    for (size_t i = 0; i < MODELS; ++i) {
        const bit_model even = {32768, 0};
        number_model *m = &d->models[i];
        m->zero = m->sign = even;
        for (size_t k = 0; k <= MOST_LENGTH; ++k) m->length[k] = m->highest[k] = even;
    }
}

/* Reads a bit for which the lower `bound` of the range stands if it is 1. */
static int split(decoder *d, uint32_t bound) {
    int bit = d->value < bound;
    if (d->measures) {
        double part = bit ? (double)bound : (double)(d->range - bound);
        *d->spent += log2((double)d->range / part);
    }
    if (!bit) d->value -= bound;
    d->range = bit ? bound : d->range - bound;
    for (; d->range < 1u << 24; d->range <<= 8) d->value = d->value << 8 | next_byte(d);
    return bit;
}

/* Reads a bit, and moves its probability towards it, at first fast. */
static int get_bit(decoder *d, bit_model *m) {
    enum { LEAST = 32 };
    int bit = split(d, (d->range >> 16) * m->one);
    uint32_t rate = d->rates[m->seen], one = m->one;
    one = bit ? one + ((65536 - one) * rate >> 16) : one - (one * rate >> 16);
    m->one = (uint16_t)(one < LEAST ? LEAST : one > 65536 - LEAST ? 65536 - LEAST : one);
    if (m->seen < ADAPTED) ++m->seen;
    return bit;
}

static uint32_t get_raw(decoder *d, uint32_t bits) {
    uint32_t value = 0;
    for (uint32_t i = 0; i < bits; ++i) value = value << 1 | (uint32_t)split(d, d->range >> 1);
    return value;
}

/* Reads a number of at least 0: the length of the number plus 1 in unary, then its bits. */
static int32_t get_unsigned(decoder *d, number_model *m) {
    uint32_t length = 0, value = 1;
    while (length < MOST_LENGTH && get_bit(d, &m->length[length])) ++length;
    if (length == MOST_LENGTH) d->is_damaged = 1;
    if (length) value = value << 1 | (uint32_t)get_bit(d, &m->highest[length]);
    if (length > 1) value = value << (length - 1) | get_raw(d, length - 1);
    return (int32_t)(value - 1);
}

static int32_t get_signed(decoder *d, number_model *m) {
    if (!get_bit(d, &m->zero)) return 0;
    int is_negative = get_bit(d, &m->sign);
    int32_t magnitude = get_unsigned(d, m) + 1;
    return is_negative ? -magnitude : magnitude;
}

/* ---- splats ---------------------------------------------------------------------------------- */

/* Returns x / 2^shift, rounded to the nearest integer, halves up. */
static int32_t shifted(int32_t x, uint32_t shift) {
    int32_t unit = (int32_t)(1u << shift), y = x + unit / 2;
    return y >= 0 ? y / unit : -((unit - 1 - y) / unit);
}

/* Returns the last splat among those nearest to a place. */
static const code *nearest(const decoder *d, size_t index, const double place[3]) {
    static const code none = {.radius = {0, 0}};
    const code *found = &none;
    double least = HUGE_VAL;
    for (size_t i = 1; i <= WINDOW && i <= index; ++i) {
        const code *c = &d->window[(index - i) % WINDOW];
        double x = c->place[0] - place[0], y = c->place[1] - place[1], z = c->place[2] - place[2];
        double distance2 = x * x + y * y + z * z;
        if (!(distance2 < least)) continue;
        least = distance2;
        found = c;
    }
    return found;
}

/* Returns how many bits of precision a splat has less than the largest: one for each halving of its
 * radius. */
static uint32_t grade_of(const psplat_stream *s, int32_t radius) {
    if (!s->halving || radius >= s->reference) return 0;
    uint32_t grade = (uint32_t)(s->reference - radius) / s->halving;
    return grade < MOST_GRADE ? grade : MOST_GRADE;
}

/* Returns the bits of a turn: the rounder the ellipse, the fewer. */
static uint32_t turn_bits(const psplat_stream *s, int32_t elongation) {
    if (!s->halving) return s->turn_bits;
    uint32_t parts = 32 * (uint32_t)elongation / s->halving, bits = 0;
    for (; parts; parts >>= 1) ++bits;
    bits += (uint32_t)elongation / (3 * s->halving);
    return bits < s->turn_bits ? bits : s->turn_bits;
}

static uint32_t least_of(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

static void read_frame(decoder *d, const code *near, double *spent, code *c) {
    const psplat_stream *s = d->stream;
    d->spent = &spent[PSPLAT_POSITION];
    for (int k = 0; k < 3; ++k)
        c->low[k] = (int32_t)get_raw(d, s->low_bits) - (int32_t)(1u << s->low_bits) / 2;
    d->spent = &spent[PSPLAT_SCALE];
    c->radius[0] = near->radius[0] + get_signed(d, &d->models[RADIUS]);
    int32_t elongation = get_unsigned(d, &d->models[ELONGATION]);
    c->radius[1] = c->radius[0] - elongation;
    if (c->radius[1] < 0 || c->radius[0] > MOST_RADIUS) d->is_damaged = 1;
    if (d->is_damaged) return;
    uint32_t coarse = least_of(grade_of(s, c->radius[0]), s->normal_grades);
    d->spent = &spent[PSPLAT_NORMAL];
    for (int k = 0; k < 2; ++k) {
        int32_t steps = shifted(near->normal[k], coarse) + get_signed(d, &d->models[NORMAL]);
        c->normal[k] = steps * (int32_t)(1u << coarse);
        int32_t most = (int32_t)(1u << (s->normal_bits - 1)) - 1;
        if (c->normal[k] > most || c->normal[k] < -most) d->is_damaged = 1;
    }
    d->spent = &spent[PSPLAT_TURN];
    uint32_t bits = turn_bits(s, elongation);
    c->turn = (int32_t)(get_raw(d, bits) << (s->turn_bits - bits));
}

static void read_field(decoder *d, const psplat_stream_section *section, double *spent, code *c) {
    number_model *m = d->models;
    const psplat_stream *s = d->stream;
    int32_t unit = (int32_t)(1u << least_of(grade_of(s, c->radius[0]), s->shape_grades));
    d->spent = &spent[PSPLAT_TILT];
    for (int k = 0; k < 2 && section->has_tilt; ++k) c->tilt[k] = get_signed(d, &m[TILT]);
    d->spent = &spent[PSPLAT_NORMAL_FIELD];
    for (int k = 0; k < (section->has_gamma ? 3 : 2) && section->has_own_field; ++k)
        c->field[k] = get_signed(d, &m[k < 2 ? FIELD : FIELD_TWIST]);
    if (section->has_own_field) d->spent = &spent[PSPLAT_SHAPE];
    for (int k = 0; k < 3 && section->is_curved; ++k)
        c->shape[k] = unit * get_signed(d, &m[k < 2 ? SHAPE : SHAPE_TWIST]);
}

/* Lines are in the order of their turns. */
static void read_lines(decoder *d, const psplat_stream_section *section, double *spent, code *c) {
    number_model *m = d->models;
    uint32_t bits = d->stream->line_turn_bits + 1;
    uint32_t coarse = least_of(grade_of(d->stream, c->radius[0]), bits - 2);
    int32_t unit = (int32_t)(1u << coarse), turn = 0;
    if (!section->clip_count) return;
    d->spent = &spent[PSPLAT_FIRST_CLIP];
    c->line_count = (uint32_t)get_unsigned(d, &m[LINES]);
    if (c->line_count > section->clip_count) d->is_damaged = 1;
    for (uint32_t i = 0; i < c->line_count && !d->is_damaged; ++i) {
        d->spent = &spent[PSPLAT_FIRST_CLIP + i];
        turn += i ? get_unsigned(d, &m[LINE_TURN]) : (int32_t)get_raw(d, bits - coarse);
        c->lines[i][0] = turn * unit;
        c->lines[i][1] = unit * get_signed(d, &m[LINE_DISTANCE]);
        c->lines[i][2] = section->has_bends ? unit * get_signed(d, &m[LINE_BEND]) : 0;
    }
}

/* ---- texture coordinates --------------------------------------------------------------------- */

/* Returns the last of those splats that are nearest in space and in the image together; NULL for
 * the first. */
static const code *nearest_in_chart(const decoder *d, size_t index, const code *c) {
    const code *found = NULL;
    double least = HUGE_VAL;
    for (size_t i = 1; i <= WINDOW && i <= index; ++i) {
        const code *other = &d->window[(index - i) % WINDOW];
        double places = 0, images = 0;
        for (int k = 0; k < 3; ++k) {
            double difference = other->place[k] - c->place[k];
            places += difference * difference;
        }
        for (int k = 0; k < 2; ++k) {
            double difference = other->coarse[k] - c->coarse[k];
            images += difference * difference;
        }
        if (!(places * (1 + images) < least)) continue;
        least = places * (1 + images);
        found = other;
    }
    return found;
}

/* Sets what is known of a splat's field before its texture coordinates. */
static void start_field(const psplat_stream *s, code *c) {
    psplat_stream_texcoord *f = &c->image;
    psplat_stream_texcoord_axes(c->normal, s->normal_bits, c->turn / (double)(1u << s->turn_bits),
                                f->axes);
    for (int k = 0; k < 3; ++k)
        f->center[k] = c->place[k] + (double)c->low[k] / (double)(1u << s->low_bits);
    for (int k = 0; k < 2; ++k) f->radius[k] = s->first_radius * exp(c->radius[k] * s->radius_step);
}

/* Reads a number next to a prediction. */
static int32_t read_near(decoder *d, number_model *m, int32_t predicted, int32_t most) {
    int32_t number = predicted + get_signed(d, m);
    if (number > most || number < -most) d->is_damaged = 1;
    return number;
}

static void read_slopes(decoder *d, const psplat_stream_section *section, const code *from,
                        double *spent, code *c) {
    const psplat_stream *s = d->stream;
    double along[2][2] = {{0, 0}, {0, 0}};
    for (size_t i = 0; i < 6 && section->has_texcoord_bend; ++i) {
        d->spent = &spent[PSPLAT_TEXCOORD_UU + i / 2];
        number_model *m = &d->models[i / 2 == 1 ? TEXCOORD_TWIST : TEXCOORD_BEND];
        c->texcoords[3 + i / 2][i % 2] = read_near(d, m, 0, MOST_TEXCOORD);
        c->image.bends[i / 2][i % 2] = c->texcoords[3 + i / 2][i % 2] * s->texcoord_bend_step;
    }
    if (from) psplat_stream_texcoord_slopes(&from->image, &c->image, along);
    for (size_t i = 0; i < 4; ++i) {
        d->spent = &spent[PSPLAT_TEXCOORD_U + i / 2];
        double predicted = along[i / 2][i % 2] / s->texcoord_slope_step;
        int32_t number =
            read_near(d, &d->models[TEXCOORD_SLOPE],
                      psplat_stream_texcoord_round(predicted, MOST_TEXCOORD), MOST_TEXCOORD);
        c->texcoords[1 + i / 2][i % 2] = number;
        c->image.along[i / 2][i % 2] = number * s->texcoord_slope_step;
    }
}

static void read_texcoord(decoder *d, const psplat_stream_section *section, const code *from,
                          double *spent, code *c) {
    const psplat_stream *s = d->stream;
    int32_t unit = (int32_t)(1u << s->texcoord_low_bits);
    double move[2] = {0, 0};
    start_field(s, c);
    read_slopes(d, section, from, spent, c);
    if (from) psplat_stream_texcoord_move(&from->image, &c->image, move);
    d->spent = &spent[PSPLAT_TEXCOORD];
    for (int k = 0; k < 2 && !d->is_damaged; ++k) {
        int32_t low = c->coarse[k] * unit - unit / 2;
        int32_t high = unit > 1 ? low + unit - 1 : low;
        int32_t predicted = (from ? from->texcoords[0][k] : 0) +
                            psplat_stream_texcoord_round(move[k] / s->texcoord_step, 1 << 24);
        predicted = predicted < low ? low : predicted > high ? high : predicted;
        c->texcoords[0][k] = read_near(d, &d->models[TEXCOORD], predicted, MOST_TEXCOORD_AT);
    }
}

/* ---- rows ------------------------------------------------------------------------------------ */

/* Decodes an octahedral code as EXT_meshopt_compression's filter does, to bytes for up to 8 bits,
 * else to shorts, and normalises that. */
static void put_normal(const psplat_stream *s, const code *c, float *out) {
    float x = (float)c->normal[0], y = (float)c->normal[1];
    float z = (float)((1 << (s->normal_bits - 1)) - 1) - fabsf(x) - fabsf(y), fold = fminf(z, 0);
    x += x >= 0 ? fold : -fold;
    y += y >= 0 ? fold : -fold;
    float scale = (s->normal_bits <= 8 ? 127.0f : 32767.0f) / sqrtf(x * x + y * y + z * z);
    float v[3] = {x * scale, y * scale, z * scale};
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        v[k] = truncf(v[k] + (v[k] >= 0 ? 0.5f : -0.5f));
        square += (double)v[k] * (double)v[k];
    }
    for (int k = 0; k < 3; ++k) out[k] = (float)((double)v[k] / sqrt(square));
}

static void put_line(const psplat_stream *s, const int32_t *line, int is_bent, float *out) {
    double angle = 3.14159265358979323846 * line[0] / (double)(1u << s->line_turn_bits);
    out[0] = (float)cos(angle);
    out[1] = (float)sin(angle);
    out[2] = (float)(line[1] * s->line_step);
    if (is_bent) out[3] = (float)(line[2] * s->bend_step);
}

static void put_texcoords(const psplat_stream *s, const code *c, float *out) {
    for (int i = 0; i < 12; ++i) {
        double step = i < 2   ? s->texcoord_step
                      : i < 6 ? s->texcoord_slope_step
                              : s->texcoord_bend_step;
        out[i] = (float)(c->texcoords[i / 2][i % 2] * step);
    }
}

/* Returns the place of a line of a splat, which has so many: seams are the last, and what is
 * missing lies before them. */
static uint32_t place_of_line(const psplat_stream_section *section, uint32_t count, uint32_t i) {
    return i + section->seam_lines < count ? i : section->clip_count - count + i;
}

/* Fills a row with what the integers of a splat stand for. */
static void make_row(const psplat_stream *s, const psplat_stream_section *section, const code *c,
                     float row[ROW]) {
    static const float padding[4] = {1, 0, 1, 0};
    int has_own = section->has_own_field || !section->is_curved;
    const int32_t *field = has_own ? c->field : c->shape;
    for (int k = 0; k < 3; ++k) {
        row[AT_POSITION + k] =
            (float)(c->place[k] + (double)c->low[k] / (double)(1u << s->low_bits));
        row[AT_FIELD + k] = (float)(field[k] * (has_own ? s->field_step : s->shape_step));
        row[AT_SHAPE + k] = (float)(c->shape[k] * s->shape_step);
    }
    for (int k = 0; k < 2; ++k) {
        row[AT_SCALE + k] = (float)(s->first_radius * exp(c->radius[k] * s->radius_step));
        row[AT_TILT + k] = (float)(c->tilt[k] * (has_own ? s->tilt_step : s->shape_step));
    }
    row[AT_TURN] = (float)c->turn / (float)(1u << s->turn_bits);
    put_normal(s, c, row + AT_NORMAL);
    if (s->has_texcoord) put_texcoords(s, c, row + AT_TEXCOORD);
    for (uint32_t i = 0; i < section->clip_count; ++i)
        memcpy(row + AT_LINES + 4 * i, padding, sizeof padding);
    for (uint32_t i = 0; i < c->line_count; ++i)
        put_line(s, c->lines[i], section->has_bends,
                 row + AT_LINES + 4 * place_of_line(section, c->line_count, i));
}

static size_t row_bytes(const psplat_stream *s) {
    return s->has_texcoord ? ROW_BYTES : PLAIN_ROW_BYTES;
}

/* Writes floats in the byte order of files. */
static void put_row(const float row[ROW], size_t bytes, uint8_t *out) {
    for (size_t i = 0; i < bytes / 4; ++i) {
        uint32_t bits;
        memcpy(&bits, &row[i], sizeof bits);
        for (int k = 0; k < 4; ++k) *out++ = (uint8_t)(bits >> (8 * k));
    }
}

static void extend(const float row[ROW], double low[3], double high[3]) {
    for (int k = 0; k < 3; ++k) {
        low[k] = fmin(low[k], (double)row[AT_POSITION + k]);
        high[k] = fmax(high[k], (double)row[AT_POSITION + k]);
    }
}

/* Reads what accessors say of a splat. Returns 0 where TEXCOORD_0 is too far away. */
static int read_beside(const psplat_stream *s, const psplat_readers *beside, size_t index,
                       code *c) {
    float place[3], image[2];
    psplat_reader_get(&beside->of[PSPLAT_POSITION], index, 1, place);
    for (int k = 0; k < 3; ++k) c->place[k] = (double)place[k];
    if (!s->has_texcoord) return 1;
    psplat_reader_get(&beside->of[PSPLAT_TEXCOORD], index, 1, image);
    for (int k = 0; k < 2; ++k) {
        double steps = (double)image[k] / s->texcoord_step;
        if (!(fabs(steps) <= MOST_TEXCOORD_AT + 1.0)) return 0;
        c->coarse[k] = (int32_t)floor(steps / (1u << s->texcoord_low_bits) + 0.5);
    }
    return 1;
}

static psplat_result read_splats(psplat_gltf *gltf, const psplat_readers *beside, decoder *d,
                                 uint8_t *out) {
    psplat_stream *s = d->stream;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t section = 0; section < s->section_count; ++section) {
        const psplat_stream_section *kind = &s->sections[section];
        for (size_t i = kind->first; i < kind->first + kind->count; ++i) {
            float row[ROW] = {0};
            code c = {.radius = {0, 0}};
            if (!read_beside(s, beside, i, &c))
                return fail(gltf, s, PSPLAT_ERROR_RANGE, "is beside a TEXCOORD_0 out of range");
            read_frame(d, nearest(d, i, c.place), s->spent[section], &c);
            if (!d->is_damaged) read_field(d, kind, s->spent[section], &c);
            if (!d->is_damaged) read_lines(d, kind, s->spent[section], &c);
            if (!d->is_damaged && s->has_texcoord)
                read_texcoord(d, kind, nearest_in_chart(d, i, &c), s->spent[section], &c);
            if (d->is_damaged || d->missing > 4)
                return fail(gltf, s, PSPLAT_ERROR_FORMAT, "is damaged");
            make_row(s, kind, &c, row);
            put_row(row, row_bytes(s), out + row_bytes(s) * i);
            extend(row, low, high);
            d->window[i % WINDOW] = c;
        }
    }
    for (int k = 0; k < 3; ++k) s->found_extent[k] = high[k] - low[k];
    return PSPLAT_OK;
}

/* ---- streams --------------------------------------------------------------------------------- */

psplat_result psplat_stream_open(psplat_gltf *gltf, psplat_json_value view,
                                 psplat_stream **stream) {
    size_t index = 0, start = 0;
    const psplat_buffer *buffer = NULL;
    if (!gltf->stream) gltf->stream = psplat_arena_take(gltf->scratch, 1, sizeof *gltf->stream);
    if (!gltf->stream)
        return psplat_fail(gltf->error, PSPLAT_ERROR_MEMORY, psplat_gltf_offset(gltf, view),
                           "no memory for a stream");
    psplat_stream *s = *stream = &gltf->stream->stream;
    *s = (psplat_stream){.json = view};
    psplat_result result = psplat_gltf_index(gltf, view, "stream", gltf->view_count, &index);
    if (!result && (gltf->views[index].stride || gltf->views[index].compression))
        return fail(gltf, s, PSPLAT_ERROR_FORMAT,
                    "is in a bufferView with a byteStride or a compression");
    if (!result) result = psplat_view_load(gltf, &gltf->views[index], "stream", &buffer, &start);
    if (result) return result;
    s->bytes = buffer->data + start;
    s->size = gltf->views[index].length;
    result = parse_head(gltf, s);
    return result ? result : parse_sections(gltf, s);
}

/* Returns whether nothing is behind the last splat but zeros that make up LEAST_BYTES a splat, or
 * align what follows. More are not even looked at: primitives may share a stream. */
static int ends(const decoder *d) {
    size_t rest = (size_t)(d->end - d->next);
    if (rest > MOST_ALIGNING && d->stream->size / LEAST_BYTES > d->stream->count + 1) return 0;
    for (size_t i = 0; i < rest; ++i)
        if (d->next[i]) return 0;
    return 1;
}

/* Takes memory for the rows. Several primitives may share a stream, but not so often that they fill
 * the memory. */
static psplat_result reserve(psplat_gltf *gltf, psplat_stream *s) {
    struct psplat_stream_memory *memory = gltf->stream;
    if (s->count > gltf->file_budget / row_bytes(s))
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "is decoded larger than allowed");
    size_t bytes = s->count * row_bytes(s);
    if (psplat_gltf_decodes_too_much(gltf, bytes))
        return fail(gltf, s, PSPLAT_ERROR_RANGE, "uses the file's bytes too many times over");
    if (bytes > memory->capacity) {
        memory->rows = psplat_arena_reserve(gltf->scratch, s->count, row_bytes(s));
        memory->capacity = memory->rows ? bytes : 0;
    }
    if (!memory->rows) return fail(gltf, s, PSPLAT_ERROR_MEMORY, "leaves no memory to decode it");
    s->decoded = (psplat_buffer){.json = s->json,
                                 .length = bytes,
                                 .data = memory->rows,
                                 .origin = psplat_gltf_offset(gltf, s->json),
                                 .is_decoded = 1};
    gltf->file_budget -= bytes;
    gltf->loaded_bytes += bytes;
    gltf->decoded_bytes += bytes;
    return PSPLAT_OK;
}

psplat_result psplat_stream_decode(psplat_gltf *gltf, const psplat_readers *beside,
                                   psplat_stream *s) {
    psplat_result result = reserve(gltf, s);
    if (result) return result;
    decoder *d = &gltf->stream->decoder;
    *d = (decoder){.stream = s,
                   .next = s->bytes + s->head_size + SECTION_BYTES * s->section_count,
                   .end = s->bytes + s->size,
                   .measures = gltf->measures};
    start(d);
    result = read_splats(gltf, beside, d, gltf->stream->rows);
    return result || ends(d) ? result
                             : fail(gltf, s, PSPLAT_ERROR_FORMAT, "has bytes behind its splats");
}

/* ---- readers --------------------------------------------------------------------------------- */

int psplat_stream_holds(const psplat_stream *s, size_t attribute) {
    return attribute == PSPLAT_NORMAL ||
           (attribute >= PSPLAT_ROTATION && attribute < PSPLAT_COLOR_U) ||
           (s->has_texcoord && attribute >= PSPLAT_TEXCOORD_U && attribute <= PSPLAT_TEXCOORD_VV);
}

/* Adds a reader of an attribute that lies so many floats behind the begin of each row. */
static void add_reader(const psplat_stream *s, size_t section, size_t attribute, size_t at,
                       size_t components, psplat_readers *readers) {
    readers->is_present[attribute] = 1;
    readers->of[attribute] =
        (psplat_reader){.buffer = &s->decoded,
                        .start = s->sections[section].first * row_bytes(s) + at * sizeof(float),
                        .stride = row_bytes(s),
                        .components = components,
                        .component_type = PSPLAT_FLOAT,
                        .count = s->sections[section].count,
                        .is_streamed = 1,
                        .streamed = (size_t)(s->spent[section][attribute] / 8 + 0.5)};
}

void psplat_stream_readers(const psplat_stream *s, size_t section, psplat_readers *readers) {
    const psplat_stream_section *kind = &s->sections[section];
    size_t coarse = psplat_reader_stored(&readers->of[PSPLAT_POSITION]);
    add_reader(s, section, PSPLAT_POSITION, AT_POSITION, 3, readers);
    readers->of[PSPLAT_POSITION].streamed += coarse;
    add_reader(s, section, PSPLAT_NORMAL, AT_NORMAL, 3, readers);
    add_reader(s, section, PSPLAT_TURN, AT_TURN, 1, readers);
    add_reader(s, section, PSPLAT_SCALE, AT_SCALE, 2, readers);
    if (kind->has_tilt) add_reader(s, section, PSPLAT_TILT, AT_TILT, 2, readers);
    if (kind->has_own_field || kind->is_curved)
        add_reader(s, section, PSPLAT_NORMAL_FIELD, AT_FIELD, kind->has_gamma ? 3 : 2, readers);
    if (kind->has_own_field && kind->is_curved)
        add_reader(s, section, PSPLAT_SHAPE, AT_SHAPE, 3, readers);
    if (s->has_texcoord) {
        size_t image = psplat_reader_stored(&readers->of[PSPLAT_TEXCOORD]);
        for (size_t i = 0; i < (kind->has_texcoord_bend ? 6 : 3); ++i)
            add_reader(s, section, PSPLAT_TEXCOORD + i, AT_TEXCOORD + 2 * i, 2, readers);
        readers->of[PSPLAT_TEXCOORD].streamed += image;
    }
    for (size_t i = 0; i < kind->clip_count; ++i)
        add_reader(s, section, PSPLAT_FIRST_CLIP + i, AT_LINES + 4 * i, kind->has_bends ? 4 : 3,
                   readers);
}
