/* SPDX-License-Identifier: MIT
 *
 * test_khr_gaussians.c - tests of converting splats to Gaussians (KHR_gaussian_splatting): their
 * extent and orientation are the second moments of what clip lines leave of the ellipse, and their
 * colours are lit. Expected moments are those of ellipses, squares and bands.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "export/khr_gaussians.h"
#include "material/mipmap.h"
#include "splats/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns a splat of radii 2 and 1 in the plane z = 0, white and not metallic. */
static psplat_splat plain(void) {
    return (psplat_splat){
        .rotation = {0, 0, 0, 1}, .radius = {2, 1}, .normal = {0, 0, 1}, .color = {1, 1, 1, 1}};
}

static psplat_gaussian make(psplat_splat *splat, psplat_finish *finish,
                            const psplat_material *material) {
    psplat_material used =
        material ? *material : (psplat_material){.base_color = {1, 1, 1, 1}, .roughness = 1};
    psplat_run run = {.count = 1, .clip_lines = splat->clip_count};
    psplat_splats splats = {.splats = splat,
                            .finishes = finish,
                            .count = 1,
                            .runs = &run,
                            .run_count = 1,
                            .materials = &used,
                            .material_count = 1};
    psplat_gaussian *gaussians = NULL, found;
    assert_int_equal(psplat_gaussians_make(&splats, NULL, &gaussians, NULL), PSPLAT_OK);
    found = gaussians[0];
    free(gaussians);
    return found;
}

static void assert_near(double found, double expected, double tolerance) {
    if (!(fabs(found - expected) <= tolerance)) fail_msg("%.9g, expected %.9g", found, expected);
}

/* The second moments of a uniform ellipse are a quarter of its squared radii. */
static void test_whole_ellipse(void **state) {
    (void)state;
    psplat_splat splat = plain();
    psplat_gaussian g = make(&splat, NULL, NULL);
    assert_near((double)g.scale[0], PSPLAT_GAUSSIAN_WIDTH * 1.0, 1e-6);
    assert_near((double)g.scale[1], PSPLAT_GAUSSIAN_WIDTH * 0.5, 1e-6);
    assert_true(g.scale[2] > 0 && g.scale[2] < 0.02f * g.scale[1]);
    for (int k = 0; k < 4; ++k) assert_near((double)g.rotation[k], k == 3, 1e-7);
}

/* A square of half side 1/2 inside the circle has moments of h^2 / 3. */
static void test_square(void **state) {
    (void)state;
    psplat_splat splat = plain();
    static const float lines[4][3] = {{1, 0, 0.5f}, {-1, 0, 0.5f}, {0, 1, 0.5f}, {0, -1, 0.5f}};
    splat.radius[0] = splat.radius[1] = 3;
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k) splat.clip[i][k] = lines[i][k];
    splat.clip_count = 4;
    psplat_gaussian g = make(&splat, NULL, NULL);
    for (int k = 0; k < 2; ++k) /* the polygon's corners are on the lines */
        assert_near((double)g.scale[k], PSPLAT_GAUSSIAN_WIDTH * 1.5 / sqrt(3), 1e-5);
}

/* A diagonal band of the circle is longest along the diagonal, in every orientation of the splat.
 */
static void test_turned(void **state) {
    (void)state;
    psplat_splat splat = plain();
    const float s = sqrtf(0.5f);
    splat.radius[0] = splat.radius[1] = 1;
    splat.clip_count = 2;
    for (int i = 0; i < 2; ++i) { /* |u - v| <= 0.2 sqrt 2 */
        splat.clip[i][0] = i ? s : -s;
        splat.clip[i][1] = i ? -s : s;
        splat.clip[i][2] = 0.2f;
    }
    const float rotation[4] = {0.5f, 0.5f, 0.5f, 0.5f}; /* maps x to y, y to z, and z to x */
    for (int k = 0; k < 4; ++k) splat.rotation[k] = rotation[k];
    psplat_gaussian g = make(&splat, NULL, NULL);
    double x = (double)g.rotation[0], y = (double)g.rotation[1], z = (double)g.rotation[2];
    double w = (double)g.rotation[3];
    const double axis[3] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)};
    assert_near(x * x + y * y + z * z + w * w, 1, 1e-6);
    assert_near(axis[0], 0, 1e-6);
    assert_near(fabs(axis[1]), sqrt(0.5), 1e-6);
    assert_near(axis[1], axis[2], 1e-6);
    /* The band has about a half width of 0.2, hence h^2 / 3. */
    assert_near((double)g.scale[1], PSPLAT_GAUSSIAN_WIDTH * 0.2 / sqrt(3), 0.003);
    assert_true(g.scale[0] > 3 * g.scale[1]);
}

static void test_nothing_left(void **state) {
    (void)state;
    psplat_splat splat = plain();
    splat.clip_count = 1;
    splat.clip[0][0] = 1;
    splat.clip[0][2] = -2;
    psplat_gaussian g = make(&splat, NULL, NULL);
    assert_near((double)g.scale[0], PSPLAT_GAUSSIAN_WIDTH, 1e-6);
}

static double shown(const psplat_gaussian *g, int channel) {
    return (double)g->harmonic[channel] * 0.28209479177387814 + 0.5;
}

/* An unlit splat has its colour; a lit one is darker where it faces away from the light, and never
 * black. */
static void test_colours(void **state) {
    (void)state;
    psplat_splat splat = plain();
    psplat_material material = {.base_color = {0.8f, 0.4f, 0.2f, 1}, .roughness = 1, .unlit = 1};
    splat.color[0] = 0.5f;
    psplat_gaussian g = make(&splat, NULL, &material);
    assert_near(shown(&g, 0), (double)psplat_srgb_of_linear(0.4f), 1e-6);
    assert_near(shown(&g, 1), (double)psplat_srgb_of_linear(0.4f), 1e-6);
    assert_near(shown(&g, 2), (double)psplat_srgb_of_linear(0.2f), 1e-6);
    material.unlit = 0;
    static const float up[3] = {0, 1, 0}, down[3] = {0, -1, 0};
    for (int k = 0; k < 3; ++k) splat.normal[k] = up[k];
    psplat_gaussian bright = make(&splat, NULL, &material);
    for (int k = 0; k < 3; ++k) splat.normal[k] = down[k];
    psplat_gaussian dark = make(&splat, NULL, &material);
    assert_true(shown(&bright, 1) > 1.3 * shown(&dark, 1));
    assert_true(shown(&dark, 1) > 0.3);
    assert_true(shown(&bright, 1) < (double)psplat_srgb_of_linear(0.4f));
}

/* Values that vary by splat (spec 3.10) are used; emission is added, up to white. */
static void test_finish(void **state) {
    (void)state;
    psplat_splat splat = plain();
    psplat_material material = {
        .base_color = {0, 0, 0, 1}, .emissive = {4, 0.5f, 0}, .roughness = 1};
    psplat_finish finish = {.occlusion = 1, .roughness = 1, .emissive = {1, 0.5f, 1}};
    psplat_gaussian g = make(&splat, &finish, &material);
    assert_near(shown(&g, 0), 1, 1e-6);
    assert_near(shown(&g, 1), (double)psplat_srgb_of_linear(0.25f), 1e-6);
    assert_near(shown(&g, 2), 0, 1e-6);
    material.base_color[2] = 0.5f;
    psplat_gaussian open = make(&splat, &finish, &material);
    finish.occlusion = 0.25f;
    psplat_gaussian hidden = make(&splat, &finish, &material);
    assert_true(shown(&hidden, 2) < shown(&open, 2));
}

/* Stores the axes of a Gaussian. */
static void axes_of(const psplat_gaussian *g, double axes[3][3]) {
    double x = (double)g->rotation[0], y = (double)g->rotation[1], z = (double)g->rotation[2];
    double w = (double)g->rotation[3];
    const double columns[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
        {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
        {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 9; ++i) axes[i / 3][i % 3] = columns[i / 3][i % 3];
}

/* A dome over the unit disc: heights of -r^2 / 2 have the mean square 1 / 12 of r^4 / 4. The third
 * axis is on the side of the normal. */
static void test_dome(void **state) {
    (void)state;
    psplat_splat splat = plain();
    splat.radius[0] = 1;
    splat.shape[2] = splat.shape[3] = 1;
    psplat_gaussian g = make(&splat, NULL, NULL);
    double axes[3][3];
    axes_of(&g, axes);
    /* A polygon of 64 sides has 0.2 % less of the second moments. */
    for (int k = 0; k < 2; ++k) assert_near((double)g.scale[k], PSPLAT_GAUSSIAN_WIDTH * 0.5, 2e-3);
    assert_near((double)g.scale[2], PSPLAT_GAUSSIAN_WIDTH * sqrt(1 / 12.0), 2e-3);
    assert_near(axes[2][2], 1, 1e-6);
}

/* A slope of one half along u is a tilted plane: its Gaussian is as flat as that of a flat splat,
 * but for the least thickness. A straight and a bent line change nothing of that. */
static void test_tilted(void **state) {
    (void)state;
    for (uint32_t lines = 0; lines < 3; ++lines) {
        psplat_splat splat = plain();
        splat.shape[0] = -0.5f;
        splat.clip_count = lines;
        splat.clip[0][1] = splat.clip[1][0] = 1, splat.bend[1] = 1;
        psplat_gaussian g = make(&splat, NULL, NULL);
        double axes[3][3];
        axes_of(&g, axes);
        assert_near(axes[2][0] * -0.5 + axes[2][2], sqrt(1.25), 1e-6);
        assert_near((double)g.scale[2], 0.01 * (double)g.scale[1], 1e-6);
        if (!lines) assert_near((double)g.scale[0], PSPLAT_GAUSSIAN_WIDTH * sqrt(1.25), 4e-3);
        if (!lines) assert_near((double)g.scale[1], PSPLAT_GAUSSIAN_WIDTH * 0.5, 2e-3);
    }
}

/* Where a splat has texture coordinates, its colour is the mean of the texture over it: black to
 * the left, white to the right, and emission and occlusion alike. */
static void test_textures(void **state) {
    (void)state;
    uint8_t pixels[64 * 64 * 4];
    for (size_t i = 0; i < 64 * 64; ++i)
        memset(pixels + 4 * i, i % 64 < 32 ? 0 : 255, 3), pixels[4 * i + 3] = 255;
    psplat_image image = {.pixels = pixels, .width = 64, .height = 64};
    const psplat_source_materials sources = {.images = &image, .image_count = 1};
    static const struct {
        psplat_texture_slot slot;
        float at;
        double expected; /* linear, of light 1 */
    } cases[] = {{PSPLAT_TEXTURE_BASE_COLOR, 0.5f, 0.5}, {PSPLAT_TEXTURE_BASE_COLOR, 0.75f, 1},
                 {PSPLAT_TEXTURE_BASE_COLOR, 0.25f, 0},  {PSPLAT_TEXTURE_EMISSIVE, 0.5f, 0.5},
                 {PSPLAT_TEXTURE_OCCLUSION, 0.75f, 1},   {PSPLAT_TEXTURE_OCCLUSION, 0.25f, 0.2}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        psplat_splat splat = plain();
        psplat_texcoord texcoord = {
            .at = {cases[c].at, 0.5f}, .along_u = {0.1f, 0}, .along_v = {0, 0.1f}};
        psplat_material material = {.base_color = {1, 1, 1, 1}, .roughness = 1};
        psplat_run run = {.count = 1, .has_texcoord = 1};
        psplat_splats splats = {.splats = &splat,
                                .texcoords = &texcoord,
                                .count = 1,
                                .runs = &run,
                                .run_count = 1,
                                .materials = &material,
                                .material_count = 1};
        psplat_gaussian *g = NULL;
        psplat_gaussian bare = make(&splat, NULL, &material);
        double full = (double)psplat_linear_of_srgb(0.28209479f * bare.harmonic[0] + 0.5f);
        /* A transform by a whole tile changes nothing. */
        material.textures[cases[c].slot] =
            (psplat_texture){.image = 1, .strength = 0.8f, .transform = {1, 0, 1, 0, 1, -3}};
        if (cases[c].slot == PSPLAT_TEXTURE_EMISSIVE) {
            material.base_color[0] = 0, material.emissive[0] = 1, full = 1;
        }
        assert_int_equal(psplat_gaussians_make(&splats, &sources, &g, NULL), PSPLAT_OK);
        /* The filter reads a mipmap whose texels are as wide as the splat, blurred by half. */
        assert_near((double)psplat_linear_of_srgb(0.28209479f * g->harmonic[0] + 0.5f),
                    full * cases[c].expected, 0.06);
        free(g);
    }
}

int test_khr_gaussians_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_whole_ellipse), cmocka_unit_test(test_square),
        cmocka_unit_test(test_turned),        cmocka_unit_test(test_nothing_left),
        cmocka_unit_test(test_colours),       cmocka_unit_test(test_finish),
        cmocka_unit_test(test_dome),          cmocka_unit_test(test_tilted),
        cmocka_unit_test(test_textures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
