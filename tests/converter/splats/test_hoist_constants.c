/* SPDX-License-Identifier: MIT
 *
 * test_hoist_constants.c - tests that a value which all splats of a material share moves into the
 * material's factor, and that values which differ stay. The splats are made by hand, three for each
 * of two materials.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "near.h"
#include "splats/hoist_constants.h"
#include "splats/splats.h"

enum { COUNT = 6 };

/* Makes two materials with three plain splats each, in two runs. */
static psplat_splats make(void) {
    psplat_splats s = {.splats = calloc(COUNT, sizeof *s.splats),
                       .finishes = calloc(COUNT, sizeof *s.finishes),
                       .count = COUNT,
                       .runs = calloc(2, sizeof *s.runs),
                       .run_count = 2,
                       .materials = calloc(2, sizeof *s.materials),
                       .material_count = 2,
                       .has_color = 1};
    assert_true(s.splats && s.finishes && s.runs && s.materials);
    for (int i = 0; i < COUNT; ++i) {
        for (int k = 0; k < 4; ++k) s.splats[i].color[k] = 1;
        s.finishes[i] =
            (psplat_finish){.occlusion = 1, .roughness = 1, .metallic = 1, .emissive = {1, 1, 1}};
    }
    for (uint32_t i = 0; i < 2; ++i) {
        s.runs[i] = (psplat_run){.count = COUNT / 2, .material = i};
        s.materials[i] = (psplat_material){.base_color = {0.5f, 0.5f, 0.5f, 1},
                                           .emissive = {2, 2, 2},
                                           .metallic = 0.5f,
                                           .roughness = 0.5f};
    }
    return s;
}

static void test_plain(void **state) {
    (void)state;
    psplat_splats s = make();
    assert_int_equal(psplat_hoist_constants(&s), PSPLAT_OK);
    assert_null(s.finishes);
    assert_false(s.has_color);
    assert_near(s.materials[1].base_color[2], 0.5, 0);
    assert_near(s.materials[1].emissive[0], 2, 0);
    psplat_splats_free(&s);
}

/* Without finishes colours do not change over a splat, so that they can move into the factor. */
static void test_without_finishes(void **state) {
    (void)state;
    psplat_splats s = make();
    free(s.finishes);
    s.finishes = NULL;
    for (int i = 0; i < COUNT; ++i) s.splats[i].color[1] = 0.5f;
    assert_int_equal(psplat_hoist_constants(&s), PSPLAT_OK);
    assert_null(s.finishes);
    assert_false(s.has_color);
    assert_near(s.materials[0].base_color[1], 0.25, 0);
    assert_near(s.splats[0].color[1], 1, 0);
    psplat_splats_free(&s);
}

/* All splats of one material agree in everything; those of the other agree in nothing. */
static void test_one_of_two(void **state) {
    (void)state;
    psplat_splats s = make();
    for (int i = 0; i < COUNT; ++i) {
        float differs = i < 3 ? 0.5f : 0.125f * (float)i;
        s.splats[i].color[1] = differs;
        s.finishes[i].roughness = differs;
        s.finishes[i].emissive[2] = differs;
    }
    assert_int_equal(psplat_hoist_constants(&s), PSPLAT_OK);
    assert_non_null(s.finishes);
    assert_true(s.has_color);
    assert_near(s.materials[0].base_color[1], 0.25, 0);
    assert_near(s.materials[0].base_color[0], 0.5, 0);
    assert_near(s.materials[0].roughness, 0.25, 0);
    assert_near(s.materials[0].emissive[2], 1, 0);
    assert_near(s.materials[1].base_color[1], 0.5, 0);
    assert_near(s.materials[1].roughness, 0.5, 0);
    for (int i = 0; i < COUNT; ++i) {
        float left = i < 3 ? 1 : 0.125f * (float)i;
        assert_near(s.splats[i].color[1], left, 0);
        assert_near(s.finishes[i].roughness, left, 0);
        assert_near(s.finishes[i].emissive[2], left, 0);
    }
    psplat_splats_free(&s);
}

/* Occlusion has no factor into which it could move, and a colour with a gradient stays. */
static void test_what_cannot_fold(void **state) {
    (void)state;
    psplat_splats s = make();
    for (int i = 0; i < COUNT; ++i) {
        s.finishes[i].occlusion = 0.5f;
        s.splats[i].color[0] = 0.5f;
        s.finishes[i].color_u[0] = i < 3 ? 0.25f : 0; /* equal in all three */
    }
    assert_int_equal(psplat_hoist_constants(&s), PSPLAT_OK);
    assert_true(s.finishes && s.has_color);
    assert_near(s.finishes[4].occlusion, 0.5, 0);
    assert_near(s.splats[0].color[0], 0.5, 0);
    assert_near(s.materials[0].base_color[0], 0.5, 0);
    assert_near(s.splats[5].color[0], 1, 0); /* of the other material */
    assert_near(s.materials[1].base_color[0], 0.25, 0);
    psplat_splats_free(&s);
}

int test_hoist_constants_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plain),
        cmocka_unit_test(test_without_finishes),
        cmocka_unit_test(test_one_of_two),
        cmocka_unit_test(test_what_cannot_fold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
