/* SPDX-License-Identifier: MIT
 *
 * test_appearance.c - tests of the appearance of a mesh at a point, in which textures, vertex
 * colours and normal maps are combined as glTF 2.0 defines. The shape is a textured square;
 * expected values follow from the texels by hand.
 */
#include "appearance_fixture.h"

#include "near.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "appearance/appearance.h"
#include "material/image.h"
#include "material/mipmap.h"
#include "material/source_materials.h"

/* Gives an image whose channels all differ and grow linearly to the right and downwards. */
static void ramps(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    rgba[0] = (uint8_t)(16 * x), rgba[1] = (uint8_t)(16 * y);
    rgba[2] = (uint8_t)(255 - 16 * x), rgba[3] = (uint8_t)(255 - 16 * y);
}

/* Gives a normal map whose normal leans to the right and a little up the image. */
static void leaning(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    rgba[0] = 204, rgba[1] = 153, rgba[2] = 230, rgba[3] = 255; /* (0.6, 0.2, 0.804) */
}

static const float up[3] = {0, 0, 1};

/* Stores barycentric coordinates in the lower right triangle of an undivided square. */
static void at(double x, double y, double barycentric[3]) {
    double u = (x + 1) / 2, v = (y + 1) / 2;
    barycentric[0] = 1 - u, barycentric[1] = u - v, barycentric[2] = v;
}

static psplat_baked_point shade_at(const painted *p, double x, double y) {
    psplat_appearance appearance;
    psplat_baked_point shade;
    double barycentric[3];
    at(x, y, barycentric);
    assert_int_equal(psplat_appearance_build(&p->mesh, 1e-6, 0, &appearance), PSPLAT_OK);
    psplat_appearance_bake(&appearance, 0, barycentric, up, &shade);
    psplat_appearance_free(&appearance);
    return shade;
}

static void test_base_color(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 1, 16, ramps);
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    /* The texture's alpha is ignored on an opaque material. */
    assert_near(shade_at(&p, 0.5, -0.5).color[3], 1, 0);
    p.source_material.is_blended = 1;
    /* halfway between texels 11 and 12 in x and y */
    psplat_baked_point shade = shade_at(&p, 0.5, -0.5);
    float low = psplat_linear_of_srgb(16 * 11 / 255.0f);
    float high = psplat_linear_of_srgb(16 * 12 / 255.0f);
    assert_near(shade.color[0], (low + high) / 2, 1e-5);
    assert_near(shade.color[1], (low + high) / 2, 1e-5);
    assert_near(shade.color[3], 1 - 16 * 11.5 / 255, 1e-5);
    assert_near(shade.finish[1], 1, 0);
    assert_near(shade.emissive[0], 1, 0);
    painted_free(&p);
}

/* Gives white up to the middle, and black beyond it. */
static void step(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)y;
    memset(rgba, x < 8 ? 255 : 0, 4);
}

/* A disc of diameter 0.5 is 4 of the 16 texels wide: at 2 texels from the step it just reaches
 * black. A disc twice as wide is a quarter white by the level of 8 texels. */
static void test_diameter(void **state) {
    (void)state;
    painted p;
    double barycentric[3];
    painted_make(&p, 1, 16, step);
    p.source_material.metallic_roughness = (psplat_texture_info){.image = &p.image};
    at(0.25, 0, barycentric);
    for (int wide = 0; wide < 2; ++wide) {
        psplat_appearance appearance;
        psplat_baked_point shade;
        assert_int_equal(psplat_appearance_build(&p.mesh, wide ? 1 : 0.5, 0, &appearance),
                         PSPLAT_OK);
        psplat_appearance_bake(&appearance, 0, barycentric, up, &shade);
        assert_near(shade.finish[1], wide ? 0.25 : 0, 1e-5); /* levels of 16 bits */
        psplat_appearance_free(&appearance);
    }
    painted_free(&p);
}

static void test_vertex_colors_multiply(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 1, 16, ramps);
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    float plain = shade_at(&p, 0.5, -0.5).color[0];
    p.mesh.corner_colors = malloc(24 * sizeof(float));
    assert_non_null(p.mesh.corner_colors);
    for (int i = 0; i < 24; ++i) p.mesh.corner_colors[i] = i % 4 == 0 ? 0.5f : 1;
    assert_near(shade_at(&p, 0.5, -0.5).color[0], plain / 2, 1e-6);
    p.source_material.base_color.image = NULL;
    assert_near(shade_at(&p, 0.5, -0.5).color[0], 0.5, 1e-6);
    assert_near(shade_at(&p, 0.5, -0.5).color[1], 1, 1e-6);
    painted_free(&p);
}

static void test_finish_and_emissive(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 1, 16, ramps);
    p.source_material.metallic_roughness = (psplat_texture_info){.image = &p.image};
    p.source_material.occlusion = (psplat_texture_info){.image = &p.image, .strength = 0.25f};
    p.source_material.emissive = (psplat_texture_info){.image = &p.image};
    psplat_baked_point shade = shade_at(&p, 0.5, -0.5);
    /* These images hold linear values. */
    double red = 16 * 11.5 / 255, green = red, blue = 1 - red;
    assert_near(shade.finish[0], 1 + 0.25 * (red - 1), 1e-5);
    assert_near(shade.finish[1], green, 1e-5);
    assert_near(shade.finish[2], blue, 1e-5);
    assert_true(fabs((double)shade.emissive[0] - red) > 0.1);
    assert_near(shade.color[0], 1, 0);
    painted_free(&p);
}

static void test_normal_map(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 1, 4, leaning);
    p.source_material.normal = (psplat_texture_info){.image = &p.image, .strength = 1};
    const double expected[3] = {0.6, 0.2, 2 * 230 / 255.0 - 1};
    double length =
        sqrt(expected[0] * expected[0] + expected[1] * expected[1] + expected[2] * expected[2]);
    psplat_baked_point shade = shade_at(&p, 0.5, -0.5);
    for (int k = 0; k < 3; ++k) assert_near(shade.normal[k], expected[k] / length, 1e-5);
    /* The normal map counts twice as much. */
    p.source_material.normal.strength = 2;
    shade = shade_at(&p, 0.5, -0.5);
    assert_near(shade.normal[0] / shade.normal[2], 2 * expected[0] / expected[2], 1e-5);
    p.source_material.normal.strength = 1;
    /* The image is mirrored in x: the normal leans the other way in x, and still up in y. */
    const double mirrored[6] = {-1, 0, 1, 0, 1, 0};
    memcpy(p.source_material.normal.transform, mirrored, sizeof mirrored);
    shade = shade_at(&p, 0.5, -0.5);
    assert_near(shade.normal[0], -expected[0] / length, 1e-5);
    assert_near(shade.normal[1], expected[1] / length, 1e-5);
    /* The image is turned by a quarter: its right is up on the square, and its up is left. */
    const double turned[6] = {0, 1, 0, -1, 0, 1};
    memcpy(p.source_material.normal.transform, turned, sizeof turned);
    shade = shade_at(&p, 0.5, -0.5);
    assert_near(shade.normal[0], expected[1] / length, 1e-5);
    assert_near(shade.normal[1], -expected[0] / length, 1e-5);
    painted_free(&p);
}

/* Tangents of the file take precedence over those derived from texture coordinates. */
static void test_tangents(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 1, 4, leaning);
    p.source_material.normal = (psplat_texture_info){.image = &p.image, .strength = 1};
    p.mesh.corner_tangents = calloc(24, sizeof(float));
    assert_non_null(p.mesh.corner_tangents);
    for (int i = 0; i < 6; ++i) {
        /* Tangents point along y; the bitangent n x t * w = (0, 0, 1) x (0, 1, 0) * -1 is x. */
        p.mesh.corner_tangents[4 * i + 1] = 1;
        p.mesh.corner_tangents[4 * i + 3] = -1;
    }
    psplat_baked_point shade = shade_at(&p, 0.5, -0.5);
    assert_near(shade.normal[1] / shade.normal[0], 3, 1e-4); /* 0.6 along y over 0.2 along x */
    assert_true(shade.normal[0] > 0);
    painted_free(&p);
}

/* Where all texture coordinates are equal, NaN or missing, the normal map has no effect, and all
 * values are finite. */
static void test_degenerate(void **state) {
    (void)state;
    painted p;
    painted_make(&p, 1, 4, leaning);
    p.source_material.normal = (psplat_texture_info){.image = &p.image, .strength = 1};
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    for (int i = 0; i < 12; ++i) p.mesh.corner_uvs[0][i] = 0.3f;
    psplat_baked_point shade = shade_at(&p, 0.5, -0.5);
    assert_memory_equal(shade.normal, up, sizeof up);
    assert_near(shade.color[0], psplat_linear_of_srgb(0.8f), 1e-5);
    for (int i = 0; i < 12; ++i) p.mesh.corner_uvs[0][i] = NAN;
    shade = shade_at(&p, 0.5, -0.5);
    for (int k = 0; k < 3; ++k) assert_true(isfinite(shade.normal[k]) && isfinite(shade.color[k]));
    p.source_material.normal.texcoord = 1; /* There is no second set of coordinates. */
    p.source_material.base_color.texcoord = 1;
    shade = shade_at(&p, 0.5, -0.5);
    assert_near(shade.color[0], 1, 0);
    painted_free(&p);
}

static void test_what_varies(void **state) {
    (void)state;
    painted p;
    psplat_appearance appearance;
    psplat_image unreadable = {0};
    painted_make(&p, 1, 4, ramps);
    p.source_material.base_color = (psplat_texture_info){.image = &unreadable};
    p.source_material.emissive = (psplat_texture_info){.image = &p.image};
    assert_int_equal(psplat_appearance_build(&p.mesh, 1e-6, 0, &appearance), PSPLAT_OK);
    assert_false(appearance.has_color || appearance.has_normals || appearance.has_finish);
    assert_true(appearance.has_emissive);
    psplat_appearance_free(&appearance);
    /* Two uses of an image with one encoding share a mipmap; a use with the other encoding has
     * another. */
    p.source_material.base_color.image = &p.image;
    p.source_material.metallic_roughness.image = &p.image;
    assert_int_equal(psplat_appearance_build(&p.mesh, 1e-6, 0, &appearance), PSPLAT_OK);
    assert_int_equal(appearance.mipmap_count, 2);
    psplat_appearance_free(&appearance);
    p.mesh.source_materials = NULL;
    p.mesh.source_material_count = 0;
    assert_int_equal(psplat_appearance_build(&p.mesh, 1e-6, 0, &appearance), PSPLAT_OK);
    assert_false(appearance.has_color || appearance.has_emissive);
    psplat_appearance_free(&appearance);
    painted_free(&p);
}

static void test_alpha(void **state) {
    (void)state;
    painted p;
    psplat_appearance appearance;
    double barycentric[3];
    painted_make(&p, 1, 16, ramps);
    p.source_material.base_color = (psplat_texture_info){.image = &p.image};
    p.source_material.material.base_color[3] = 0.5f;
    at(0.5, -0.5, barycentric);
    assert_int_equal(psplat_appearance_build(&p.mesh, 1e-6, 0, &appearance), PSPLAT_OK);
    assert_near(psplat_appearance_alpha(&appearance, 0, barycentric), 1, 0);
    p.source_material.is_masked = 1;
    assert_near(psplat_appearance_alpha(&appearance, 0, barycentric), (1 - 16 * 11.5 / 255) / 2,
                1e-5);
    psplat_appearance_free(&appearance);
    painted_free(&p);
}

int test_appearance_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_base_color),
        cmocka_unit_test(test_diameter),
        cmocka_unit_test(test_vertex_colors_multiply),
        cmocka_unit_test(test_finish_and_emissive),
        cmocka_unit_test(test_normal_map),
        cmocka_unit_test(test_tangents),
        cmocka_unit_test(test_degenerate),
        cmocka_unit_test(test_what_varies),
        cmocka_unit_test(test_alpha),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
