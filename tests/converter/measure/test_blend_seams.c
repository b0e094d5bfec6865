/* SPDX-License-Identifier: MIT
 *
 * test_blend_seams.c - tests of what splats blend to beyond their seams: normals go on, and all
 * that is the material's weighs a 256th. Expected sums are those of spec eq. 6 for a disc and a
 * kernel that are known.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "near.h"
#include "base/region.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"
#include "splats/splats.h"

/* A disc of radius 1 in the plane z = 0 with two lines: the first keeps v >= -0.5, the second
 * u <= 0.25. Its normal leans with u, and its colour and finish change. */
typedef struct stage {
    psplat_splat splat;
    psplat_finish finish;
    psplat_run run;
    psplat_material material;
    psplat_splats splats;
    psplat_measured_splats measured;
} stage;

static void stage_begin(stage *s, uint32_t seams) {
    *s = (stage){.splat = {.normal = {0, 0, 1},
                           .rotation = {0, 0, 0, 1},
                           .radius = {1, 1},
                           .gradient = {0.5f, 0, 0},
                           .color = {0.75f, 0.5f, 0.25f, 1},
                           .clip = {{0, 1, 0.5f}, {-1, 0, 0.25f}},
                           .clip_count = 2},
                 .finish = {.color_u = {0.125f, 0, 0},
                            .occlusion = 1,
                            .roughness = 0.5f,
                            .metallic = 0.25f,
                            .emissive = {1, 0.5f, 0.25f}},
                 .run = {.count = 1, .clip_lines = 2, .seam_lines = seams}};
    s->material = (psplat_material){
        .base_color = {1, 1, 1, 1}, .emissive = {1, 1, 1}, .metallic = 1, .roughness = 1};
    s->splats = (psplat_splats){.splats = &s->splat,
                                .finishes = &s->finish,
                                .count = 1,
                                .runs = &s->run,
                                .run_count = 1,
                                .materials = &s->material,
                                .material_count = 1,
                                .kernel = {2, 2},
                                .has_color = 1};
    assert_int_equal(psplat_measured_splats_create(&s->splats, 0.01, 0.01, &s->measured),
                     PSPLAT_OK);
}

static psplat_point_blend blend_at(const stage *s, double x, double y) {
    psplat_point_blend blend = {.measured = &s->measured,
                                .point = {x, y, 0},
                                .normal = {0, 0, 1},
                                .reach = 0.01,
                                .limit = -HUGE_VAL};
    psplat_point_blend_add(&blend, 0);
    return blend;
}

/* Asserts the sums at a point, where a material has this part of the kernel's weight. */
static void assert_sums(const psplat_point_blend *b, double x, double y, double part) {
    double weight = exp(-2 * (x * x + y * y)), material = part * weight;
    const double normal[3] = {0.5 * x, 0, 1}, color[3] = {0.75 + 0.125 * x, 0.5, 0.25};
    const double finish[5] = {1, 0.5, 0.25, 0.5, 0.25};
    assert_near(b->weight, material, 1e-12);
    for (int k = 0; k < 3; ++k) {
        /* Numbers of this size in double precision, and floats that are exact. */
        assert_near(b->blended[k], weight * normal[k], 1e-12);
        assert_near(b->constant[k], k == 2 ? weight : 0, 1e-12);
        assert_near(b->color[k], material * color[k], 1e-12);
        assert_near(b->flat_color[k], material * (k == 0 ? 0.75 : color[k]), 1e-12);
    }
    for (int k = 0; k < 5; ++k) assert_near(b->finish[k], material * finish[k], 1e-12);
}

static void assert_nothing(const psplat_point_blend *b) {
    assert_true(b->weight == 0);
    for (int k = 0; k < 3; ++k) assert_true(b->blended[k] == 0 && b->color[k] == 0);
}

/* The points lie inside both lines, beyond the second, beyond the first, and beyond both. */
static void test_sums(void **state) {
    (void)state;
    const double points[4][2] = {{-0.25, 0.25}, {0.5, 0.25}, {-0.25, -0.75}, {0.5, -0.75}};
    for (uint32_t seams = 0; seams <= 2; ++seams) {
        stage s;
        stage_begin(&s, seams);
        for (int i = 0; i < 4; ++i) {
            double x = points[i][0], y = points[i][1];
            const int is_beyond_second = i & 1, is_beyond_first = i > 1;
            psplat_point_blend blend = blend_at(&s, x, y);
            if ((is_beyond_second && seams < 1) || (is_beyond_first && seams < 2))
                assert_nothing(&blend);
            else /* However many seams a point is beyond, it is beyond. */
                assert_sums(&blend, x, y, i ? 1.0 / 256 : 1);
        }
        psplat_measured_splats_free(&s.measured);
    }
}

/* Regions know their seams by the runs: those of later runs by their own, and splats behind the
 * last run have none. Runs that state more seams than a splat has lines make seams of all. */
static void test_regions_of_runs(void **state) {
    (void)state;
    psplat_splat splats[5] = {{.rotation = {0, 0, 0, 1}, .radius = {1, 1}}};
    const uint32_t lines[5] = {4, 4, 3, 2, 2}, seams[5] = {1, 1, 2, 2, 0};
    psplat_run runs[3] = {{.count = 2, .clip_lines = 4, .seam_lines = 1},
                          {.count = 1, .clip_lines = 3, .seam_lines = 2},
                          {.count = 1, .clip_lines = 2, .seam_lines = 3}};
    for (uint32_t i = 0; i < 5; ++i) {
        splats[i] = splats[0];
        splats[i].clip_count = lines[i];
        for (uint32_t k = 0; k < lines[i]; ++k) {
            splats[i].clip[k][2] = (float)(k + 1);
            splats[i].bend[k] = -(float)k;
        }
    }
    psplat_splats all = {.splats = splats, .count = 5, .runs = runs, .run_count = 3};
    psplat_region *regions = psplat_splat_regions(&all);
    assert_non_null(regions);
    for (uint32_t i = 0; i < 5; ++i) {
        assert_int_equal(regions[i].seam_count, seams[i]);
        assert_int_equal(regions[i].line_count, lines[i] - seams[i]);
        for (uint32_t k = 0; k < lines[i]; ++k) {
            assert_true(regions[i].lines[k][2] == k + 1);
            assert_true(regions[i].bends[k] == -(double)k);
        }
    }
    free(regions);
}

/* A part inside the seams is cut by them all, and by them alone where there are no other lines. */
static void test_inside_seams(void **state) {
    (void)state;
    stage s;
    for (uint32_t seams = 0; seams <= 2; ++seams) {
        stage_begin(&s, seams);
        const psplat_region *whole = &s.measured.regions[0];
        const psplat_region inside = psplat_region_inside_seams(whole);
        assert_int_equal(inside.line_count, 2);
        assert_int_equal(inside.seam_count, 0);
        for (int i = 0; i < 40; ++i) {
            const double uv[2] = {0.9 * cos(i), 0.9 * sin(i)};
            assert_int_equal(psplat_region_contains(&inside, uv, 1, 0),
                             psplat_region_contains(whole, uv, 1, 0) &&
                                 !psplat_region_is_beyond_seam(whole, uv));
        }
        assert_true(psplat_region_area(&inside) <= psplat_region_area(whole));
        assert_int_equal(psplat_region_area(&inside) < psplat_region_area(whole), seams > 0);
        psplat_measured_splats_free(&s.measured);
    }
}

int test_blend_seams_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums),
        cmocka_unit_test(test_regions_of_runs),
        cmocka_unit_test(test_inside_seams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
