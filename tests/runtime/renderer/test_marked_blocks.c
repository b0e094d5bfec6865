/* SPDX-License-Identifier: MIT
 *
 * test_marked_blocks.c - tests that the rectangles that are taken of marked blocks hold each marked
 * pixel once, no other block, and nothing outside the extent; and that the spheres that mark blocks
 * hold the splats.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "asset/pack.h"
#include "renderer/marked_blocks.h"
#include "scene_asset.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_SIDE = 700 };

static uint32_t seed = 5u;

static int below(int end) {
    return (int)((float)end * scene_random(&seed) * 0.99999f);
}

static psplat_screen_extent random_rectangle(int width, int height) {
    psplat_screen_extent e = {below(width), 0, below(height), 0};
    e.x1 = e.x0 + 1 + below(width - e.x0 < 150 ? width - e.x0 : 150);
    e.y1 = e.y0 + 1 + below(height - e.y0 < 150 ? height - e.y0 : 150);
    return e;
}

/* Draws rectangles and what is taken of their blocks, pixel by pixel. Returns the number taken. */
static int compare(int width, int height, int count) {
    static unsigned char wanted[MAX_SIDE * MAX_SIDE], taken[MAX_SIDE * MAX_SIDE];
    memset(wanted, 0, sizeof wanted);
    memset(taken, 0, sizeof taken);
    psplat_screen_extent all = {0, 0, 0, 0}, e;
    psplat_marked_blocks blocks;
    psplat_marked_blocks_clear(&blocks, width, height);
    for (int i = 0; i < count; ++i) {
        e = random_rectangle(width, height);
        psplat_screen_extent_join(&all, &e);
        psplat_marked_blocks_add(&blocks, &e);
        int size = blocks.size, x1 = (e.x1 + size - 1) / size * size;
        int y1 = (e.y1 + size - 1) / size * size;
        for (int y = e.y0 / size * size; y < y1 && y < height; ++y)
            for (int x = e.x0 / size * size; x < x1 && x < width; ++x) wanted[y * MAX_SIDE + x] = 1;
    }
    int rectangles = 0;
    for (;; ++rectangles) {
        e = psplat_marked_blocks_take(&blocks, &all);
        if (!(e.x0 < e.x1)) break;
        assert_true(e.y0 < e.y1);
        for (int y = e.y0; y < e.y1; ++y)
            for (int x = e.x0; x < e.x1; ++x) ++taken[y * MAX_SIDE + x];
    }
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            int is_inside = x >= all.x0 && x < all.x1 && y >= all.y0 && y < all.y1;
            assert_int_equal(taken[y * MAX_SIDE + x], is_inside && wanted[y * MAX_SIDE + x]);
        }
    return rectangles;
}

static void test_rectangles(void **state) {
    (void)state;
    for (int round = 0; round < 200; ++round) {
        int count = 1 + round % 12;
        compare(1 + below(MAX_SIDE), 1 + below(MAX_SIDE), count);
        assert_true(compare(MAX_SIDE, 300, 1) == 1); /* a rectangle stays one */
    }
}

/* No extent marks no block, and views of any size have blocks for all their pixels. */
static void test_sizes(void **state) {
    (void)state;
    const psplat_screen_extent none = {0, 0, 0, 0};
    psplat_marked_blocks blocks;
    for (int side = 1; side <= 32768; side = 2 * side + 1) {
        const psplat_screen_extent whole = {0, side, 0, 1}, last = {side - 1, side, 0, 1};
        psplat_marked_blocks_clear(&blocks, side, 1);
        psplat_marked_blocks_add(&blocks, &none);
        psplat_screen_extent e = psplat_marked_blocks_take(&blocks, &whole);
        assert_true(e.x0 == e.x1);
        psplat_marked_blocks_add(&blocks, &last);
        e = psplat_marked_blocks_take(&blocks, &whole);
        assert_true(e.x0 < side && side - e.x0 <= blocks.size);
        assert_int_equal(e.x1, side);
    }
}

/* Points of the patches and of the ellipses in their tangent planes lie in the spheres; 1e-5 of the
 * radius is for floats. */
static void test_spheres(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; ++kind) { /* flat; curved as the field says; of another shape */
        scene s = scene_ellipses(300, 0, 11);
        if (kind == 1) scene_curve(&s);
        for (size_t i = 0; kind == 2 && i < s.count; ++i)
            for (int k = 0; k < 3; ++k) s.splats[i].shape[2 + k] = 2 * scene_random(&seed) - 1;
        psplat_asset *asset = scene_open(&s);
        for (size_t b = 0; b < psplat_asset_batch_count(asset); ++b) {
            const psplat_batch *batch = psplat_asset_batch(asset, b);
            psplat_packing packing = psplat_packing_of(batch);
            size_t count = batch->splat_count;
            float *packed = malloc(count * sizeof *packed * (size_t)packing.splat_floats);
            float *spheres = malloc(count * sizeof *spheres * 4);
            assert_true(packed && spheres);
            psplat_pack_splats(&packing, batch->splats, count, packed);
            psplat_packed_spheres(&packing, packed, count, spheres);
            for (size_t i = 0; i < count; ++i) {
                const psplat_splat *splat = &batch->splats[i];
                double rv = (double)splat->radius[1], ru = (double)splat->radius[0], far = 0;
                for (int k = 0; k < 3; ++k)
                    assert_true(spheres[4 * i + (size_t)k] == splat->center[k]);
                for (int k = 0; k < 100; ++k) {
                    double angle = 0.01 * 6.2832 * k, u = cos(angle), v = sin(angle) * rv / ru;
                    const float *shape = splat->shape;
                    double first = -(double)shape[0] * u - (double)shape[1] * v;
                    double second =
                        -0.5 * ((double)shape[2] * u * u + (double)shape[3] * v * v * ru / rv +
                                2 * (double)shape[4] * u * v);
                    double plane = hypot(u, v);
                    far = fmax(far, ru * hypot(plane, first + (batch->is_curved ? second : 0)));
                    far = fmax(far, ru * hypot(plane, first));
                }
                assert_true(far <= (double)spheres[4 * i + 3] * (1 + 1e-5));
                assert_true((double)spheres[4 * i + 3] < 3 * far);
            }
            free(packed);
            free(spheres);
        }
        psplat_asset_destroy(asset);
        scene_free(&s);
    }
}

int test_marked_blocks_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rectangles),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_spheres),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
