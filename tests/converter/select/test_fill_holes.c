/* SPDX-License-Identifier: MIT
 *
 * test_fill_holes.c - tests of finding and closing holes between splats, whatever their cause:
 * splats without overlap, a lost splat, a hole in the mesh itself. Coverage is checked with 200,000
 * fresh samples; where there is no hole, nothing may change.
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
#include "fit/fit_context.h"
#include "base/region.h"
#include "base/vector.h"
#include "fit/candidate.h"
#include "features/samples.h"
#include "select/conversion.h"
#include "select/fill_holes.h"
#include "select/greedy_cover.h"
#include "select/selection.h"
#include "select/sort_splats.h"
#include "splats/splats.h"

typedef struct repair {
    fixture f;
    psplat_convert_desc desc;
    psplat_conversion c;
    psplat_splats splats;
} repair;

/* Runs the stages before fill_holes.c, with this spacing of samples and this overlap of splats,
 * which are flat where planar is 1.
 * tolerance and spacing are in diagonals, margin in spacings. */
static void repair_begin(repair *r, double tolerance, double spacing, double margin, int planar) {
    fixture_sample(&r->f, spacing);
    r->desc = (psplat_convert_desc){0};
    r->splats = (psplat_splats){0};
    r->c = (psplat_conversion){.desc = &r->desc,
                               .surface = r->f.surface,
                               .samples = r->f.samples,
                               .distance = r->f.distance,
                               .splats = &r->splats,
                               .tolerance = tolerance * r->f.surface.diagonal};
    r->c.limits = (psplat_limits){.tolerance = 0.98 * r->c.tolerance,
                                  .crease_tolerance = 0.5 * r->c.tolerance,
                                  .crease_slack = 0.3 * r->c.tolerance,
                                  .margin = margin * r->f.samples.spacing,
                                  .planar = planar,
                                  .distance = r->f.distance};
    const psplat_fit_context context = psplat_conversion_context(&r->c);
    assert_int_equal(psplat_greedy_cover(&context, &r->desc, &r->c.selection, NULL), PSPLAT_OK);
    assert_int_equal(fixture_improve(&r->c.selection, r->c.samples.count, 0, 0, 0), PSPLAT_OK);
    assert_int_equal(psplat_sort_splats(&r->c.selection, &(psplat_sort_desc){0}, &r->splats),
                     PSPLAT_OK);
}

static void repair_end(repair *r) {
    psplat_splats_free(&r->splats);
    psplat_selection_free(&r->c.selection);
    psplat_hole_memory_free(&r->c.hole_memory);
    r->f.samples = r->c.samples; /* fill_holes.c has appended samples. */
    fixture_free(&r->f);
}

/* Returns how many of 200,000 fresh samples no splat covers. */
static size_t count_holes(const repair *r) {
    enum { PROBES = 200000 };
    psplat_samples probes;
    uint8_t *open = malloc(2 * PROBES);
    assert_non_null(open);
    assert_int_equal(psplat_samples_draw_uniform(&r->c.surface, PROBES, 99, &probes, NULL),
                     PSPLAT_OK);
    assert_true(probes.count < 2 * PROBES);
    size_t holes = fixture_open(&probes, &r->splats, r->c.tolerance, open);
    psplat_samples_free(&probes);
    free(open);
    return holes;
}

/* Fills the holes and asserts the result: no fresh sample is open, earlier samples keep their
 * places, and the splats are the candidates taken. Returns the number of samples added. */
static size_t repair_and_check(repair *r) {
    size_t before = r->c.samples.count;
    double *positions = malloc(before * 3 * sizeof *positions);
    assert_non_null(positions);
    memcpy(positions, r->c.samples.positions, before * 3 * sizeof *positions);
    assert_int_equal(psplat_fill_holes(&r->c, NULL), PSPLAT_OK);
    assert_memory_equal(r->c.samples.positions, positions, before * 3 * sizeof *positions);
    assert_int_equal(psplat_selection_taken(&r->c.selection), r->splats.count);
    assert_int_equal(count_holes(r), 0);
    free(positions);
    return r->c.samples.count - before;
}

/* Splats without overlap, on samples far apart, leave holes between samples. */
static void test_gaps(void **state) {
    (void)state;
    const char *names[] = {"sphere.ply", "torus.off"};
    for (int i = 0; i < 4; ++i) {
        repair r;
        int planar = i % 2;
        fixture_model(&r.f, names[i / 2]);
        repair_begin(&r, 0.03, 0.03, 0, planar);
        size_t holes = count_holes(&r), splats = r.splats.count;
        if (planar) assert_true(holes > 10); /* A few curved splats have few seams. */
        size_t added = repair_and_check(&r);
        print_message("%s: %zu holes, %zu samples added, %zu splats became %zu\n", names[i / 2],
                      holes, added, splats, r.splats.count);
        assert_int_equal(added > 0, holes > 0);
        repair_end(&r);
    }
}

/* A splat that is missing leaves a hole much larger than the sample spacing. */
static void test_lost(void **state) {
    (void)state;
    repair r;
    fixture_model(&r.f, "sphere.ply");
    repair_begin(&r, 0.04, 0.02, 0.4, 1);
    size_t lost = 0, splats = r.splats.count;
    const psplat_candidate *candidates = r.c.selection.candidates;
    for (size_t i = 0; i < r.c.selection.count; ++i)
        if (candidates[i].taken && (!candidates[lost].taken ||
                                    candidates[i].covered_count > candidates[lost].covered_count))
            lost = i;
    r.c.selection.candidates[lost].taken = 0;
    psplat_selection_drop_untaken(&r.c.selection); /* The pool must not hold it either. */
    assert_int_equal(psplat_sort_splats(&r.c.selection, &(psplat_sort_desc){0}, &r.splats),
                     PSPLAT_OK);
    assert_true(count_holes(&r) > 50); /* Other splats cover the rest of its area. */
    assert_true(repair_and_check(&r) > 0);
    assert_in_range(r.splats.count, splats, splats + 4);
    repair_end(&r);
}

/* Where splats leave no hole, no sample and no splat is added, and a second run changes nothing. */
static void test_nothing(void **state) {
    (void)state;
    repair r;
    fixture_model(&r.f, "cube.off");
    repair_begin(&r, 0.02, 0.02, 0.4, 1);
    assert_int_equal(count_holes(&r), 0);
    assert_int_equal(repair_and_check(&r), 0);
    psplat_splat kept[6];
    assert_int_equal(r.splats.count, 6);
    memcpy(kept, r.splats.splats, sizeof kept);
    assert_int_equal(repair_and_check(&r), 0);
    assert_int_equal(r.splats.count, 6);
    assert_memory_equal(kept, r.splats.splats, sizeof kept);
    repair_end(&r);
}

/* Places a square with a square hole, which is part of the mesh and must stay open. */
static void place_square(double s, double t, double p[3]) {
    p[0] = 4 * s - 2, p[1] = 4 * t - 2, p[2] = 0;
}

static void test_open_mesh(void **state) {
    (void)state;
    repair r;
    fixture_grid(&r.f, 8, 8, place_square);
    size_t kept = 0;
    for (size_t t = 0; t < r.f.mesh.triangle_count; ++t) {
        const uint32_t *v = r.f.mesh.triangles + 3 * t;
        int inside = 1;
        for (int k = 0; k < 3; ++k)
            for (int a = 0; a < 2; ++a)
                inside &= fabs(r.f.mesh.positions[3 * (size_t)v[k] + (size_t)a]) < 1.01;
        if (!inside) memmove(r.f.mesh.triangles + 3 * kept++, v, 3 * sizeof *v);
    }
    r.f.mesh.triangle_count = kept;
    fixture_build(&r.f);
    repair_begin(&r, 0.01, 0.01, 0, 1);
    repair_and_check(&r);
    /* No splat reaches into the hole by more than the tolerance. */
    psplat_region *regions = psplat_splat_regions(&r.splats);
    assert_non_null(regions);
    for (size_t i = 0; i < r.splats.count; ++i) {
        double points[PSPLAT_REGION_POINTS][3];
        size_t count = psplat_region_points(&regions[i], points);
        for (size_t k = 0; k < count; ++k)
            assert_true(max2(fabs(points[k][0]), fabs(points[k][1])) >=
                        1 - r.c.tolerance * (1 + 1e-6));
    }
    free(regions);
    repair_end(&r);
}

static int stop_at_once(void *user, const char *stage, double fraction) {
    (void)user;
    (void)stage;
    (void)fraction;
    return 1;
}

static void test_interrupted(void **state) {
    (void)state;
    repair r;
    psplat_error error = {0};
    fixture_model(&r.f, "cube.off");
    repair_begin(&r, 0.02, 0.02, 0.4, 1);
    r.desc.progress = stop_at_once;
    assert_int_equal(psplat_fill_holes(&r.c, &error), PSPLAT_ERROR_INTERRUPTED);
    assert_int_equal(error.code, PSPLAT_ERROR_INTERRUPTED);
    repair_end(&r);
}

/* The last holes are filled without exchanging any candidate. */
static void test_last(void **state) {
    (void)state;
    repair r;
    fixture_model(&r.f, "torus.off");
    repair_begin(&r, 0.03, 0.03, 0, 1);
    psplat_selection_drop_untaken(&r.c.selection);
    size_t splats = r.c.selection.count;
    double(*centers)[3] = malloc(splats * sizeof *centers);
    assert_non_null(centers);
    for (size_t i = 0; i < splats; ++i)
        memcpy(centers[i], r.c.selection.candidates[i].region.center, sizeof *centers);
    assert_true(count_holes(&r) > 10);
    assert_int_equal(psplat_fill_last_holes(&r.c, NULL), PSPLAT_OK);
    assert_int_equal(count_holes(&r), 0);
    assert_true(r.splats.count > splats);
    for (size_t i = 0; i < splats; ++i) {
        assert_true(r.c.selection.candidates[i].taken);
        assert_memory_equal(r.c.selection.candidates[i].region.center, centers[i], sizeof *centers);
    }
    free(centers);
    repair_end(&r);
}

int test_fill_holes_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gaps),      cmocka_unit_test(test_lost),
        cmocka_unit_test(test_last),      cmocka_unit_test(test_nothing),
        cmocka_unit_test(test_open_mesh), cmocka_unit_test(test_interrupted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
