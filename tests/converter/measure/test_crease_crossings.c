/* SPDX-License-Identifier: MIT
 *
 * test_crease_crossings.c - tests of which creases inside a splat count: those of its own sheet, on
 * its surface and facing its way, beyond which it shows something that is not there.
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
#include "base/region.h"
#include "base/region_tree.h"
#include "base/vector.h"
#include "features/samples.h"
#include "measure/crease_crossings.h"
#include "measure/measured_splats.h"
#include "mesh/mesh.h"

/* Returns how many crossings of one region deeper than limit there are, of sheets with more than a
 * share of the votes of that with most, or of that which it grew from, unless that is PSPLAT_NONE.
 * Stores the greatest depth. */
static size_t crossings_of_grown(const fixture *f, psplat_region *region, uint32_t material,
                                 uint32_t grown, double tolerance, double limit, double share,
                                 double *greatest) {
    psplat_blend_field field = {.kernel = {2, 2}, .depth = HUGE_VAL};
    psplat_measured_splats measured = {.regions = region,
                                       .fields = &field,
                                       .materials = &material,
                                       .triangles = grown == PSPLAT_NONE ? NULL : &grown,
                                       .count = 1,
                                       .tolerance = tolerance};
    psplat_crease_crossing *found;
    size_t count;
    measured.region_tree = psplat_region_tree_create(region, 1, tolerance);
    assert_non_null(measured.region_tree);
    assert_int_equal(psplat_crease_crossings_find(&f->surface, &f->samples, &measured, limit, share,
                                                  &found, &count, greatest),
                     PSPLAT_OK);
    for (size_t i = 0; i < count; ++i) assert_true(found[i].depth > limit);
    for (size_t i = 1; i < count; ++i) assert_true(found[i - 1].edge < found[i].edge);
    free(found);
    psplat_region_tree_destroy(measured.region_tree);
    return count;
}

static size_t crossings_of_sheets(const fixture *f, psplat_region *region, uint32_t material,
                                  double tolerance, double limit, double share, double *greatest) {
    return crossings_of_grown(f, region, material, PSPLAT_NONE, tolerance, limit, share, greatest);
}

static size_t crossings(const fixture *f, psplat_region *region, uint32_t material,
                        double tolerance, double limit, double *greatest) {
    return crossings_of_sheets(f, region, material, tolerance, limit, 1, greatest);
}

static psplat_region level_region(double ru, double rv) {
    return (psplat_region){.u = {1, 0, 0}, .v = {0, 1, 0}, .n = {0, 0, 1}, .radius = {ru, rv}};
}

/* ---- on the surface -------------------------------------------------------------------------- */

static double rise;
static void place_strip(double s, double t, double p[3]) {
    /* It is tilted, so that its box meets that of the splat. */
    p[0] = 0.5 + 0.2 * s, p[1] = 2 * t - 1, p[2] = rise + 0.08 * p[1];
}

/* A splat that is as steep outside its ellipse as a slope of 30, and a straight border that passes
 * over it by 2.5 tolerances at its nearest: it is not on the splat's surface. Lowered onto it, it
 * is, but not where its triangles face down. */
static void test_on_surface(void **state) {
    (void)state;
    const double tolerance = 0.02;
    for (int kind = 0; kind < 3; ++kind) {
        fixture f;
        rise = kind == 0 ? -2.5 * tolerance : 0;
        fixture_grid(&f, 1, 1, place_strip);
        for (size_t t = 0; t < 2 && kind == 2; ++t) {
            uint32_t *c = f.mesh.triangles + 3 * t, swap = c[1];
            c[1] = c[2], c[2] = swap;
        }
        fixture_build(&f);
        psplat_region r = level_region(1, 0.1);
        r.hessian[2] = 30;
        double greatest;
        size_t count = crossings(&f, &r, 0, tolerance, 0.01, &greatest);
        if (kind == 1) {
            /* At x = 0.5 the ellipse ends at y = 0.087, and at x = 0.7 at 0.071. */
            assert_true(count > 0);
            assert_true(greatest > 0.06 && greatest < 0.1);
        } else {
            assert_int_equal(count, 0);
            /* Neither is it reported as one that is not too deep. */
            assert_int_equal(crossings(&f, &r, 0, tolerance, 0.2, &greatest), 0);
            assert_near(greatest, 0, 0);
        }
        fixture_free(&f);
    }
}

/* ---- of its own sheet ------------------------------------------------------------------------ */

/* A ramp of two turns, of which one lies above the other by less than the tolerance. */
static void place_ramp(double s, double t, double p[3]) {
    double angle = 4 * fixture_pi * s, radius = 2 - t;
    p[0] = radius * cos(angle), p[1] = radius * sin(angle), p[2] = 0.004 * angle;
}

/* In the middle of the ramp its two ends are within the tolerance, above and below. They are of the
 * same patch, but of other sheets than the splat's. The splat has another material than the ramp,
 * so that nothing else lets a crossing pass. */
static void test_own_sheet(void **state) {
    (void)state;
    fixture f;
    fixture_grid(&f, 120, 6, place_ramp);
    fixture_build(&f);
    assert_int_equal(f.surface.patch_count, 1);
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 20000, 7, &f.samples, NULL),
                     PSPLAT_OK);
    psplat_region r = level_region(0.3, 0.3);
    r.center[0] = 1.5, r.center[2] = 0.004 * 2 * fixture_pi;
    double greatest;
    assert_int_equal(crossings(&f, &r, 1, 0.03, 0.1, &greatest), 0);
    /* Each end covers half of it: about half as many samples as the turn between them. */
    assert_int_equal(crossings_of_sheets(&f, &r, 1, 0.03, 0.1, 0.6, &greatest), 0);
    assert_true(crossings_of_sheets(&f, &r, 1, 0.03, 0.1, 0.4, &greatest) > 1);
    assert_near(greatest, 0.3, 0.01); /* They pass below and above its centre. */
    /* It may have grown from one of these. */
    assert_int_equal(crossings_of_grown(&f, &r, 1, 840, 0.03, 0.1, 1, &greatest), 0);
    assert_true(crossings_of_grown(&f, &r, 1, 720, 0.03, 0.1, 1, &greatest) > 1);
    /* Few samples tell nothing about sheets with about as many. */
    psplat_samples all = f.samples;
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 1000, 7, &f.samples, NULL), PSPLAT_OK);
    assert_true(crossings_of_sheets(&f, &r, 1, 0.03, 0.1, 0.6, &greatest) > 1);
    assert_int_equal(crossings(&f, &r, 1, 0.03, 0.1, &greatest), 0);
    psplat_samples_free(&f.samples);
    f.samples = all;
    /* A splat at the inner border crosses it. */
    r.center[0] = 1.05;
    assert_true(crossings(&f, &r, 1, 0.03, 0.1, &greatest) > 0);
    fixture_free(&f);
}

/* ---- of its own material --------------------------------------------------------------------- */

/* Six rectangles of their own, which the bridges between them join far below: a post of 0.2 by 2,
 * and on both sides of it, half a tolerance above and below, a sheet that ends at y = 0.1. */
static void place_layers(double s, double t, double p[3]) {
    int column = (int)(s * 5 + 0.5), layer = column / 2;
    double low[3] = {-0.1, -1, -1}, high[3] = {0.1, 1, 1}, top[3] = {1, 0.1, 0.1};
    static const double heights[3] = {0, 0.01, -0.01};
    p[0] = column % 2 ? high[layer] : low[layer];
    p[1] = -1 + t * (top[layer] + 1);
    p[2] = heights[layer];
}

/* The triangles of the bridges, columns 1 and 3, are dropped. */
static void make_layers(fixture *f, uint32_t *groups) {
    size_t kept = 0;
    fixture_grid(f, 5, 1, place_layers);
    for (size_t i = 0; i < f->mesh.triangle_count; ++i) {
        if (i / 2 % 2) continue;
        memmove(f->mesh.triangles + 3 * kept, f->mesh.triangles + 3 * i, 3 * sizeof(uint32_t));
        groups[kept++] = i >= 2;
    }
    f->mesh.triangle_count = kept;
}

/* Returns whether there are crossings of a splat of a material in layers of materials. */
static int crosses(const fixture *f, psplat_region region, uint32_t material, double share) {
    double greatest;
    return crossings_of_sheets(f, &region, material, 0.02, 0.04, share, &greatest) > 0;
}

/* A tall splat ends a little beyond the sides of the post, and the ends of the sheets lie deep in
 * it; a wide one ends a little beyond those ends, and the sides of the post lie deep in it. All of
 * these lie within the tolerance of both. Only those count that are of the splat's own material:
 * also where most of what it covers is of another, and where all is. */
static void test_own_material(void **state) {
    (void)state;
    fixture f;
    uint32_t groups[6];
    psplat_source_material materials[2] = {{.material = {.base_color = {1, 0, 0, 1}}},
                                           {.material = {.base_color = {0, 1, 0, 1}}}};
    make_layers(&f, groups);
    fixture_build(&f);
    assert_int_equal(psplat_samples_draw_uniform(&f.surface, 20000, 7, &f.samples, NULL),
                     PSPLAT_OK);
    psplat_region tall = level_region(0.139, 0.3), wide = level_region(0.3, 0.109);
    psplat_region round = level_region(0.3, 0.3), beside = level_region(0.3, 0.2);
    wide.center[1] = 0.03, round.center[1] = -0.5;
    beside.center[0] = 0.6, beside.center[1] = 0.03;
    f.mesh.groups = groups;
    f.mesh.source_materials = materials, f.mesh.source_material_count = 2;
    assert_false(crosses(&f, tall, 0, 0.4));
    assert_true(crosses(&f, tall, 1, 0.4));
    assert_false(crosses(&f, wide, 1, 0.1));
    assert_true(crosses(&f, wide, 0, 0.1));
    assert_true(crosses(&f, round, 0, 1));
    assert_false(crosses(&f, beside, 0, 1));
    assert_true(crosses(&f, beside, 1, 1));
    f.mesh.groups = NULL, f.mesh.source_materials = NULL, f.mesh.source_material_count = 0;
    fixture_free(&f);
}

/* ---- seen ------------------------------------------------------------------------------------ */

static double fold;
static void place_fold(double s, double t, double p[3]) {
    double x = 2 * s - 1;
    p[0] = x < 0 ? x : x * cos(fold), p[1] = 2 * t - 1, p[2] = x < 0 ? 0 : -x * sin(fold);
}

/* Two squares of two groups meet at a crease. A splat of the first reaches over it by 0.08. Returns
 * whether that counts. */
static int is_counted(double angle, int is_painted, double tolerance, double *greatest) {
    fixture f;
    uint32_t groups[] = {0, 0, 1, 1};
    psplat_source_material materials[2] = {{.material = {.base_color = {1, 0, 0, 1}}},
                                           {.material = {.base_color = {0, 1, 0, 1}}}};
    fold = angle;
    fixture_grid(&f, 2, 1, place_fold);
    f.mesh.groups = groups;
    if (is_painted) f.mesh.source_materials = materials, f.mesh.source_material_count = 2;
    fixture_build(&f);
    assert_int_equal(f.surface.patch_count, 2);
    fixture_sample(&f, 0.05);
    psplat_region r = level_region(0.4, 0.3);
    r.center[0] = -0.32;
    int counted = crossings(&f, &r, 0, tolerance, tolerance, greatest) > 0;
    f.mesh.groups = NULL, f.mesh.source_materials = NULL, f.mesh.source_material_count = 0;
    fixture_free(&f);
    return counted;
}

/* What a splat shows beyond a crease is seen to be wrong where the surface turns by 30 degrees or
 * more, ends or is of another material; not where it just goes on. */
static void test_seen(void **state) {
    (void)state;
    const double degree = fixture_pi / 180;
    double greatest;
    assert_int_equal(is_counted(0, 0, 0.02, &greatest), 0);
    assert_int_equal(is_counted(10 * degree, 0, 0.02, &greatest), 0);
    assert_int_equal(is_counted(35 * degree, 0, 0.02, &greatest), 1);
    /* The outline's polygon has 64 sides. */
    assert_near(greatest, 0.08, 0.001);
    assert_int_equal(is_counted(0, 1, 0.02, &greatest), 1);
    /* At 20 degrees the second square is more than a tolerance away where the splat ends. */
    assert_int_equal(is_counted(20 * degree, 0, 0.02, &greatest), 1);
    /* Within 0.05 it is not, up to 38 degrees: normals alone decide. */
    assert_int_equal(is_counted(25 * degree, 0, 0.05, &greatest), 0);
    assert_int_equal(is_counted(35 * degree, 0, 0.05, &greatest), 1);
}

int test_crease_crossings_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_on_surface),
        cmocka_unit_test(test_own_sheet),
        cmocka_unit_test(test_own_material),
        cmocka_unit_test(test_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
