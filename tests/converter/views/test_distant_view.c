/* SPDX-License-Identifier: MIT
 *
 * test_distant_view.c - tests of the distant view, a picture shrunk by averaging blocks in linear
 * light, and of the difference of two pictures over the pixels that both cover. Pictures have a few
 * blocks of known pixels.
 */
#include "views/distant_view.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <cmocka.h>

enum { SIZE = 2, FINE = SIZE * PSPLAT_DISTANT };

static void fill(uint8_t *pixel, uint8_t r, uint8_t g, uint8_t b) {
    const uint8_t rgba[4] = {r, g, b, 255};
    memcpy(pixel, rgba, 4);
}

/* Half black and half white is 0.5 in linear light, which sRGB encodes as 188; blocks of one colour
 * keep it. */
static void test_means(void **state) {
    uint8_t fine[FINE * FINE * 4], small[SIZE * SIZE * 4];
    (void)state;
    for (int y = 0; y < FINE; ++y)
        for (int x = 0; x < FINE; ++x) {
            int white = (x + y) % 2, left = x < PSPLAT_DISTANT;
            fill(fine + 4 * (y * FINE + x), left ? (uint8_t)(255 * white) : 200, left ? 0 : 3, 77);
        }
    fine[4 * (FINE * FINE - 1) + 3] = 0; /* One pixel of the last block is not covered. */
    psplat_distant_view_shrink(fine, SIZE, small);
    for (int i = 0; i < SIZE * SIZE; ++i) {
        assert_int_equal(small[4 * i], i % 2 ? 200 : 188);
        assert_int_equal(small[4 * i + 1], i % 2 ? 3 : 0);
        assert_int_equal(small[4 * i + 2], 77);
        assert_int_equal(small[4 * i + 3], i == SIZE * SIZE - 1 ? 0 : 255);
    }
}

/* A pixel that either picture lacks does not count. */
static void test_differences(void **state) {
    uint8_t truth[4 * 4], shown[4 * 4];
    uint64_t differences = 5, pixels = 1;
    (void)state;
    for (int i = 0; i < 4; ++i) {
        fill(truth + 4 * i, 100, 110, 120);
        fill(shown + 4 * i, 90, 111, 140);
    }
    truth[3] = shown[7] = 0;
    psplat_distant_view_add(truth, shown, 2, &differences, &pixels);
    assert_int_equal(pixels, 1 + 2);
    assert_int_equal(differences, 5 + 2 * (10 + 1 + 20));
}

int test_distant_view_main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_means),
                                       cmocka_unit_test(test_differences)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
