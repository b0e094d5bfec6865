/* SPDX-License-Identifier: MIT
 *
 * test_splat_order.c - tests the orders of splats: each index comes once, the same whatever order
 * they had before, and rows in the shorter order compress better by the codec that files are for.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "base/random.h"
#include "export/meshopt_codec.h"
#include "export/splat_order.h"
#include "export/splat_stream.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 3000, STRIDE = 4 };

typedef struct made {
    psplat_splats splats;
    psplat_quantized_splat codes[MOST];
    psplat_attribute_table table;
    uint32_t order[MOST];
    size_t count;
} made;

/* Makes splats on a sphere that is so many steps wide. */
static made *make_sphere(size_t count, int steps, uint64_t seed) {
    made *m = calloc(1, sizeof *m);
    assert_non_null(m);
    m->table.splats = &m->splats;
    m->table.codes = m->codes;
    m->splats.precision.normal_bits = 9;
    m->count = count;
    for (size_t i = 0; i < count; ++i) {
        double z = 2 * psplat_random_unit(&seed) - 1, turn = 6.2831853 * psplat_random_unit(&seed);
        const double n[3] = {sqrt(1 - z * z) * cos(turn), sqrt(1 - z * z) * sin(turn), z};
        for (int k = 0; k < 3; ++k)
            m->codes[i].position[k] = (int32_t)lrint((1 + n[k]) / 2 * steps);
        /* Near enough to an octahedral code: what is alike is near. */
        for (int k = 0; k < 2; ++k) m->codes[i].normal[k] = (int32_t)lrint(255 * n[k]);
        m->order[i] = (uint32_t)i;
    }
    return m;
}

static void shuffle(made *m, uint64_t seed) {
    for (size_t i = m->count; i > 1; --i) {
        size_t other = psplat_random_next(&seed) % i;
        uint32_t index = m->order[i - 1];
        m->order[i - 1] = m->order[other];
        m->order[other] = index;
    }
}

/* Checks that each index comes once. */
static void check_order(const made *m) {
    uint8_t seen[MOST] = {0};
    for (size_t i = 0; i < m->count; ++i) {
        assert_in_range(m->order[i], 0, m->count - 1);
        assert_false(seen[m->order[i]]++);
    }
}

static void sort_curve(made *m) {
    assert_true(psplat_order_along_curve(&m->table, m->order, m->count));
    check_order(m);
}

static void sort_shorter(made *m, uint32_t low_bits, int texcoords) {
    sort_curve(m);
    assert_true(psplat_order_shorten(&m->table, low_bits, texcoords, m->order, m->count));
    check_order(m);
}

/* Returns how many bytes the positions take as a file has them. */
static size_t compressed(const made *m, uint32_t low_bits) {
    uint8_t *rows = calloc(m->count, STRIDE);
    size_t bound = psplat_meshopt_codec.bound(m->count, STRIDE);
    uint8_t *packed = malloc(bound);
    assert_true(rows && packed);
    for (size_t i = 0; i < m->count; ++i)
        for (int k = 0; k < 3; ++k)
            rows[STRIDE * i + (size_t)k] =
                (uint8_t)psplat_stream_coarse_position(&m->table, m->order[i], k, low_bits);
    size_t size = psplat_meshopt_codec.encode(packed, bound, rows, m->count, STRIDE);
    assert_true(size > 0);
    free(rows);
    free(packed);
    return size;
}

/* Positions take at least 17 % less than along the curve, where splats are as far apart as files
 * have them: 5 to 15 steps of a byte. On single spheres it is 16 to 19 %. */
static void test_takes_fewer_bytes(void **state) {
    (void)state;
    const struct {
        size_t count;
        int steps;
        uint32_t low_bits;
    } cases[] = {{280, 88, 0}, {280, 704, 3}, {700, 110, 0}, {3000, 200, 0}, {3000, 400, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        size_t before = 0, after = 0;
        for (uint64_t seed = 1; seed <= 3; ++seed) {
            made *m = make_sphere(cases[i].count, cases[i].steps, seed);
            sort_curve(m);
            before += compressed(m, cases[i].low_bits);
            sort_shorter(m, cases[i].low_bits, 0);
            after += compressed(m, cases[i].low_bits);
            free(m);
        }
        print_message("%zu splats, %d steps: %zu bytes, %zu along the curve\n", cases[i].count,
                      cases[i].steps, after, before);
        assert_in_range(after, 1, before * 83 / 100);
    }
}

/* Neighbours of an order along the curve are near: on average, 1.28 times the distance at which so
 * many splats lie. Along a Morton curve they are 1.48 times as far. */
static void test_curve_keeps_neighbors(void **state) {
    (void)state;
    made *m = make_sphere(MOST, 4000, 5);
    double sum = 0, spacing = 4000 * sqrt(3.14159265 / MOST);
    shuffle(m, 3);
    sort_curve(m);
    for (size_t i = 1; i < m->count; ++i) {
        const int32_t *a = m->codes[m->order[i - 1]].position, *b = m->codes[m->order[i]].position;
        sum += sqrt((double)(a[0] - b[0]) * (a[0] - b[0]) + (double)(a[1] - b[1]) * (a[1] - b[1]) +
                    (double)(a[2] - b[2]) * (a[2] - b[2]));
    }
    assert_true(sum / (MOST - 1) < 1.38 * spacing);
    free(m);
}

/* No order but that of the splats themselves decides, also where positions are alike. */
static void test_depends_on_splats_alone(void **state) {
    (void)state;
    made *m = make_sphere(900, 20, 4);
    uint32_t first[MOST];
    sort_shorter(m, 0, 0);
    memcpy(first, m->order, sizeof first);
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        shuffle(m, seed);
        sort_shorter(m, 0, 0);
        assert_memory_equal(m->order, first, m->count * sizeof *first);
    }
    free(m);
}

/* Where positions tell nothing, those whose texture coordinates or normals are alike follow each
 * other: of two kinds that come in turns, the other kind follows once. */
static void test_brings_together_what_is_alike(void **state) {
    (void)state;
    for (int by_texcoords = 0; by_texcoords < 2; ++by_texcoords) {
        made *m = make_sphere(100, 0, 1);
        int changes = 0;
        for (size_t i = 0; i < m->count; ++i) {
            memset(m->codes[i].normal, 0, sizeof m->codes[i].normal);
            if (by_texcoords)
                m->codes[i].texcoord.at[1] = i % 2 ? 90 : 10;
            else
                m->codes[i].normal[0] = i % 2 ? 200 : -200;
        }
        m->splats.precision.texcoord_step = 1.0 / 64;
        sort_shorter(m, 0, by_texcoords);
        for (size_t i = 1; i < m->count; ++i) changes += m->order[i] % 2 != m->order[i - 1] % 2;
        assert_int_equal(changes, 1);
        free(m);
    }
}

/* None, one, few and equal splats. */
static void test_few_splats(void **state) {
    (void)state;
    for (size_t count = 0; count <= 6; ++count)
        for (int steps = 0; steps <= 60000; steps += 30000) {
            made *m = make_sphere(count, steps, 9 + count);
            sort_shorter(m, 0, 1);
            free(m);
        }
}

int test_splat_order_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_takes_fewer_bytes),
        cmocka_unit_test(test_curve_keeps_neighbors),
        cmocka_unit_test(test_depends_on_splats_alone),
        cmocka_unit_test(test_brings_together_what_is_alike),
        cmocka_unit_test(test_few_splats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
