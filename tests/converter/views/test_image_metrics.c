/* SPDX-License-Identifier: MIT
 *
 * test_image_metrics.c - tests of the error measures of pictures (PSNR, SSIM, difference, missing
 * and extra pixels), against answers known by hand and a direct implementation of the formulas of
 * Wang et al. 2004.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "views/image_metrics.h"
#include "views/picture_views.h"
#include "near.h"

enum { SIZE = 48, BYTES = 4 * SIZE * SIZE };

static uint8_t first[BYTES], second[BYTES];

static void set_pixel(uint8_t *picture, int x, int y, int r, int g, int b) {
    const int rgba[4] = {r, g, b, 255};
    for (int c = 0; c < 4; ++c) picture[4 * (y * SIZE + x) + c] = (uint8_t)rgba[c];
}

static psplat_picture_errors errors_of(const uint8_t *source, const uint8_t *pictured) {
    psplat_image_metrics sums = {0};
    psplat_picture_errors errors = {0};
    assert_int_equal(psplat_image_metrics_add(&sums, source, pictured, SIZE, NULL), PSPLAT_OK);
    psplat_image_metrics_report(&sums, &errors);
    return errors;
}

static void fill(uint8_t *picture, int value) {
    for (int i = 0; i < SIZE * SIZE; ++i)
        set_pixel(picture, i % SIZE, i / SIZE, value, value, value);
}

/* ---- known answers --------------------------------------------------------------------------- */

static void test_offset(void **state) {
    (void)state;
    fill(first, 100);
    fill(second, 107);
    psplat_picture_errors e = errors_of(first, second);
    /* Every channel's MSE is 7^2, and SSIM is eq. 6 of Wang et al. with variances 0; only rounding
     * differs. */
    assert_near(e.psnr, 20 * log10(255.0 / 7), 1e-12);
    assert_near(e.inside_psnr, e.psnr, 0);
    assert_near(e.difference, 100 * 7.0 / 255, 1e-12);
    assert_near(e.inside, e.difference, 0);
    assert_int_equal(e.covered, SIZE * SIZE);
    assert_near(e.missing + e.extra, 0, 0);
}

static void test_alike(void **state) {
    (void)state;
    srand(1);
    for (int i = 0; i < BYTES; ++i) first[i] = i % 4 == 3 ? 255 : (uint8_t)(rand() >> 8);
    psplat_picture_errors e = errors_of(first, first);
    assert_true(isinf(e.psnr) && e.psnr > 0);
    assert_near(e.ssim, 1, 1e-12); /* a mean of some thousand ones */
    assert_near(e.difference + e.inside + e.missing + e.extra, 0, 0);
}

static void test_nothing(void **state) {
    (void)state;
    memset(first, 0, BYTES);
    psplat_picture_errors e = errors_of(first, first);
    assert_true(isinf(e.psnr));
    assert_near(e.ssim, 1, 0);
    assert_near(e.difference + e.inside + e.missing + e.extra, 0, 0);
    assert_int_equal(e.covered, 0);
    fill(second, 255); /* The second picture shows something where the first one shows nothing. */
    e = errors_of(first, second);
    assert_near(e.psnr, 0, 1e-12);
    assert_near(e.extra, 100, 0);
    assert_near(e.missing, 0, 0);
    assert_near(e.difference, 100, 0);
    assert_near(e.inside, 0, 0);
}

static int disc(uint8_t *picture, double x0, double radius, int value) {
    int count = 0;
    memset(picture, 0, BYTES);
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x)
            if (hypot(x - x0, y - SIZE / 2) <= radius) {
                set_pixel(picture, x, y, value, value, value);
                ++count;
            }
    return count;
}

static void test_outlines(void **state) {
    (void)state;
    /* Two discs of one colour lie seven pixels apart, so that whole columns of pixels are missing
     * or extra. */
    int covered = disc(first, 18, 12.3, 200), only = 0;
    assert_int_equal(disc(second, 25, 12.3, 200), covered);
    for (int i = 3; i < BYTES; i += 4) only += first[i] && !second[i];
    assert_true(only > 50);
    psplat_picture_errors e = errors_of(first, second);
    assert_near(e.missing, 100.0 * only / covered, 1e-12);
    assert_near(e.extra, e.missing, 0);
    assert_near(e.inside, 0, 0);
    assert_true(isinf(e.inside_psnr) && isfinite(e.psnr));
    assert_near(e.difference, 100.0 * 2 * only * 200 / 255 / (covered + only), 1e-12);
    assert_int_equal(e.covered, covered);
}

/* All views count as one long picture: squared errors are averaged, and not decibels. */
static void test_sums(void **state) {
    (void)state;
    psplat_image_metrics sums = {0};
    psplat_picture_errors e;
    fill(first, 50);
    fill(second, 50);
    assert_int_equal(psplat_image_metrics_add(&sums, first, second, SIZE, NULL), PSPLAT_OK);
    fill(second, 60);
    assert_int_equal(psplat_image_metrics_add(&sums, first, second, SIZE, NULL), PSPLAT_OK);
    psplat_image_metrics_report(&sums, &e);
    assert_near(e.psnr, 10 * log10(255.0 * 255 / 50), 1e-12); /* (0 + 100) / 2 */
    assert_near(e.difference, 100 * 5.0 / 255, 1e-12);
    assert_int_equal(e.covered, 2 * SIZE * SIZE);
}

/* ---- structural similarity ------------------------------------------------------------------- */

static double luma(const uint8_t *picture, int x, int y) {
    if (x < 0 || y < 0 || x >= SIZE || y >= SIZE) return 0;
    const uint8_t *p = picture + 4 * (y * SIZE + x);
    return 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
}

/* Returns SSIM of a window by eq. 13 to 16 of the paper, with means first and then deviations from
 * them. */
static double window(const uint8_t *a, const uint8_t *b, int x0, int y0) {
    double weights[11][11], total = 0, mean[2] = {0, 0}, var[2] = {0, 0}, covariance = 0;
    for (int y = -5; y <= 5; ++y)
        for (int x = -5; x <= 5; ++x)
            total += weights[y + 5][x + 5] = exp(-(x * x + y * y) / (2 * 1.5 * 1.5));
    for (int pass = 0; pass < 2; ++pass)
        for (int y = -5; y <= 5; ++y)
            for (int x = -5; x <= 5; ++x) {
                double w = weights[y + 5][x + 5] / total;
                double p = luma(a, x0 + x, y0 + y), q = luma(b, x0 + x, y0 + y);
                if (!pass) {
                    mean[0] += w * p;
                    mean[1] += w * q;
                } else {
                    var[0] += w * (p - mean[0]) * (p - mean[0]);
                    var[1] += w * (q - mean[1]) * (q - mean[1]);
                    covariance += w * (p - mean[0]) * (q - mean[1]);
                }
            }
    double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
    return (2 * mean[0] * mean[1] + c1) * (2 * covariance + c2) /
           ((mean[0] * mean[0] + mean[1] * mean[1] + c1) * (var[0] + var[1] + c2));
}

static void test_similarity(void **state) {
    (void)state;
    double sum = 0;
    int count = 0;
    srand(7);
    disc(first, 20, 17, 0); /* reaches the edge */
    disc(second, 23, 18, 0);
    for (int i = 0; i < BYTES; ++i)
        if (i % 4 < 3) {
            if (first[i | 3]) first[i] = (uint8_t)(128 + i / 4 % SIZE);
            if (second[i | 3]) second[i] = (uint8_t)(100 + rand() % 60 + i / 4 % SIZE);
        }
    for (int y = 0; y < SIZE; ++y)
        for (int x = 0; x < SIZE; ++x) {
            int alpha = 4 * (y * SIZE + x) + 3;
            if (!first[alpha] && !second[alpha]) continue;
            sum += window(first, second, x, y);
            ++count;
        }
    psplat_picture_errors e = errors_of(first, second);
    assert_true(e.ssim > 0.2 && e.ssim < 0.95); /* a value that is far from both ends */
    /* E x^2 - (E x)^2 loses 1e-16 of the square of 255^2 = 65025. */
    assert_near(e.ssim, sum / count, 1e-11);
    psplat_picture_errors other = errors_of(second, first);
    assert_near(other.ssim, e.ssim, 1e-12);
    assert_near(other.psnr, e.psnr, 0);
}

/* A pixel that lacks is an interior hole where the source covers all within the erosion. */
static void test_interior_holes(void **state) {
    (void)state;
    for (int erosion = 1; erosion <= 4; ++erosion)
        for (int side = 0; side < 2; ++side) {
            psplat_image_metrics sums = {.erosion = erosion == 2 ? 0 : erosion}; /* 2 by default */
            psplat_picture_errors e = {0};
            memset(first, 0, BYTES);
            memset(second, 0, BYTES);
            /* Columns 10 ... 30 of all rows, which the edges of the picture end. */
            for (int y = 0; y < SIZE; ++y)
                for (int x = 10; x <= 30; ++x) {
                    set_pixel(first, x, y, 200, 200, 200);
                    /* The other one begins `erosion` columns later, or one more, in one row. */
                    if (x >= 10 + erosion + side || y != 20) set_pixel(second, x, y, 200, 200, 200);
                }
            assert_int_equal(psplat_image_metrics_add(&sums, first, second, SIZE, NULL), PSPLAT_OK);
            psplat_image_metrics_report(&sums, &e);
            assert_int_equal(e.interior_holes, side);
        }
    fill(first, 100); /* Beyond the picture is background. */
    memset(second, 0, BYTES);
    assert_int_equal(errors_of(first, second).interior_holes, (SIZE - 4) * (SIZE - 4));
    assert_int_equal(errors_of(second, first).interior_holes, 0);
}

int test_image_metrics_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_offset),         cmocka_unit_test(test_alike),
        cmocka_unit_test(test_nothing),        cmocka_unit_test(test_outlines),
        cmocka_unit_test(test_sums),           cmocka_unit_test(test_similarity),
        cmocka_unit_test(test_interior_holes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
