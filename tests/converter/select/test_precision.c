/* SPDX-License-Identifier: MIT
 *
 * test_precision.c - tests of the grid of quantization that a conversion chooses: none where floats
 * are requested or 16 bits do not suffice, and otherwise one that suits the tolerance. The shapes
 * are a cube and a tilted square, for which the number of splats is known.
 */
#include "mesh_fixture.h"

#include "stage_fixture.h"
#include "base/region.h"
#include "features/surface.h"
#include "fit/candidate.h"
#include "mesh/mesh.h"
#include "pipeline/convert.h"
#include "select/conversion.h"
#include "select/precision.h"
#include "select/selection.h"
#include "splats/splats.h"
#include "verify/report.h"

#include <math.h>

static psplat_splats convert(const psplat_mesh *mesh, double percent, double precision,
                             psplat_report *report) {
    const psplat_convert_desc desc = {
        .tolerance_percent = percent, .effort = PSPLAT_EFFORT_NONE, .precision = precision};
    psplat_splats splats;
    psplat_error error;
    if (psplat_convert(mesh, &desc, &splats, report, &error)) fail_msg("%s", error.text);
    return splats;
}

/* Places a square that is parallel to no axis. */
static void place_plane(double s, double t, double p[3]) {
    p[0] = s, p[1] = 0.8 * t, p[2] = 0.6 * t + 0.3 * s;
}

/* A flat model keeps one splat for each side, in its plane. */
static void test_flat(void **state) {
    (void)state;
    fixture plane, cube;
    fixture_grid(&plane, 2, 2, place_plane);
    fixture_model(&cube, "cube.off");
    psplat_mesh *const meshes[] = {&plane.mesh, &cube.mesh};
    static const size_t most[] = {1, 6};
    for (int i = 0; i < 2; ++i) {
        psplat_report report;
        psplat_splats splats = convert(meshes[i], 1, PSPLAT_USUAL_PRECISION, &report);
        assert_int_equal(psplat_report_broken(&report), PSPLAT_PROMISE_COUNT);
        assert_true(splats.precision.unit > 0);
        assert_int_equal(splats.count, most[i]);
        psplat_splats_free(&splats);
    }
    psplat_surface_free(&cube.surface);
    psplat_mesh_free(&cube.mesh);
    psplat_mesh_free(&plane.mesh);
}

/* Steps too fine for 16-bit integers give the same bits as floats. */
static void test_floats(void **state) {
    (void)state;
    fixture cube;
    psplat_report report;
    fixture_model(&cube, "cube.off");
    psplat_splats floats = convert(&cube.mesh, 1, 0, &report);
    psplat_splats fine = convert(&cube.mesh, 1, 0.001, &report);
    assert_true(floats.precision.unit == 0 && fine.precision.unit == 0);
    assert_int_equal(floats.count, fine.count);
    assert_memory_equal(floats.splats, fine.splats, floats.count * sizeof *floats.splats);
    psplat_splats_free(&floats);
    psplat_splats_free(&fine);
    fixture_free(&cube);
}

/* The position step is the requested one, up to the longest that keeps the promises; steps of
 * angles divide a full turn, and their codes fit 16-bit integers. */
static void test_steps(void **state) {
    (void)state;
    static const double asked[] = {0.05, 0.5, 4}, given[] = {0.05, 0.5, 0.5};
    fixture cube;
    psplat_report report;
    fixture_model(&cube, "cube.off");
    for (int i = 0; i < 3; ++i) {
        psplat_splats splats = convert(&cube.mesh, 1, asked[i], &report);
        const psplat_precision *p = &splats.precision;
        double tolerance = report.tolerance_percent / 100 * report.diagonal;
        assert_near(p->unit, given[i] * tolerance, 1e-12 * tolerance);
        assert_true(p->normal_bits >= 4 && p->normal_bits <= 14);
        const double turns[] = {p->turn_step, p->line_turn_step, p->line_step};
        for (int k = 0; k < 3; ++k) {
            assert_true(rint(1 / turns[k]) == 1 / turns[k]);
            assert_true(1 / turns[k] <= 32767);
        }
        assert_true(psplat_report_broken(&report) == PSPLAT_PROMISE_COUNT);
        psplat_splats_free(&splats);
    }
    fixture_free(&cube);
}

/* Returns the precision chosen for curved splats that face all ways, have one radius and err by so
 * much, both in tolerances. */
static psplat_precision precision_of(double radius, double deviation) {
    enum { COUNT = 200 };
    const psplat_convert_desc desc = {.precision = PSPLAT_USUAL_PRECISION};
    psplat_conversion c = {.desc = &desc, .tolerance = 1, .surface = {.diagonal = 1000}};
    uint64_t random = 3;
    for (int i = 0; i < COUNT; ++i) {
        psplat_candidate candidate = {
            .taken = 1,
            .covered_count = 1,
            .deviation = deviation,
            .region = {.radius = {radius, radius}, .hessian = {1e-6, 0, 0}}};
        psplat_region *r = &candidate.region;
        random_axes(&random, r->u, r->v, r->n);
        assert_true(psplat_selection_push(&c.selection, &candidate));
    }
    psplat_precision p = psplat_precision_choose(&c);
    psplat_selection_free(&c.selection);
    return p;
}

/* Steps are 1/255 for 9 bits and half of that for each bit more, up to 14. An error of half a step
 * in either direction may move a rim by 0.15 tolerances: this allows radii up to about 50
 * tolerances for 9 bits, and twice that for each bit more. */
static void test_normal_bits(void **state) {
    (void)state;
    assert_int_equal(precision_of(20, 0).normal_bits, 9);
    assert_int_equal(precision_of(200, 0).normal_bits, 12);
    assert_int_equal(precision_of(2000, 0).normal_bits, 14);
}

/* Steps are halved as often as splats may be smaller, but no more often than streams can say: seven
 * times (spec 3.12). Slopes have a step of 0.4 tolerances over the greatest radius, which is 0.1 at
 * most: 0.1 / 2^2 and a little less for 20 tolerances, 2^8 times less for 2000. */
static void test_grades(void **state) {
    (void)state;
    assert_int_equal(precision_of(20, 0).shape_grades, 2);
    assert_int_equal(precision_of(2000, 0).shape_grades, 7);
    assert_in_range(precision_of(2000, 0).normal_grades, 1, 7);
}

/* Where splats use up the tolerance, positions have steps of 3.5 of what is asked for, surfaces
 * such of three times as much, and N has a bit or two less: rims may move by 0.5 tolerances instead
 * of 0.15. In between, steps grow by equal factors: with 0.425, halfway from 0.25 to 0.6, by the
 * root. */
static void test_coarseness(void **state) {
    (void)state;
    const psplat_precision fine = precision_of(200, 0.25), coarse = precision_of(200, 0.6);
    const psplat_precision half = precision_of(200, 0.425), more = precision_of(200, 0.9);
    assert_near(fine.unit, precision_of(200, 0).unit, 1e-12);
    assert_near(coarse.unit, 3.5 * fine.unit, 1e-12);
    assert_near(half.unit, sqrt(3.5) * fine.unit, 1e-12);
    assert_near(more.unit, coarse.unit, 1e-12);
    assert_near(coarse.shape_step, 3 * fine.shape_step, 1e-12);
    assert_in_range(fine.normal_bits - coarse.normal_bits, 1, 2);
    assert_near(fine.scale_step, 0.025, 1e-12);
    assert_near(coarse.scale_step, 0.04, 1e-12);
}

int test_precision_main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat),   cmocka_unit_test(test_floats),
        cmocka_unit_test(test_steps),  cmocka_unit_test(test_normal_bits),
        cmocka_unit_test(test_grades), cmocka_unit_test(test_coarseness),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
