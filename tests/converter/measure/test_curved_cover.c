/* SPDX-License-Identifier: MIT
 *
 * test_curved_cover.c - tests of what curved splats and bent lines cover: holes between the corners
 * of triangles, normals that face away, and the fragments that a point's blend takes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <math.h>
#include <string.h>
#include <cmocka.h>

#include "stage_fixture.h"
#include "base/random.h"
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "measure/crease_crossings.h"
#include "measure/holes.h"
#include "measure/measured_splats.h"
#include "measure/point_blend.h"

static double between(uint64_t *random, double low, double high) {
    return low + (high - low) * psplat_random_unit(random);
}

/* One region, measured. */
typedef struct scene {
    psplat_region region;
    psplat_blend_field field;
    psplat_measured_splats measured;
} scene;

static void measure(scene *s, double tolerance) {
    s->field = (psplat_blend_field){.kernel = {2, 2}, .depth = HUGE_VAL};
    memcpy(s->field.normals[0], s->region.n, sizeof s->field.normals[0]);
    s->measured = (psplat_measured_splats){
        .regions = &s->region, .fields = &s->field, .count = 1, .tolerance = tolerance};
    s->measured.region_tree = psplat_region_tree_create(&s->region, 1, tolerance);
    assert_non_null(s->measured.region_tree);
}

static psplat_region level_region(double ru, double rv) {
    return (psplat_region){.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {ru, rv}};
}

/* The corners of the mesh are points of a region's surface, spread over a box of parameters. */
static const psplat_region *placed;
static double box_low[2], box_high[2];
static void place_on_surface(double s, double t, double p[3]) {
    const double uv[2] = {box_low[0] + s * (box_high[0] - box_low[0]),
                          box_low[1] + t * (box_high[1] - box_low[1])};
    psplat_region_point(placed, uv, p);
}

static int is_covered(const scene *s, const double p[3], const double normal[3]) {
    double uvh[3];
    psplat_region_local(&s->region, p, uvh);
    return psplat_measured_splats_cover(&s->measured, 0, normal, uvh);
}

/* Whether a point of a triangle, in barycentric coordinates, and all around it at a distance are
 * open. */
static int is_wide_open(const scene *s, const fixture *f, uint32_t triangle, const double at[3],
                        double step) {
    for (int k = 0; k < 9; ++k) {
        double b[3] = {at[0], at[1], at[2]}, p[3] = {0, 0, 0}, n[3] = {0, 0, 0};
        if (k < 8) b[0] += step * cos(k * fixture_pi / 4), b[1] += step * sin(k * fixture_pi / 4);
        b[2] = 1 - b[0] - b[1];
        for (size_t i = 0; i < 3; ++i) {
            const float *normal = f->surface.corner_normals + 9 * (size_t)triangle + 3 * i;
            mad3(p, b[i], f->mesh.positions + 3 * f->mesh.triangles[3 * (size_t)triangle + i]);
            for (int c = 0; c < 3; ++c) n[c] += b[i] * (double)normal[c];
            if (b[i] < 0) return 0;
        }
        if (is_covered(s, p, n)) return 0;
    }
    return 1;
}

/* Wherever points are open all around, a hole is found. */
static void test_holes(void **state) {
    (void)state;
    uint64_t random = 51;
    int with_holes = 0, without = 0;
    for (uint32_t turn = 0; turn < 150; ++turn) {
        scene s = {.region = level_region(1, between(&random, 0.5, 1))};
        psplat_region *r = &s.region;
        double steep = turn % 5 ? between(&random, 0, 1.5) : 0;
        random_axes(&random, r->u, r->v, r->n);
        for (int k = 0; k < 2; ++k) r->slope[k] = steep * between(&random, -0.4, 0.4);
        for (int k = 0; k < 3; ++k) r->hessian[k] = steep * between(&random, -1, 1);
        r->line_count = turn % 3;
        for (uint32_t i = 0; i < r->line_count; ++i) {
            double angle = between(&random, 0, 2 * fixture_pi);
            r->lines[i][0] = cos(angle), r->lines[i][1] = sin(angle);
            r->lines[i][2] = between(&random, 0.3, 0.7), r->bends[i] = between(&random, -4, 4);
        }
        placed = r;
        for (int k = 0; k < 2; ++k) box_low[k] = -between(&random, 0.1, 0.7);
        for (int k = 0; k < 2; ++k) box_high[k] = between(&random, 0.1, 0.7);
        fixture f;
        psplat_holes holes;
        fixture_grid(&f, 1 + turn % 2, 1, place_on_surface);
        fixture_build(&f);
        measure(&s, between(&random, 0.01, 0.2));
        assert_int_equal(psplat_holes_find(&f.surface, &s.measured, 0.05, 0.005, &holes),
                         PSPLAT_OK);
        for (int i = 0; i < 400 && !holes.count; ++i) {
            double a = psplat_random_unit(&random), b = psplat_random_unit(&random);
            const double at[3] = {a + b > 1 ? 1 - a : a, a + b > 1 ? 1 - b : b, 0};
            assert_false(
                is_wide_open(&s, &f, (uint32_t)i % (uint32_t)f.mesh.triangle_count, at, 0.02));
        }
        *(holes.count ? &with_holes : &without) += 1;
        psplat_holes_free(&holes);
        psplat_region_tree_destroy(s.measured.region_tree);
        fixture_free(&f);
    }
    assert_true(with_holes > 30 && without > 30);
}

/* A dome over a square of two triangles: they sag below it by 0.18 in their middles, and 0.06 where
 * a third of the diagonal lies on either side, so that what is covered ends between the corners. */
static void test_sagging(void **state) {
    (void)state;
    const double tolerances[] = {0.2, 0.1};
    for (int i = 0; i < 2; ++i) {
        scene s = {.region = level_region(1, 1)};
        s.region.hessian[0] = s.region.hessian[2] = -1;
        placed = &s.region;
        box_low[0] = box_low[1] = -0.42, box_high[0] = box_high[1] = 0.42;
        fixture f;
        psplat_holes holes;
        fixture_grid(&f, 1, 1, place_on_surface);
        fixture_build(&f);
        measure(&s, tolerances[i]);
        assert_int_equal(psplat_holes_find(&f.surface, &s.measured, 0.05, 0.005, &holes),
                         PSPLAT_OK);
        assert_int_equal(holes.count > 0, i);
        psplat_holes_free(&holes);
        psplat_region_tree_destroy(s.measured.region_tree);
        fixture_free(&f);
    }
}

/* A line that bulges in between the corners of a square leaves a hole; one that bulges out cuts off
 * its corners; a straight one does neither. */
static void test_bulging(void **state) {
    (void)state;
    for (int bend = -2; bend <= 2; ++bend) {
        scene s = {.region = level_region(1, 1)};
        s.region.line_count = 1; /* keeps u <= 0.45 where v = 0 */
        s.region.lines[0][0] = -1, s.region.lines[0][2] = bend > 0 ? 0.45 : 0.55;
        s.region.bends[0] = bend;
        placed = &s.region;
        box_low[0] = box_low[1] = -0.5, box_high[0] = box_high[1] = 0.5;
        fixture f;
        psplat_holes holes;
        fixture_grid(&f, 1, 1, place_on_surface);
        fixture_build(&f);
        measure(&s, 0.01);
        assert_int_equal(psplat_holes_find(&f.surface, &s.measured, 0.02, 0.002, &holes),
                         PSPLAT_OK);
        assert_int_equal(holes.count > 0, bend != 0);
        psplat_holes_free(&holes);
        psplat_region_tree_destroy(s.measured.region_tree);
        fixture_free(&f);
    }
}

/* The side of a steep splat covers what faces as it does, not as its axis does. */
static void test_facing(void **state) {
    (void)state;
    scene s = {.region = level_region(1, 1)};
    s.region.hessian[0] = -2;
    measure(&s, 0.01);
    const double uv[2] = {0.8, 0}, slanted[3] = {0.6, 0, -0.8}, back[3] = {-0.9, 0, 0.1};
    double p[3];
    psplat_region_point(&s.region, uv, p);
    assert_int_equal(is_covered(&s, p, slanted), 1);
    assert_int_equal(is_covered(&s, p, back), 0);
    psplat_region_tree_destroy(s.measured.region_tree);
}

/* The fragment of a curved splat at a point lies where the line along the normal meets its front:
 * points of the surface moved along any direction find their way back. */
static void test_blend(void **state) {
    (void)state;
    uint64_t random = 52;
    int met = 0;
    for (int turn = 0; turn < 300; ++turn) {
        scene s = {.region = level_region(1, 0.7)};
        psplat_region *r = &s.region;
        random_axes(&random, r->u, r->v, r->n);
        for (int k = 0; k < 2; ++k) r->slope[k] = between(&random, -0.5, 0.5);
        for (int k = 0; k < 3; ++k) r->hessian[k] = between(&random, -1.5, 1.5);
        measure(&s, 0.01);
        mad3(s.field.normals[1], 1, r->u); /* so that the blend tells u */
        double angle = between(&random, 0, 2 * fixture_pi), away = between(&random, -0.3, 0.3);
        double radius = between(&random, 0, 0.95), n[3], side[3];
        const double uv[2] = {radius * cos(angle), radius * sin(angle)};
        psplat_point_blend blend = {.measured = &s.measured, .reach = 0.4, .limit = -HUGE_VAL};
        psplat_region_normal(r, uv, n);
        memcpy(blend.normal, n, sizeof n);
        perpendicular3(side, n);
        mad3(blend.normal, between(&random, -1, 1), side);
        normalize3(blend.normal);
        psplat_region_point(r, uv, blend.point);
        mad3(blend.point, -away, blend.normal);
        psplat_point_blend_add(&blend, 0);
        psplat_region_tree_destroy(s.measured.region_tree);
        assert_true(blend.weight > 0);
        assert_near(blend.weight, exp(-2 * radius * radius), 1e-12);
        assert_near(dot3(blend.blended, r->u) / blend.weight, uv[0], 1e-12);
        s.field.depth = 0.1;
        psplat_point_blend_limit(&blend, 0);
        double cosine = dot3(n, blend.normal);
        assert_near(blend.limit, away - 0.1 / max2(cosine, 0.5), 1e-12);
        ++met;
    }
    assert_int_equal(met, 300);
}

/* ---- creases --------------------------------------------------------------------------------- */

/* A trough, 2 wide and 1.6 long, whose borders at x = -1 and 1 a splat of radii 1.3 and 0.7 passes.
 */
static void place_trough(double s, double t, double p[3]) {
    p[0] = 2 * s - 1, p[1] = 1.6 * t - 0.8, p[2] = 0.4 * p[0] * p[0] / 2;
}

/* Returns the greatest distance of points of the border x = 1, from inside, to the outline of a
 * region in its plane, both in small steps. */
static double deepest_of_border(const psplat_region *r) {
    double deepest = 0;
    for (int i = -200; i <= 200; ++i) {
        double y = 0.8 * i / 200, least = HUGE_VAL;
        const double uv[2] = {1 / r->radius[0], y / r->radius[1]};
        if (!psplat_region_contains(r, uv, 1, 0)) continue;
        for (int k = 0; k < 4000; ++k) {
            double at[2] = {cos(k * fixture_pi / 2000), sin(k * fixture_pi / 2000)};
            if (k % 2 && r->line_count) psplat_region_line_point(r, 0, k / 2000.0 - 1, at);
            if (!psplat_region_contains(r, at, 1 + 1e-9, 1e-9)) continue;
            least =
                min2(least, hypot((at[0] - uv[0]) * r->radius[0], (at[1] - uv[1]) * r->radius[1]));
        }
        deepest = max2(deepest, least);
    }
    return deepest;
}

/* Borders of a curved sheet that a curved splat passes are found, as deep as they lie within its
 * ellipse and behind lines of all bends; where the splat bends another way, they are too far away.
 */
static void test_crossings(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 12, 8, place_trough);
    fixture_build(&f);
    fixture_sample(&f, 0.02);
    for (int bend = -2; bend <= 3; ++bend) {
        scene s = {.region = level_region(1.3, 0.7)};
        psplat_crease_crossing *crossings;
        size_t count;
        double greatest;
        s.region.hessian[0] = bend == 3 ? -0.4 : 0.4;
        s.region.line_count = bend != 2;
        s.region.lines[0][0] = -1, s.region.lines[0][2] = 1 / 1.3 + 0.06, s.region.bends[0] = bend;
        measure(&s, 0.02);
        assert_int_equal(psplat_crease_crossings_find(&f.surface, &f.samples, &s.measured, 0.01, 1,
                                                      &crossings, &count, &greatest),
                         PSPLAT_OK);
        if (bend == 3) {
            assert_int_equal(count, 0);
        } else {
            /* At x = -1 no line cuts, so that the ellipse is deeper there. */
            double deepest = 0, expected = deepest_of_border(&s.region);
            for (size_t i = 0; i < count; ++i)
                if (crossings[i].point[0] > 0) deepest = max2(deepest, crossings[i].depth);
            assert_true(expected > 0.02);
            /* The outline has sides of a tenth of its radii, and the distance from a line is that
             * along its gradient. */
            assert_near(deepest, expected, 0.06 * expected);
        }
        free(crossings);
        psplat_region_tree_destroy(s.measured.region_tree);
    }
    fixture_free(&f);
}

int test_curved_cover_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_holes),   cmocka_unit_test(test_sagging),
        cmocka_unit_test(test_bulging), cmocka_unit_test(test_facing),
        cmocka_unit_test(test_blend),   cmocka_unit_test(test_crossings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
