/* SPDX-License-Identifier: MIT
 *
 * test_splat_stream.c - tests the encoder of streams at its limits: no splat, one splat, the
 * largest and smallest integers that there are and those between in one stream. A decoder that was
 * written after the specification (3.12), without grades, reads all integers back.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "export/splat_order.h"
#include "export/splat_stream.h"
#include "scene_asset.h"
#include "splats/splats.h"

#include <stdlib.h>
#include <string.h>

enum { HEAD = 60, SECTION = 12, KINDS = 12, FARTHEST = 32, MOST = 600 };
enum { CURVED = 1, OWN_FIELD = 2, BENDS = 4, TILTED = 8, GAMMA = 16 };

/* ---- a decoder of the specification ---------------------------------------------------------- */

typedef struct probability {
    uint32_t p, n;
} probability;

typedef struct kind {
    probability z, s, u[17], h[17];
} kind;

typedef struct decoder {
    const uint8_t *at, *end;
    uint32_t range, value;
    kind kinds[KINDS + 1]; /* from 1, as in the specification */
} decoder;

static uint32_t next_byte(decoder *d) {
    return d->at < d->end ? *d->at++ : 0;
}

static decoder decoder_of(const uint8_t *bytes, const uint8_t *end) {
    decoder d = {.at = bytes, .end = end, .range = UINT32_MAX};
    for (int i = 0; i < 4; ++i) d.value = d.value << 8 | next_byte(&d);
    for (int i = 1; i <= KINDS; ++i) {
        kind *k = &d.kinds[i];
        k->z.p = k->s.p = 32768;
        for (int j = 0; j < 17; ++j) k->u[j].p = k->h[j].p = 32768;
    }
    return d;
}

static int read_bound(decoder *d, uint32_t bound) {
    int bit = d->value < bound;
    if (!bit) d->value -= bound;
    d->range = bit ? bound : d->range - bound;
    while (d->range < 1u << 24) {
        d->range <<= 8;
        d->value = d->value << 8 | next_byte(d);
    }
    return bit;
}

static int32_t read_raw(decoder *d, uint32_t bits) {
    uint32_t value = 0;
    while (bits--) value = 2 * value + (uint32_t)read_bound(d, d->range / 2);
    return (int32_t)value;
}

static int read_bit(decoder *d, probability *p) {
    int bit = read_bound(d, d->range / 65536 * p->p);
    uint32_t n = p->n < 40 ? p->n : 40, r = 131072 / (2 * n + 3);
    p->p = bit ? p->p + (65536 - p->p) * r / 65536 : p->p - p->p * r / 65536;
    p->p = p->p < 32 ? 32 : p->p > 65504 ? 65504 : p->p;
    ++p->n;
    return bit;
}

static int32_t read_unsigned(decoder *d, int number) {
    kind *k = &d->kinds[number];
    uint32_t length = 0, highest = 1;
    while (length < 17 && read_bit(d, &k->u[length])) ++length;
    assert_true(length < 17); /* u_17 is not */
    if (length) highest = 2 + (uint32_t)read_bit(d, &k->h[length]);
    if (length < 2) return (int32_t)highest - 1;
    return (int32_t)(highest << (length - 1)) + read_raw(d, length - 1) - 1;
}

static int32_t read_signed(decoder *d, int number) {
    if (!read_bit(d, &d->kinds[number].z)) return 0;
    int is_negative = read_bit(d, &d->kinds[number].s);
    int32_t magnitude = read_unsigned(d, number) + 1;
    return is_negative ? -magnitude : magnitude;
}

/* ---- tables ---------------------------------------------------------------------------------- */

/* A table of integers, which are not those of any surface. */
typedef struct made {
    psplat_splats splats;
    psplat_splat list[MOST];
    psplat_quantized_splat codes[MOST];
    uint32_t order[MOST];
    psplat_attribute_table table;
    psplat_section section;
} made;

/* Integers between `least` and `most`; every other one is one of these two. */
static int32_t extreme(uint32_t *random, int32_t least, int32_t most) {
    double x = (double)scene_random(random), end = (double)scene_random(random);
    if (end < 0.5) return end < 0.25 ? least : most;
    return least + (int32_t)(x * ((double)most - least));
}

/* Fills a splat with the greatest range of each integer: 16 bits of positions, radii and what
 * attributes hold, 14 of normals and turns. */
static void fill(made *m, size_t i, uint32_t *random, int lines) {
    const int32_t normal = (1 << 13) - 1, half_turn = 1 << 14;
    psplat_quantized_splat *code = &m->codes[i];
    for (int k = 0; k < 3; ++k) {
        code->position[k] = extreme(random, 0, 65535);
        code->field[k] = extreme(random, -65535, 65535);
        code->shape[k] = extreme(random, -65535, 65535);
    }
    for (int k = 0; k < 2; ++k) {
        code->normal[k] = extreme(random, -normal, normal);
        code->tilt[k] = code->shape_tilt[k] = extreme(random, -65535, 65535);
    }
    code->scale[0] = extreme(random, 0, 65535);
    code->scale[1] = extreme(random, 0, code->scale[0]);
    code->turn = extreme(random, 0, half_turn - 1);
    m->list[i].clip_count = (uint32_t)lines;
    for (int k = 0; k < lines; ++k) {
        code->lines[k][0] = (half_turn / 2) * k + extreme(random, 0, half_turn / 2 - 1);
        code->lines[k][1] = extreme(random, -65535, 65535);
        code->lines[k][2] = extreme(random, -65535, 65535);
    }
    m->order[i] = (uint32_t)i;
}

/* Makes so many splats, all with so many lines. The caller frees them. */
static made *make(size_t count, int lines, int is_curved, uint32_t seed) {
    made *m = calloc(1, sizeof *m);
    assert_non_null(m);
    for (size_t i = 0; i < count; ++i) fill(m, i, &seed, lines);
    m->splats = (psplat_splats){
        .splats = m->list,
        .count = count,
        .kernel = {4, 2},
        .precision = {.unit = 1,
                      .scale_step = 0.001,
                      .turn_step = 1.0 / (1 << 14),
                      .line_turn_step = 1.0 / (1 << 14),
                      .tilt_step = 1,
                      .field_step = 1,
                      .shape_step = 1,
                      .line_step = 1,
                      .bend_step = 1,
                      .normal_bits = 14},
    };
    m->table = (psplat_attribute_table){.splats = &m->splats, .codes = m->codes};
    m->section = (psplat_section){.order = m->order,
                                  .count = count,
                                  .clip_lines = (size_t)lines,
                                  .is_curved = is_curved,
                                  .has_shape = is_curved};
    return m;
}

/* Returns the stream of all splats, which the caller frees. */
static uint8_t *encode(const made *m, uint32_t low_bits, size_t *size) {
    const psplat_stream_desc how = {.low_bits = low_bits};
    int is_safe = 0;
    uint8_t *bytes = psplat_stream_encode(&m->table, &m->section, 1, &how, size, &is_safe);
    assert_non_null(bytes);
    assert_true(is_safe);
    return bytes;
}

/* ---- reading back ---------------------------------------------------------------------------- */

/* Returns the coarse positions' nearest of the last splats in the order, or NULL for the first. */
static const psplat_quantized_splat *nearest(const made *m, size_t at, uint32_t low_bits) {
    const psplat_quantized_splat *found = NULL;
    int64_t least = INT64_MAX;
    for (size_t i = 1; i <= at && i <= FARTHEST; ++i) {
        int64_t distance2 = 0;
        for (int k = 0; k < 3; ++k) {
            int64_t apart =
                psplat_stream_coarse_position(&m->table, m->order[at], k, low_bits) -
                (int64_t)psplat_stream_coarse_position(&m->table, m->order[at - i], k, low_bits);
            distance2 += apart * apart;
        }
        if (distance2 < least) found = &m->codes[m->order[at - i]];
        if (distance2 < least) least = distance2;
    }
    return found;
}

static void check_splat(decoder *d, const made *m, size_t at, unsigned flags, uint32_t low_bits) {
    static const psplat_quantized_splat zero;
    const psplat_quantized_splat *code = &m->codes[m->order[at]], *p = nearest(m, at, low_bits);
    if (!p) p = &zero;
    for (int k = 0; k < 3; ++k) {
        int32_t coarse = psplat_stream_coarse_position(&m->table, m->order[at], k, low_bits);
        int32_t low = read_raw(d, low_bits) - (1 << low_bits) / 2;
        assert_int_equal(coarse * (1 << low_bits) + low, code->position[k]);
    }
    int32_t radius = read_signed(d, 1) + p->scale[0];
    assert_int_equal(radius, code->scale[0]);
    assert_int_equal(radius - read_unsigned(d, 2), code->scale[1]);
    for (int k = 0; k < 2; ++k) assert_int_equal(read_signed(d, 3) + p->normal[k], code->normal[k]);
    assert_int_equal(read_raw(d, 14), code->turn);
    for (int k = 0; k < 2 && flags & TILTED; ++k)
        assert_int_equal(read_signed(d, 4), code->tilt[k]);
    for (int k = 0; k < (flags & GAMMA ? 3 : 2) && flags & OWN_FIELD; ++k)
        assert_int_equal(read_signed(d, k < 2 ? 5 : 6), code->field[k]);
    for (int k = 0; k < 3 && flags & CURVED; ++k)
        assert_int_equal(read_signed(d, k < 2 ? 7 : 8), code->shape[k]);
    if (!m->section.clip_lines) return;
    int32_t count = read_unsigned(d, 9), turn = 0;
    assert_int_equal(count, m->list[m->order[at]].clip_count);
    for (int32_t k = 0; k < count; ++k) {
        turn = k ? turn + read_unsigned(d, 10) : read_raw(d, 15);
        assert_int_equal(turn, code->lines[k][0]); /* they are made in the order of their turns */
        assert_int_equal(read_signed(d, 11), code->lines[k][1]);
        if (flags & BENDS) assert_int_equal(read_signed(d, 12), code->lines[k][2]);
    }
}

/* Encodes and reads back. Returns the bytes of the stream. */
static size_t check(const made *m, uint32_t low_bits) {
    size_t size = 0, count = m->section.count;
    assert_true(psplat_stream_can_hold(&m->table));
    uint8_t *bytes = encode(m, low_bits, &size);
    assert_true(size >= HEAD + SECTION && size >= 3 * count);
    assert_int_equal(bytes[1], low_bits);
    assert_int_equal(bytes[HEAD] | bytes[HEAD + 1] << 8, count);
    unsigned flags = bytes[HEAD + 9];
    assert_int_equal(flags & CURVED, m->section.is_curved);
    decoder d = decoder_of(bytes + HEAD + SECTION, bytes + size);
    for (size_t i = 0; i < count; ++i) check_splat(&d, m, i, flags, low_bits);
    free(bytes);
    return size;
}

/* ---- tests ----------------------------------------------------------------------------------- */

/* No splat: the head and the section alone, whose extent is 0, though readers refuse it. */
static void test_no_splat(void **state) {
    (void)state;
    made *m = make(0, 4, 1, 1);
    size_t size = 0;
    assert_true(psplat_order_along_curve(&m->table, m->section.order, m->section.count));
    uint8_t *bytes = encode(m, 0, &size);
    assert_in_range(size, HEAD + SECTION, HEAD + SECTION + 5);
    for (size_t i = 20; i < 32; ++i) assert_int_equal(bytes[i], 0);
    free(bytes);
    free(m);
}

static void test_one_splat(void **state) {
    (void)state;
    for (uint32_t seed = 1; seed < 40; ++seed)
        for (int lines = 0; lines <= 4; lines += 4) {
            made *m = make(1, lines, seed % 2, seed);
            assert_true(psplat_order_along_curve(&m->table, m->section.order, m->section.count));
            check(m, seed % 9);
            free(m);
        }
}

/* One splat of zeros takes the fewest bytes that a stream may have. */
static void test_zeros(void **state) {
    (void)state;
    made *m = make(1, 0, 0, 1);
    memset(m->codes, 0, sizeof m->codes);
    assert_in_range(check(m, 0), HEAD + SECTION + 1, HEAD + SECTION + 6);
    free(m);
    m = make(MOST, 0, 0, 1);
    memset(m->codes, 0, sizeof m->codes);
    assert_int_equal(check(m, 0), 3 * MOST); /* filled up */
    free(m);
}

/* The largest values beside the smallest: differences of twice the range, in either direction. */
static void test_extremes(void **state) {
    (void)state;
    for (uint32_t low_bits = 0; low_bits <= PSPLAT_MOST_LOW_BITS; low_bits += 4)
        for (int is_curved = 0; is_curved < 2; ++is_curved) {
            made *m = make(MOST, 4, is_curved, 7 + low_bits);
            assert_true(psplat_order_along_curve(&m->table, m->section.order, m->section.count));
            check(m, low_bits);
            free(m);
        }
}

/* Steps of turns that are no power of two do not fit into a stream, and neither do floats. */
static void test_cannot_hold(void **state) {
    (void)state;
    made *m = make(1, 0, 0, 1);
    const double steps[] = {1, 1.0 / 3, 1.0 / (1 << 15), 0};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i) {
        m->splats.precision.turn_step = steps[i];
        assert_false(psplat_stream_can_hold(&m->table));
    }
    m->splats.precision.turn_step = 0.5;
    assert_true(psplat_stream_can_hold(&m->table));
    m->splats.precision.line_turn_step = 0.3;
    assert_false(psplat_stream_can_hold(&m->table));
    m->splats.precision.line_turn_step = 0.5;
    m->table.codes = NULL;
    assert_false(psplat_stream_can_hold(&m->table));
    free(m);
}

int test_splat_stream_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_splat),    cmocka_unit_test(test_one_splat),
        cmocka_unit_test(test_zeros),       cmocka_unit_test(test_extremes),
        cmocka_unit_test(test_cannot_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
