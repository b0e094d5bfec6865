/* SPDX-License-Identifier: MIT
 *
 * test_legend.c - tests of the legends of heat maps: bars from 0 to the limit below their own
 * panels, text in every one, and nothing beyond the picture at any size.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "views/heat_colors.h"
#include "views/legend.h"

#include <stdlib.h>
#include <string.h>

static const psplat_legend legends[3] = {
    {"source", -1, NULL}, {"distance, %", 0.5, NULL}, {"normals, degrees", 20, "not covered"}};

typedef struct picture {
    int size, rows;
    uint8_t *pixels;
} picture;

static picture draw(int size, const psplat_legend *list) {
    picture p = {size, psplat_legend_height(size), NULL};
    p.pixels = malloc((size_t)(p.rows * 3 * size) * 3);
    assert_non_null(p.pixels);
    psplat_legend_draw(list, 3, size, p.pixels);
    return p;
}

/* Counts the pixels of a colour below a panel, and stores the leftmost and the rightmost column. */
static int count(const picture *p, int panel, const uint8_t color[3], int *left, int *right) {
    int found = 0;
    *left = p->size, *right = -1;
    for (int y = 0; y < p->rows; ++y)
        for (int x = 0; x < p->size; ++x) {
            if (memcmp(p->pixels + 3 * (y * 3 * p->size + panel * p->size + x), color, 3) != 0)
                continue;
            ++found;
            *left = x < *left ? x : *left;
            *right = x > *right ? x : *right;
        }
    return found;
}

/* Each bar begins with the colour of 0 on the left and ends with that of the limit on the right. */
static void test_bars(void **state) {
    (void)state;
    uint8_t zero[3], top[3];
    int left, right;
    psplat_heat_color(0, 1, zero);
    psplat_heat_color(1, 1, top);
    for (int size = 256; size <= 2048; size *= 2) {
        picture p = draw(size, legends);
        assert_int_equal(count(&p, 0, top, &left, &right), 0);
        for (int panel = 1; panel < 3; ++panel) {
            assert_true(count(&p, panel, zero, &left, &right) > 0);
            assert_in_range(left, 1, size / 20);
            assert_true(count(&p, panel, top, &left, &right) > 0);
            assert_in_range(right, size - size / 20, size - 2);
        }
        free(p.pixels);
    }
}

/* All panels have text, which tells them apart, and only the last one a key. */
static void test_text(void **state) {
    (void)state;
    static const uint8_t ink[3] = {232, 232, 232};
    int left, right;
    picture p = draw(512, legends);
    int plain = count(&p, 0, ink, &left, &right);
    assert_in_range(plain, 40, 400);
    assert_true(right < 60); /* "source" is six letters of some six pixels */
    assert_true(count(&p, 1, ink, &left, &right) > plain);
    assert_int_equal(count(&p, 1, psplat_heat_uncovered, &left, &right), 0);
    assert_in_range(count(&p, 2, psplat_heat_uncovered, &left, &right), 50, 64);
    free(p.pixels);
}

/* Other limits are other numbers below the same bar. */
static void test_numbers(void **state) {
    (void)state;
    psplat_legend other[3];
    memcpy(other, legends, sizeof other);
    other[2].limit = 30;
    picture a = draw(512, legends), b = draw(512, other);
    size_t bytes = (size_t)(a.rows * 3 * 512) * 3, different = 0;
    for (size_t i = 0; i < bytes; ++i) different += a.pixels[i] != b.pixels[i];
    assert_true(different > 0);
    assert_int_equal(a.rows, b.rows);
    free(a.pixels);
    free(b.pixels);
}

/* Sanitizers watch that narrow panels cut their text off. */
static void test_narrow(void **state) {
    (void)state;
    for (int size = 1; size < 200; size += 7) {
        picture p = draw(size, legends);
        free(p.pixels);
    }
}

int test_legend_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bars),
        cmocka_unit_test(test_text),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_narrow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
