/* SPDX-License-Identifier: MIT
 *
 * test_kept_textures.c - tests of which textures splats keep, and of what is baked besides. The
 * shape is a textured square; expected numbers follow from sizes and transforms by hand.
 */
#include "appearance_fixture.h"

#include "near.h"

#include <string.h>
#include "appearance/appearance.h"
#include "material/image.h"
#include "material/source_materials.h"

static void grey(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)x, (void)y;
    rgba[0] = rgba[1] = rgba[2] = 128, rgba[3] = 255;
}

/* Makes the square with base colour, finish and emission, described as the importers do. */
static void make(painted *p) {
    painted_make(p, 1, 16, grey);
    p->source_material.base_color = (psplat_texture_info){.image = &p->image};
    p->source_material.metallic_roughness = (psplat_texture_info){.image = &p->image};
    p->source_material.emissive = (psplat_texture_info){.image = &p->image};
    p->source_material.material.emissive[1] = 0.5f;
}

static psplat_appearance build(painted *p, int keeps) {
    psplat_source_materials materials = {.source_materials = &p->source_material,
                                         .source_material_count = 1,
                                         .images = &p->image,
                                         .image_count = 1};
    psplat_appearance appearance;
    psplat_source_materials_describe_textures(&materials);
    assert_int_equal(psplat_appearance_build(&p->mesh, 1e-6, keeps, &appearance), PSPLAT_OK);
    return appearance;
}

static void test_kept_is_not_baked(void **state) {
    (void)state;
    static const double middle[3] = {0.5, 0.25, 0.25};
    static const float up[3] = {0, 0, 1};
    painted p;
    psplat_baked_point baked;
    make(&p);
    psplat_appearance a = build(&p, 1);
    const psplat_kept_textures *kept = psplat_appearance_kept(&a, 1);
    assert_int_equal(a.kept_set, 0);
    assert_non_null(kept);
    assert_int_equal(kept->textures[PSPLAT_TEXTURE_BASE_COLOR].image, 1);
    assert_int_equal(kept->textures[PSPLAT_TEXTURE_NORMAL].image, 0);
    assert_near(kept->texels[0], 16, 0);
    assert_int_equal(kept->repeats[1], 1);
    assert_false(a.has_color || a.has_finish || a.has_emissive || a.has_normals);
    assert_int_equal(a.mipmap_count, 0);
    psplat_appearance_bake(&a, 0, middle, up, &baked);
    assert_near(baked.color[0], 1, 0);
    assert_near(baked.finish[1], 1, 0);
    psplat_appearance_free(&a);
    a = build(&p, 0);
    assert_int_equal(a.kept_set, PSPLAT_NONE);
    assert_null(psplat_appearance_kept(&a, 1));
    assert_true(a.has_color && a.has_finish && a.has_emissive);
    psplat_material m = p.source_material.material;
    assert_int_equal(m.textures[PSPLAT_TEXTURE_EMISSIVE].image, 1);
    psplat_appearance_settle_textures(&a, 0, &m);
    assert_int_equal(m.textures[PSPLAT_TEXTURE_EMISSIVE].image, 0);
    psplat_appearance_free(&a);
    painted_free(&p);
}

/* The base colour decides on the set, and what uses the other set is baked. Where there is no base
 * colour, most other textures decide. */
static void test_one_set(void **state) {
    (void)state;
    painted p;
    make(&p);
    p.mesh.corner_uvs[1] = calloc(12, sizeof(float));
    assert_non_null(p.mesh.corner_uvs[1]);
    p.source_material.base_color.texcoord = 1;
    psplat_appearance a = build(&p, 1);
    assert_int_equal(a.kept_set, 1);
    assert_false(a.has_color);
    assert_true(a.has_finish && a.has_emissive);
    psplat_appearance_free(&a);
    p.source_material.base_color.image = NULL;
    p.source_material.emissive.texcoord = 1;
    p.source_material.occlusion = p.source_material.metallic_roughness;
    a = build(&p, 1);
    assert_int_equal(a.kept_set, 0);
    assert_true(a.has_emissive && !a.has_finish);
    psplat_appearance_free(&a);
    /* A set that the mesh has not cannot be kept, as nothing can be read by it. */
    free(p.mesh.corner_uvs[1]);
    p.mesh.corner_uvs[1] = NULL;
    p.source_material.metallic_roughness.image = p.source_material.occlusion.image = NULL;
    a = build(&p, 1);
    assert_int_equal(a.kept_set, PSPLAT_NONE);
    assert_null(a.kept);
    psplat_appearance_free(&a);
    painted_free(&p);
}

/* A texture repeats where its own coordinates move by whole numbers, by even ones where it mirrors;
 * one that is clamped along t alone may still move along s. */
static void test_repeats_and_texels(void **state) {
    (void)state;
    static const struct {
        psplat_wrap wrap[2];
        double transform[6];
        int repeats[2];
        double texels[2];
    } cases[] = {
        {{PSPLAT_WRAP_REPEAT, PSPLAT_WRAP_MIRROR}, {1, 0, 0, 0, 1, 0}, {1, 2}, {16, 16}},
        {{PSPLAT_WRAP_REPEAT, PSPLAT_WRAP_CLAMP}, {1, 0, 0.3, 0, 1, 0}, {1, 0}, {16, 16}},
        {{PSPLAT_WRAP_REPEAT, PSPLAT_WRAP_REPEAT}, {3, 0, 0, 0, 0.5, 0}, {1, 2}, {48, 16}},
        {{PSPLAT_WRAP_REPEAT, PSPLAT_WRAP_REPEAT}, {0.4, 0, 0, 0, 1, 0}, {0, 1}, {16, 16}},
        /* A quarter turn: s runs along the clamped t of the image. */
        {{PSPLAT_WRAP_REPEAT, PSPLAT_WRAP_CLAMP}, {0, 2, 0, -1, 0, 0}, {0, 1}, {16, 32}},
        {{PSPLAT_WRAP_MIRROR, PSPLAT_WRAP_REPEAT}, {2, 0, 0, 0, 1, 0}, {1, 1}, {32, 16}},
    };
    painted p;
    make(&p);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        psplat_texture_info *texture = &p.source_material.emissive;
        memcpy(texture->wrap, cases[i].wrap, sizeof texture->wrap);
        memcpy(texture->transform, cases[i].transform, sizeof texture->transform);
        psplat_appearance a = build(&p, 1);
        const psplat_kept_textures *kept = psplat_appearance_kept(&a, 0);
        for (int k = 0; k < 2; ++k) {
            assert_int_equal(kept->repeats[k], cases[i].repeats[k]);
            assert_near(kept->texels[k], cases[i].texels[k], 1e-6); /* of single precision */
        }
        psplat_appearance_free(&a);
    }
    painted_free(&p);
}

/* Four columns of texels: 128, 128, 133 (5 steps, next to no difference) and 144. */
static void columns(uint32_t x, uint32_t y, uint8_t rgba[4]) {
    (void)y;
    rgba[0] = rgba[1] = rgba[3] = 255;
    rgba[2] = x / 4 < 2 ? 128 : x / 4 < 3 ? 133 : 144;
}

/* One channel of one of several textures tells places apart; an image without pixels tells nothing.
 */
static void test_shows_same(void **state) {
    (void)state;
    const double first[2] = {0.1, 0.5}, second[2] = {0.4, 0.2}, third[2] = {0.6, 0.5};
    const double fourth[2] = {0.9, 0.5};
    painted p;
    make(&p);
    psplat_image grey_image = p.image;
    painted other;
    painted_make(&other, 1, 16, columns);
    psplat_appearance a = build(&p, 1);
    assert_true(psplat_appearance_shows_same(&a, 0, first, fourth));
    p.source_material.emissive.image = &other.image;
    assert_true(psplat_appearance_shows_same(&a, 0, first, second));
    assert_true(psplat_appearance_shows_same(&a, 1, first, third));
    assert_false(psplat_appearance_shows_same(&a, 0, first, fourth));
    p.source_material.emissive.image = &grey_image;
    grey_image.pixels = NULL;
    assert_false(psplat_appearance_shows_same(&a, 0, first, second));
    psplat_appearance_free(&a);
    painted_free(&other);
    painted_free(&p);
}

int test_kept_textures_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kept_is_not_baked),
        cmocka_unit_test(test_one_set),
        cmocka_unit_test(test_repeats_and_texels),
        cmocka_unit_test(test_shows_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
