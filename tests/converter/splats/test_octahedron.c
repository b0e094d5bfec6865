/* SPDX-License-Identifier: MIT
 *
 * test_octahedron.c - tests of octahedral unit vectors in two integers (Meyer et al. 2010): the
 * error of what comes back, and the edges where the octahedron is folded. Expected values are
 * bounds derived from the lattice, a search over neighbouring codes, and the decoder of the
 * meshoptimizer library.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <math.h>
#include <cmocka.h>

#include "base/vector.h"
#include "splats/octahedron.h"
#include "scene_asset.h"

#include <meshoptimizer.h>

static int32_t greatest(int bits) {
    return (1 << (bits - 1)) - 1;
}

/* Returns the angle in radians between a vector and its stored form. */
static double error_of(const double normal[3], int bits) {
    int32_t code[2] = {INT32_MAX, INT32_MAX};
    double found[3];
    psplat_octahedron_encode(normal, bits, code);
    assert_true(psplat_octahedron_is_code(code, bits));
    psplat_octahedron_normal(code, bits, found);
    assert_true(fabs(dot3(found, found) - 1) < 1e-12); /* a dozen roundings of double */
    return 2 * asin(fmin(sqrt(distance2_3(found, normal)) / 2, 1));
}

/* Returns the greatest error in radians. On a face of the octahedron the codes form a hexagonal
 * lattice of spacing sqrt(2) / greatest, so that no point is farther than 1 / sqrt(3) of that from
 * a code. The angle is largest in the middle of the face, which is 1 / sqrt(3) from the centre.
 * Rounding to bytes or shorts adds half a step of each component. Where a code is left out, as some
 * codes of bytes are, its neighbours are one spacing away. */
static double bound_of(int bits) {
    return (bits <= 8 ? sqrt(6) : sqrt(2)) / greatest(bits) +
           sqrt(3) / 2 / (bits <= 8 ? 127 : 32767);
}

static void test_error(void **state) {
    (void)state;
    uint32_t random = 7;
    for (int bits = PSPLAT_OCTAHEDRON_LEAST_BITS; bits <= PSPLAT_OCTAHEDRON_MOST_BITS; ++bits) {
        double worst = 0;
        for (int i = 0; i < 4000; ++i) {
            double n[3];
            for (int k = 0; k < 3; ++k) n[k] = (double)scene_random(&random) - 0.5;
            normalize3(n);
            worst = fmax(worst, error_of(n, bits));
        }
        if (!(worst <= bound_of(bits))) fail_msg("%d bits: %g of %g", bits, worst, bound_of(bits));
        /* The bound is not far above the errors that occur. */
        assert_true(worst > 0.4 * bound_of(bits));
    }
}

/* The six poles are stored exactly, also with negative zeros. */
static void test_poles(void **state) {
    (void)state;
    for (int bits = PSPLAT_OCTAHEDRON_LEAST_BITS; bits <= PSPLAT_OCTAHEDRON_MOST_BITS; ++bits)
        for (int i = 0; i < 24; ++i) {
            double n[3] = {i & 1 ? -0.0 : 0.0, i & 1 ? -0.0 : 0.0, i & 1 ? -0.0 : 0.0};
            if (i & 2) n[(i / 4 + 1) % 3] = -n[(i / 4 + 1) % 3];
            n[i / 4 % 3] = i >= 12 ? -1 : 1;
            assert_true(error_of(n, bits) == 0);
        }
}

/* Vectors lie along the edges where the lower half is folded up (z = 0), and along those between
 * faces. */
static void test_folds(void **state) {
    (void)state;
    static const double tiny[] = {0, -0.0, 1e-17, -1e-17, 1e-9, -1e-9, 1e-4, -1e-4};
    for (int bits = PSPLAT_OCTAHEDRON_LEAST_BITS; bits <= PSPLAT_OCTAHEDRON_MOST_BITS; bits += 2)
        for (int i = 0; i < 360; ++i)
            for (size_t t = 0; t < sizeof tiny / sizeof *tiny; ++t)
                for (int axis = 0; axis < 3; ++axis) {
                    double angle = i * 3.141592653589793 / 180, n[3];
                    n[axis] = tiny[t];
                    n[(axis + 1) % 3] = cos(angle);
                    n[(axis + 2) % 3] = sin(angle);
                    normalize3(n);
                    assert_true(error_of(n, bits) <= bound_of(bits));
                }
}

/* Every code decodes to a vector whose own code decodes alike. That may be another code, because
 * the four corners are all -z, and bytes may be too coarse to tell two codes apart. */
static void test_every_code(void **state) {
    (void)state;
    for (int bits = PSPLAT_OCTAHEDRON_LEAST_BITS; bits <= 9; ++bits)
        for (int32_t x = -greatest(bits); x <= greatest(bits); ++x)
            for (int32_t y = -greatest(bits); y <= greatest(bits); ++y) {
                const int32_t code[2] = {x, y};
                int32_t again[2], first[3], second[3];
                double n[3];
                if (!psplat_octahedron_is_code(code, bits)) continue;
                psplat_octahedron_normal(code, bits, n);
                psplat_octahedron_encode(n, bits, again);
                psplat_octahedron_decode(code, bits, first);
                psplat_octahedron_decode(again, bits, second);
                assert_memory_equal(first, second, sizeof first);
            }
}

/* No code within three steps decodes to a nearer vector. */
static void test_nearest(void **state) {
    (void)state;
    uint32_t random = 3;
    for (int i = 0; i < 2000; ++i) {
        int bits = PSPLAT_OCTAHEDRON_LEAST_BITS + i % 11;
        double n[3], found[3];
        int32_t code[2];
        for (int k = 0; k < 3; ++k) n[k] = (double)scene_random(&random) - 0.5;
        normalize3(n);
        psplat_octahedron_encode(n, bits, code);
        psplat_octahedron_normal(code, bits, found);
        double distance2 = distance2_3(found, n);
        for (int32_t x = -3; x <= 3; ++x)
            for (int32_t y = -3; y <= 3; ++y) {
                const int32_t other[2] = {code[0] + x, code[1] + y};
                if (!psplat_octahedron_is_code(other, bits)) continue;
                psplat_octahedron_normal(other, bits, found);
                assert_true(distance2_3(found, n) >= distance2);
            }
    }
}

/* The library decodes the filter of EXT_meshopt_compression with other instructions: bytes must be
 * equal; of shorts, which may lie almost halfway between two values, at most one in a hundred may
 * be one step off. */
static void test_filter(void **state) {
    (void)state;
    for (int bits = PSPLAT_OCTAHEDRON_LEAST_BITS; bits <= PSPLAT_OCTAHEDRON_MOST_BITS; ++bits) {
        size_t off = 0, count = 0;
        int32_t step = bits <= 9 ? 1 : bits == 14 ? 61 : 17, most = greatest(bits);
        for (int32_t x = -most; x <= most; x += step)
            for (int32_t y = -most; y <= most; y += 4 * step, ++count) {
                const int32_t code[2] = {x, y};
                int32_t expected[3];
                if (!psplat_octahedron_is_code(code, bits)) continue;
                /* The library takes four vectors at a time. */
                int8_t bytes[4][4];
                int16_t shorts[4][4];
                for (int i = 0; i < 4; ++i)
                    for (int k = 0; k < 4; ++k) {
                        const int32_t stored[4] = {x, y, most, 0};
                        shorts[i][k] = (int16_t)stored[k];
                        if (bits <= 8) bytes[i][k] = (int8_t)stored[k];
                    }
                if (bits <= 8)
                    meshopt_decodeFilterOct(bytes, 4, 4);
                else
                    meshopt_decodeFilterOct(shorts, 4, 8);
                psplat_octahedron_decode(code, bits, expected);
                for (int k = 0; k < 3; ++k) {
                    int32_t found = bits <= 8 ? bytes[0][k] : shorts[0][k];
                    assert_in_range(found - expected[k] + 1, 0, 2);
                    if (bits <= 8) assert_int_equal(found, expected[k]);
                    off += found != expected[k];
                }
            }
        assert_true(off * 100 <= count);
    }
}

int test_octahedron_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_error),   cmocka_unit_test(test_poles),
        cmocka_unit_test(test_folds),   cmocka_unit_test(test_every_code),
        cmocka_unit_test(test_nearest), cmocka_unit_test(test_filter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
