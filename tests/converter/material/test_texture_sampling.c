/* SPDX-License-Identifier: MIT
 *
 * test_texture_sampling.c - tests of texture lookups as glTF 2.0 section 3.8 defines them, and of
 * averages over the footprint of a sample. Images are ramps, stripes and checkerboards of a few
 * grey texels, so that expected values follow by hand.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"
#include "material/image.h"
#include "material/mipmap.h"
#include "material/source_materials.h"
#include "material/texture_sampling.h"

#include <math.h>

static const double point[2][2];

typedef struct fixture {
    psplat_image image;
    psplat_mipmap mipmap;
    psplat_texture_info texture;
} fixture;

/* Makes a texture of grey texels. */
static void make(fixture *f, const uint8_t *grey, uint32_t width, uint32_t height, int is_srgb) {
    *f = (fixture){0};
    assert_int_equal(psplat_image_allocate(&f->image, width, height, NULL), PSPLAT_OK);
    for (size_t i = 0; i < (size_t)width * height; ++i) memset(f->image.pixels + 4 * i, grey[i], 4);
    assert_int_equal(psplat_mipmap_build(&f->image, is_srgb, &f->mipmap), PSPLAT_OK);
    f->texture.image = &f->image;
}

static void release(fixture *f) {
    psplat_mipmap_free(&f->mipmap);
    psplat_image_free(&f->image);
}

static double at(const fixture *f, double s, double t, const double axes[2][2]) {
    const double st[2] = {s, t};
    float rgba[4];
    psplat_texture_average(&f->texture, &f->mipmap, st, axes, rgba);
    return (double)rgba[0];
}

/* Rounding to float. */
#define CLOSE 1e-6

static void test_texel_centres(void **state) {
    (void)state;
    static const uint8_t grey[6] = {0, 51, 102, 153, 204, 255};
    fixture f;
    make(&f, grey, 3, 2, 0);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 3; ++x)
            assert_near(at(&f, (x + 0.5) / 3, (y + 0.5) / 2, point), (3 * y + x) / 5.0, CLOSE);
    /* Halfway between two texels, and in the middle of four. */
    assert_near(at(&f, 1 / 3.0, 0.25, point), 0.1, CLOSE);
    assert_near(at(&f, 1 / 3.0, 0.5, point), 0.4, CLOSE);
    f.texture.nearest = 1;
    assert_near(at(&f, 0.34, 0.49, point), 0.2, CLOSE);
    assert_near(at(&f, 0.32, 0.51, point), 0.6, CLOSE);
    release(&f);
}

static void test_wraps(void **state) {
    (void)state;
    static const uint8_t grey[4] = {0, 51, 102, 255};
    fixture f;
    make(&f, grey, 4, 1, 0);
    f.texture.nearest = 1;
    static const struct {
        psplat_wrap wrap;
        double s, expected;
    } cases[] = {
        {PSPLAT_WRAP_REPEAT, 1.1, 0},         {PSPLAT_WRAP_REPEAT, -0.1, 1},
        {PSPLAT_WRAP_REPEAT, -7.6, 0.2},      {PSPLAT_WRAP_CLAMP, 1.1, 1},
        {PSPLAT_WRAP_CLAMP, -0.1, 0},         {PSPLAT_WRAP_CLAMP, 1e30, 1},
        {PSPLAT_WRAP_MIRROR, 1.1, 1},         {PSPLAT_WRAP_MIRROR, 1.3, 0.4},
        {PSPLAT_WRAP_MIRROR, -0.1, 0},        {PSPLAT_WRAP_MIRROR, -0.3, 0.2},
        {PSPLAT_WRAP_MIRROR, 2.1, 0},         {PSPLAT_WRAP_MIRROR, -1.9, 0},
        {PSPLAT_WRAP_REPEAT, (double)NAN, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        f.texture.wrap[0] = cases[i].wrap;
        double found = at(&f, cases[i].s, 0.5, point);
        if (fabs(found - cases[i].expected) > CLOSE)
            fail_msg("case %zu: %g instead of %g", i, found, cases[i].expected);
    }
    /* Between the last texel and the first one, where the image repeats. */
    f.texture.nearest = 0;
    f.texture.wrap[0] = PSPLAT_WRAP_REPEAT;
    assert_near(at(&f, 0, 0.5, point), 0.5, CLOSE);
    f.texture.wrap[0] = PSPLAT_WRAP_CLAMP;
    assert_near(at(&f, 0, 0.5, point), 0, CLOSE);
    release(&f);
}

static void test_linear_light(void **state) {
    (void)state;
    static const uint8_t grey[2] = {0, 255};
    fixture f;
    make(&f, grey, 2, 1, 1);
    /* The mean is half of the light, and not the value 128, which is a fifth of it. */
    assert_near(at(&f, 0.5, 0.5, point), 0.5, CLOSE);
    release(&f);
    static const uint8_t middle[1] = {128};
    make(&f, middle, 1, 1, 1);
    assert_near(at(&f, 0.5, 0.5, point), 0.2158605, 1e-5); /* 128/255 by IEC 61966-2-1 */
    release(&f);
    for (int i = 0; i < 256; ++i) {
        float stored = (float)i / 255;
        assert_near(psplat_srgb_of_linear(psplat_linear_of_srgb(stored)), stored, 1e-5);
    }
}

/* The mean of each level is that of the image, also for sizes that are not powers of two. */
static void test_means(void **state) {
    (void)state;
    enum { WIDTH = 37, HEIGHT = 11 };
    uint8_t grey[WIDTH * HEIGHT];
    double mean = 0;
    uint64_t random = 3;
    for (size_t i = 0; i < sizeof grey; ++i) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        grey[i] = (uint8_t)(random >> 56);
        mean += grey[i] / 255.0 / sizeof grey;
    }
    fixture f;
    make(&f, grey, WIDTH, HEIGHT, 0);
    assert_int_equal(f.mipmap.level_count, 6); /* widths 37, 18, 9, 4, 2, 1 */
    for (uint32_t level = 0; level < f.mipmap.level_count; ++level) {
        const psplat_mipmap_level *l = &f.mipmap.levels[level];
        double sum = 0;
        for (uint32_t y = 0; y < l->height; ++y)
            for (uint32_t x = 0; x < l->width; ++x) {
                float rgba[4];
                psplat_mipmap_texel(&f.mipmap, level, x, y, rgba);
                sum += (double)rgba[3];
            }
        assert_near(sum / ((double)l->width * l->height), mean, 2e-5); /* levels of 16 bits */
    }
    release(&f);
}

/* From afar a checkerboard is grey, also where only one axis of the footprint is long. */
static void test_footprints(void **state) {
    (void)state;
    enum { SIZE = 64 };
    uint8_t grey[SIZE * SIZE], stripes[SIZE * SIZE];
    for (size_t i = 0; i < sizeof grey; ++i) {
        grey[i] = (i + i / SIZE) % 2 ? 255 : 0;
        stripes[i] = i % SIZE < SIZE / 2 ? 255 : 0;
    }
    static const double wide[2][2] = {{0.1, 0}, {0, 0.1}}, all[2][2] = {{0.7, 0}, {0, 3}};
    fixture f;
    make(&f, grey, SIZE, SIZE, 1);
    assert_near(at(&f, 0.3, 0.3, wide), 0.5, 1e-3);
    assert_near(at(&f, 0.3, 0.3, all), 0.5, 1e-3);
    release(&f);
    /* An ellipse that is long along the stripes still sees one of them; across them it does not. */
    static const double along[2][2] = {{0.01, 0}, {0, 0.3}}, across[2][2] = {{0.25, 0}, {0, 0.01}};
    /* conjugate axes of `along` */
    static const double skewed[2][2] = {{0.007, 0.2}, {-0.007, 0.2}};
    make(&f, stripes, SIZE, SIZE, 0);
    assert_near(at(&f, 0.4, 0.5, along), 1, 1e-3);
    assert_near(at(&f, 0.4, 0.5, skewed), 1, 1e-3);
    assert_near(at(&f, 0.5, 0.5, across), 0.5, 1e-3);
    release(&f);
}

static void test_transform(void **state) {
    (void)state;
    psplat_texture_info texture = {0};
    const double uv[2] = {0.25, -3};
    double st[2];
    psplat_texture_transform(&texture, uv, st);
    assert_memory_equal(st, uv, sizeof st);
    const double rows[6] = {0, 2, 0.5, -1, 0, 0.25};
    memcpy(texture.transform, rows, sizeof rows);
    psplat_texture_transform(&texture, uv, st);
    assert_near(st[0], -5.5, 0);
    assert_near(st[1], 0, 0);
}

/* Stored values are no light: sRGB changes nothing. Wraps and filters are those of the sampler. */
static void test_stored(void **state) {
    (void)state;
    static const uint8_t grey[6] = {0, 51, 102, 153, 204, 255};
    const double centre[2] = {0.5, 0.25}, between[2] = {1 / 3.0, 0.25},
                 beyond[2] = {1.5 / 3 - 2, 0.75};
    float rgba[4];
    fixture f;
    make(&f, grey, 3, 2, 1);
    psplat_texture_stored(&f.texture, centre, rgba);
    for (int k = 0; k < 4; ++k) assert_near(rgba[k], 0.2, CLOSE);
    psplat_texture_stored(&f.texture, between, rgba);
    assert_near(rgba[1], 0.1, CLOSE);
    psplat_texture_stored(&f.texture, beyond, rgba);
    assert_near(rgba[1], 0.8, CLOSE);
    f.texture.wrap[0] = PSPLAT_WRAP_CLAMP;
    psplat_texture_stored(&f.texture, beyond, rgba);
    assert_near(rgba[1], 0.6, CLOSE);
    f.texture.nearest = 1;
    psplat_texture_stored(&f.texture, between, rgba);
    assert_near(rgba[1], 0.2, CLOSE);
    release(&f);
}

/* An image that could not be read counts as no texture. */
static void test_unreadable(void **state) {
    (void)state;
    psplat_image image = {0};
    psplat_mipmap mipmap;
    assert_int_equal(psplat_mipmap_build(&image, 1, &mipmap), PSPLAT_OK);
    assert_int_equal(mipmap.level_count, 0);
    psplat_mipmap_free(&mipmap);
    assert_int_equal(psplat_mipmap_build(NULL, 1, &mipmap), PSPLAT_OK);
    psplat_mipmap_free(&mipmap);
}

int test_texture_sampling_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_texel_centres), cmocka_unit_test(test_wraps),
        cmocka_unit_test(test_linear_light),  cmocka_unit_test(test_means),
        cmocka_unit_test(test_footprints),    cmocka_unit_test(test_transform),
        cmocka_unit_test(test_unreadable),    cmocka_unit_test(test_stored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
